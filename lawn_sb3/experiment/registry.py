"""What a name stands for: algorithms and players without training.

Classes are named here, and imported when they are needed: they bring torch, and whoever misspelt a name should not wait
for that. What a recipe is checked against stands beside them; a test holds it against the classes.
"""

import inspect
from collections.abc import Iterable
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, NamedTuple

import lawn_sb3
from lawn_sb3.choices import Continuation
from lawn_sb3.errors import UserError, unknown_name

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.policies import BasePolicy

    from lawn_sb3.game.player import Player


class Algorithm(NamedTuple):
    """An algorithm."""

    classes: dict[str, str]
    """What its policies derive from, and its class for each; the first that fits counts."""
    default_policy: str
    settings: frozenset[str]
    """The arguments of its constructors that a recipe may give."""
    continuation: Continuation
    """How UAVs that are done have to go on in training."""
    takes_crowds: bool = False
    """Whether it can be trained in games with different numbers of UAVs."""


class Untrained(NamedTuple):
    """A player without training."""

    place: str
    """Its class."""
    settings: tuple[str, ...] = ()
    """The arguments of its constructor."""
    flies_alone: bool = False
    """Whether it gives every UAV a game of its own."""


_ALL = frozenset(
    {"batch_size", "device", "gamma", "learning_rate", "max_grad_norm", "policy_kwargs", "stats_window_size"}
)
_MAPPO_EPISODES = _ALL | {
    *("clip_range", "clip_range_vf", "ent_coef", "gae_lambda", "n_epochs", "n_steps", "normalize_advantage"),
    *("rollout_buffer_class", "rollout_buffer_kwargs", "target_kl", "vf_coef"),
    *("autocast", "clip_apart", "normalize_per_rollout", "normalize_value"),
}
_QMIX = _ALL | {
    *("buffer_size", "exploration_final_eps", "exploration_fraction", "exploration_initial_eps", "gradient_steps"),
    *("learning_starts", "replay_buffer_class", "replay_buffer_kwargs", "target_update_interval", "tau", "train_freq"),
    "double_q",
}
_MASKABLE = "sb3_contrib.common.maskable.policies:MaskableActorCriticPolicy"

ALGORITHMS: dict[str, Algorithm] = {
    "mappo": Algorithm(
        {
            _MASKABLE: "lawn_sb3.algos.mappo:MaskableMAPPO",
            "sb3_contrib.common.recurrent.policies:RecurrentActorCriticPolicy": "lawn_sb3.algos.mappo:RecurrentMAPPO",
            "stable_baselines3.common.policies:ActorCriticPolicy": "lawn_sb3.algos.mappo:MAPPO",
        },
        "centralized_critic",
        _MAPPO_EPISODES | {"sde_sample_freq", "use_sde"},
        "mission",
    ),
    "mappo-episodes": Algorithm(
        {_MASKABLE: "lawn_sb3.algos.mappo:EpisodeMAPPO"}, "knows_clock", _MAPPO_EPISODES, "episode", takes_crowds=True
    ),
    "imitate": Algorithm(
        {_MASKABLE: "lawn_sb3.algos.imitate:Imitate"},
        "knows_clock",
        _MAPPO_EPISODES | {"taught_fraction", "teacher"},
        "episode",
        takes_crowds=True,
    ),
    "iql": Algorithm(
        {
            "stable_baselines3.dqn.policies:DQNPolicy": "lawn_sb3.algos.iql:IQL",
            "sb3_contrib.qrdqn.policies:QRDQNPolicy": "lawn_sb3.algos.iql:IQL",
        },
        "local_q",
        _QMIX | {"n_steps", "share_parameters"},
        "mission",
    ),
    "qmix": Algorithm(
        {"lawn_sb3.algos.qmix:QMIXPolicy": "lawn_sb3.algos.qmix:QMIX"}, "monotonic_mixer", _QMIX, "episode"
    ),
}
_FIT = ("slack", "seed", "rounds", "episodes", "on_round")
_SEARCH = ("slack", "on_game", "starts")
PLANNERS: dict[str, Untrained] = {
    "shortest-path": Untrained("lawn_sb3.planning:ShortestPathPlayer"),
    "best-route": Untrained("lawn_sb3.planning:BestRoutePlayer", ("slack", "on_game")),
    "forecast": Untrained("lawn_sb3.planning:ForecastPlayer", ("slack",)),
    "mean-field": Untrained("lawn_sb3.planning:MeanFieldPlayer", _FIT),
    "mean-field-memory": Untrained("lawn_sb3.planning:MeanFieldMemoryPlayer", _FIT),
    "mean-field-destinations": Untrained("lawn_sb3.planning:MeanFieldDestinationsPlayer", _FIT),
    "equilibrium": Untrained("lawn_sb3.planning:EquilibriumPlayer", _SEARCH),
    "worst-equilibrium": Untrained("lawn_sb3.planning:WorstEquilibriumPlayer", _SEARCH),
    "welfare": Untrained("lawn_sb3.planning:WelfarePlayer", _SEARCH),
    "bound": Untrained("lawn_sb3.planning:BoundPlayer", ("on_game",), flies_alone=True),
}
PLAYERS: dict[str, Untrained] = {"random": Untrained("lawn_sb3.game.player:RandomPlayer"), **PLANNERS}

REPOSITORY = Path(lawn_sb3.__file__).parents[1]


def find_algorithm(name: str, policy: "type[BasePolicy]") -> "type[BaseAlgorithm]":
    """Find the class of an algorithm that takes a policy.

    :param name: the algorithm's name, such as ``mappo``
    :param policy: the policy class
    :return: the class
    :raises UserError: if there is none of that name, or the policy derives from something else
    """
    if name not in ALGORITHMS:
        raise unknown_name("algorithm", name, ALGORITHMS)
    classes = classes_of(name)
    for base, algorithm in classes.items():
        if issubclass(policy, base):
            return algorithm
    other = algorithm_for(policy)
    hint = f": it is a policy for {other}" if other is not None else ""
    allowed = " or ".join(f"{base.__module__}.{base.__name__}" for base in classes)
    raise UserError(
        f"policy class {policy.__name__} ({place(policy)}) does not fit {name}{hint}; {name} takes what derives from "
        f"{allowed}"
    )


def classes_of(name: str) -> "dict[type[BasePolicy], type[BaseAlgorithm]]":
    """What the policies of an algorithm derive from, and its class for each; the first that fits counts."""
    return {resolve_name(base): resolve_name(own) for base, own in ALGORITHMS[name].classes.items()}


def algorithm_for(policy: "type[BasePolicy]") -> str | None:
    """The name of the algorithm that a policy is for; none if no algorithm takes it."""
    return next((name for name in ALGORITHMS if issubclass(policy, tuple(classes_of(name)))), None)


def place(policy: "type[BasePolicy]") -> str:
    """The file that holds a policy, for messages, as short as the working directory allows; its module without one."""
    try:
        path = Path(inspect.getfile(policy))
    except (TypeError, OSError):
        return f"module {policy.__module__}"
    for folder in (Path.cwd(), REPOSITORY):
        if path.is_relative_to(folder):
            return path.relative_to(folder).as_posix()
    return str(path)


def find_player(name: str) -> "Player":
    """Find a player that needs no training.

    :param name: its name, such as ``random``
    :return: a new player
    :raises UserError: if there is none of that name
    """
    check_player(name)
    player: Player = resolve_name(PLAYERS[name].place)()
    return player


def check_player(name: str) -> None:
    """Refuse a name that no player without training has."""
    if name not in PLAYERS:
        raise unknown_name("player", name, PLAYERS)


def make_planner(name: str, **settings: Any) -> "Player":
    """Build a planner with settings of its own.

    :param name: its name, such as ``equilibrium``
    :param settings: what to change: ``slack``, ``starts``; ``on_game`` is left out where a planner does not take it
    :return: the player
    :raises UserError: if there is none of that name, or it has no such setting
    """
    check_planner(name, settings)
    taken = {key: value for key, value in settings.items() if key in PLANNERS[name].settings}
    player: Player = resolve_name(PLANNERS[name].place)(**taken)
    return player


def check_planner(name: str, settings: Iterable[str]) -> None:
    """Refuse a name that no planner has, or a setting that it does not take."""
    if name not in PLANNERS:
        raise unknown_name("planner", name, PLANNERS)
    known = PLANNERS[name].settings
    for key in settings:
        if key not in known and key != "on_game":
            taken = ", ".join(setting for setting in known if setting != "on_game")
            raise UserError(f"planner {name!r} has no {key}: it takes {taken or 'none'}")
