"""SuperSuit's flattening of the game into an SB3 vector environment, and the adapter that mends it.

SuperSuit drops seeds, hides attributes, lets copies of an environment play the same game, and reports the end of an
episode only when it ends for everybody. The environment underneath therefore reports each mission's end in the infos,
and the adapter translates that into SB3's conventions.
"""

import inspect
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
import supersuit
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvObs, VecEnvStepReturn, tile_images

from lawn_sb3.choices import Continuation, Credit, RewardTerm
from lawn_sb3.envs.observation import Extra
from lawn_sb3.envs.training_env import Timeout, TrainingEnv, not_started
from lawn_sb3.errors import UserError
from lawn_sb3.scenario import Scenario

MOST_PICTURES = 16
"""Games that are drawn; more would be too small to see."""


class FlatVecEnv(VecEnvWrapper):
    """SB3's view of a flattened game: one slot per UAV, done at the end of each mission.

    :param venv: what ``supersuit.concat_vec_envs_v1(..., base_class="stable_baselines3")`` returned
    :param games: the environments inside it, in order
    :param seed: seed of the missions; every environment inside gets a stream of its own
    """

    def __init__(self, venv: VecEnv, games: Sequence[TrainingEnv], seed: int | None = None) -> None:
        self.games = list(games)
        self._agents = [(game, agent) for game in self.games for agent in range(len(game.possible_agents))]
        super().__init__(venv, observation_space=venv.observation_space, action_space=venv.action_space)
        self.seed(seed)

    def __getstate__(self) -> dict[str, Any]:
        """What a copy is made of: all but what SB3 remembers of the class, which cannot be pickled."""
        return {key: value for key, value in vars(self).items() if key != "class_attributes"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Become a copy."""
        vars(self).update(state, class_attributes=dict(inspect.getmembers(type(self))))

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed the missions from the next reset on, each environment inside with a stream of its own.

        :param seed: the seed; without one it is drawn
        :return: the seed that each slot's environment will be reset with
        """
        children = np.random.SeedSequence(seed).spawn(len(self.games))
        own = [int(child.generate_state(1, np.uint64)[0]) for child in children]
        self._next_seeds: list[int] | None = own
        return [seed for game, seed in zip(self.games, own, strict=True) for _ in game.possible_agents]

    def reset(self) -> VecEnvObs:
        """Start all games anew; seeded if :meth:`seed` was called since the last reset.

        :return: observations, one row per slot
        """
        observations = self.venv.reset()
        if self._next_seeds is not None:
            # SuperSuit drops the seed of a reset, so the games are reset once more, each with its own.
            rows: list[NDArray[np.float32]] = []
            for game, seed in zip(self.games, self._next_seeds, strict=True):
                rows.extend(game.reset(seed=seed)[0].values())
            observations = np.stack(rows)
            self._next_seeds = None
        self.reset_infos = [{} for _ in range(self.num_envs)]
        return observations

    def step_async(self, actions: NDArray[np.integer]) -> None:
        """Begin a step.

        :param actions: one for each slot [num_envs]
        :raises UserError: if they are others, or the games were not started
        """
        if not all(game.started for game in self.games):
            raise not_started()
        chosen = np.asarray(actions)
        if chosen.shape != (self.num_envs,) or not np.issubdtype(chosen.dtype, np.integer):
            what = f"{chosen.dtype} of shape {chosen.shape}"
            raise UserError(f"actions are {what}: must be {self.num_envs} whole numbers, one for each slot")
        self.venv.step_async(chosen)

    def step_wait(self) -> VecEnvStepReturn:
        """Finish a step: observations, rewards, dones (a mission ended) and infos, one per slot."""
        observations, rewards, _, infos = self.venv.step_wait()
        dones = np.fromiter(("episode" in info for info in infos), dtype=bool, count=self.num_envs)
        return observations, rewards, dones, infos

    def _behind(self, indices: VecEnvIndices) -> list[tuple[TrainingEnv, int]]:
        """The environment behind each of the given slots, and which of its agents the slot is."""
        return [self._agents[index] for index in self._get_indices(indices)]

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Read an attribute of the environment behind each slot."""
        return [getattr(game, attr_name) for game, _ in self._behind(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Write an attribute of the environments behind some slots."""
        for game, _ in self._behind(indices):
            setattr(game, attr_name, value)

    def has_attr(self, attr_name: str) -> bool:
        """Whether all environments inside have an attribute."""
        return all(hasattr(game, attr_name) for game in self.games)

    def set_options(self, options: list[dict[str, Any]] | dict[str, Any] | None = None) -> None:
        """Refuse reset options: the games know none.

        :raises UserError: if there are any
        """
        if options:
            raise UserError("the training environment knows no reset options; LawnEnv takes missions by hand")

    def render(self, mode: str | None = None) -> NDArray[np.uint8]:
        """Draw the first games from above, side by side.

        :param mode: ``rgb_array``, also by default
        :return: a picture [height, width, 3] of up to 16 games
        :raises UserError: if the mode is another
        """
        if mode not in (None, "rgb_array"):
            raise UserError(f"render mode {mode!r}: rgb_array alone, a picture as an array")
        return np.asarray(tile_images(self.get_images()))

    def get_images(self) -> Sequence[NDArray[np.uint8]]:
        """A picture [480, 480, 3] of each of the first 16 games."""
        pictures: list[NDArray[np.uint8]] = []
        for game in self.games:
            pictures += game.render(MOST_PICTURES - len(pictures))
        return pictures

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the environments behind some slots, once each.

        :param method_name: name of the method
        :param method_args: its positional arguments
        :param indices: slots, all by default
        :param method_kwargs: its keyword arguments
        :return: one result per slot: its own row if the method answers with one row per agent, otherwise what its
            environment returned
        """
        behind = self._behind(indices)
        results = {
            game: getattr(game, method_name)(*method_args, **method_kwargs)
            for game in dict.fromkeys(game for game, _ in behind)
        }
        if method_name in TrainingEnv.row_per_agent:
            return [results[game][agent] for game, agent in behind]
        return [results[game] for game, _ in behind]

    def action_masks(self) -> NDArray[np.bool_]:
        """Which moves are allowed, one row per slot [num_envs, A]."""
        return np.concatenate([game.action_masks() for game in self.games])

    def flying(self) -> NDArray[np.bool_]:
        """Who is in the air [num_envs]; the others wait for their game to restart."""
        return np.concatenate([game.flying() for game in self.games])

    def env_is_wrapped(self, wrapper_class: type[Any], indices: VecEnvIndices = None) -> list[bool]:
        """Whether a Gymnasium wrapper lies around the environments: never, they are PettingZoo's."""
        return [False for _ in self._get_indices(indices)]


def make_vec_env(
    scenario: Scenario,
    num_games: int = 64,
    *,
    copies: int = 1,
    seed: int | None = None,
    continuation: Continuation = "mission",
    timeout: Timeout = "terminal",
    without_reward: Collection[RewardTerm] = (),
    extras: Collection[Extra] = (),
    slack: int | None = None,
    credit: Credit = "own",
    fewest_uavs: int | None = None,
) -> FlatVecEnv:
    """Flatten the game into a vector environment for SB3, through SuperSuit.

    :param scenario: the constants of the game
    :param num_games: games G played in one compiled call
    :param copies: how many such environments to lay side by side; one is fastest
    :param seed: seed of the missions
    :param continuation: ``mission`` (a new mission at once) or ``episode`` (wait for the game to restart)
    :param timeout: ``terminal``, as in the paper, or ``truncated`` (SB3 then bootstraps the value)
    :param without_reward: terms of the reward that the learner is not given: ``rate``, ``nav``, ``col``, ``term``
    :param extras: what the observations hold between o_i and x: ``clock``, ``memory``, ``destinations``, ``intents``,
        ``index``
    :param slack: allow only moves that keep arrival within T_i^min + ``slack`` slots possible; by default, all moves
        inside the airspace
    :param credit: whose reward a learner is given: ``own``, ``difference`` or ``team``
    :param fewest_uavs: each new game has ``fewest_uavs`` to N UAVs (``episode`` only); by default all N
    :return: a vector environment of copies * G * N slots
    :raises UserError: if an argument is not allowed
    """
    if copies < 1:
        raise UserError(f"copies = {copies}: at least 1")
    games = TrainingEnv(
        scenario, num_games, continuation, timeout, seed, without_reward, extras, slack, credit, fewest_uavs
    )
    venv = supersuit.concat_vec_envs_v1(
        supersuit.pettingzoo_env_to_vec_env_v1(games), copies, base_class="stable_baselines3"
    )
    inside = [vec_env.par_env for vec_env in venv.venv.vec_envs]
    return FlatVecEnv(venv, inside, seed)
