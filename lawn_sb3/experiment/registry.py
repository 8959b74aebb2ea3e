"""What a name stands for: algorithms and players without training."""

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import BasePolicy

import lawn_sb3
from lawn_sb3 import planning
from lawn_sb3.algos.imitate import Imitate
from lawn_sb3.algos.iql import IQL, LEARNERS
from lawn_sb3.algos.mappo import MAPPO, EpisodeMAPPO, MaskableMAPPO, RecurrentMAPPO
from lawn_sb3.algos.qmix import QMIX, QMIXPolicy
from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.game.player import Player, RandomPlayer

ALGORITHMS: dict[str, dict[type[BasePolicy], type[BaseAlgorithm]]] = {
    "mappo": {algorithm.policy_base: algorithm for algorithm in (MaskableMAPPO, RecurrentMAPPO, MAPPO)},
    "mappo-episodes": {EpisodeMAPPO.policy_base: EpisodeMAPPO},
    "imitate": {Imitate.policy_base: Imitate},
    "iql": dict.fromkeys(LEARNERS, IQL),
    "qmix": {QMIXPolicy: QMIX},
}
"""What the policies of an algorithm derive from, and its class for each; the first that fits counts."""
DEFAULT_POLICIES: dict[str, str] = {
    "mappo": "centralized_critic",
    "mappo-episodes": "knows_clock",
    "imitate": "knows_clock",
    "iql": "local_q",
    "qmix": "monotonic_mixer",
}
PLANNERS: dict[str, Callable[[], Player]] = {
    "shortest-path": planning.ShortestPathPlayer,
    "best-route": planning.BestRoutePlayer,
    "forecast": planning.ForecastPlayer,
    "mean-field": planning.MeanFieldPlayer,
    "mean-field-memory": planning.MeanFieldMemoryPlayer,
    "mean-field-destinations": planning.MeanFieldDestinationsPlayer,
    "equilibrium": planning.EquilibriumPlayer,
    "worst-equilibrium": planning.WorstEquilibriumPlayer,
    "welfare": planning.WelfarePlayer,
    "bound": planning.BoundPlayer,
}
PLAYERS: dict[str, Callable[[], Player]] = {"random": RandomPlayer, **PLANNERS}

REPOSITORY = Path(lawn_sb3.__file__).parents[1]


def find_algorithm(name: str, policy: type[BasePolicy]) -> type[BaseAlgorithm]:
    """Find the class of an algorithm that takes a policy.

    :param name: the algorithm's name, such as ``mappo``
    :param policy: the policy class
    :return: the class
    :raises UserError: if there is none of that name, or the policy derives from something else
    """
    if name not in ALGORITHMS:
        raise unknown_name("algorithm", name, ALGORITHMS)
    for base, algorithm in ALGORITHMS[name].items():
        if issubclass(policy, base):
            return algorithm
    other = algorithm_for(policy)
    hint = f": it is a policy for {other}" if other is not None else ""
    allowed = " or ".join(f"{base.__module__}.{base.__name__}" for base in ALGORITHMS[name])
    raise UserError(
        f"policy class {policy.__name__} ({place(policy)}) does not fit {name}{hint}; {name} takes what derives from "
        f"{allowed}"
    )


def algorithm_for(policy: type[BasePolicy]) -> str | None:
    """The name of the algorithm that a policy is for; none if no algorithm takes it."""
    return next((name for name, bases in ALGORITHMS.items() if issubclass(policy, tuple(bases))), None)


def trait(name: str, attribute: str, default: Any = None) -> Any:
    """A class attribute that all classes of an algorithm have alike, such as ``continuation``."""
    return getattr(next(iter(ALGORITHMS[name].values())), attribute, default)


def place(policy: type[BasePolicy]) -> str:
    """The file that holds a policy, for messages, as short as the working directory allows; its module without one."""
    try:
        path = Path(inspect.getfile(policy))
    except (TypeError, OSError):
        return f"module {policy.__module__}"
    for folder in (Path.cwd(), REPOSITORY):
        if path.is_relative_to(folder):
            return path.relative_to(folder).as_posix()
    return str(path)


def find_player(name: str) -> Player:
    """Find a player that needs no training.

    :param name: its name, such as ``random``
    :return: a new player
    :raises UserError: if there is none of that name
    """
    if name not in PLAYERS:
        raise unknown_name("player", name, PLAYERS)
    return PLAYERS[name]()
