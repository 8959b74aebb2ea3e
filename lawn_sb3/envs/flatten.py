"""SuperSuit's flattening of the game into an SB3 vector environment, and the adapter that mends it.

SuperSuit drops seeds, hides attributes, lets copies of an environment play the same game and reports the end of an
episode only when it ends for everybody. The environment underneath therefore reports each mission's end in the infos,
and the adapter turns that into SB3's conventions.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
import supersuit
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvObs, VecEnvStepReturn

from lawn_sb3.envs.observation import Extra
from lawn_sb3.envs.training_env import Credit, Timeout, TrainingEnv
from lawn_sb3.errors import UserError
from lawn_sb3.game.simulator import Continuation
from lawn_sb3.game.state import RewardTerm
from lawn_sb3.scenario import Scenario


class FlatVecEnv(VecEnvWrapper):
    """SB3's view of a flattened game: one slot a UAV, done at the end of each mission.

    :param venv: what ``supersuit.concat_vec_envs_v1(..., base_class="stable_baselines3")`` returned
    :param games: the environments inside it, in order
    :param seed: seed of the missions; every environment inside gets a stream of its own
    """

    def __init__(self, venv: VecEnv, games: Sequence[TrainingEnv], seed: int | None = None) -> None:
        self.games = list(games)
        self._slots = np.repeat(np.arange(len(self.games)), [len(game.possible_agents) for game in self.games])
        super().__init__(venv, observation_space=venv.observation_space, action_space=venv.action_space)
        self.seed(seed)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed the missions from the next reset on, each environment inside with a stream of its own.

        :param seed: the seed; none draws one
        :return: the seed each slot's environment will be reset with
        """
        children = np.random.SeedSequence(seed).spawn(len(self.games))
        own = [int(child.generate_state(1, np.uint64)[0]) for child in children]
        self._next_seeds: list[int] | None = own
        return [own[game] for game in self._slots]

    def reset(self) -> VecEnvObs:
        """Start all games anew; seeded if :meth:`seed` was called since the last reset.

        :return: observations, one row a slot
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

    def step_wait(self) -> VecEnvStepReturn:
        """Finish a step.

        :return: observations, rewards, dones (a mission ended) and infos, one a slot
        """
        observations, rewards, _, infos = self.venv.step_wait()
        dones = np.fromiter(("episode" in info for info in infos), dtype=bool, count=self.num_envs)
        return observations, rewards, dones, infos

    def _indices(self, indices: VecEnvIndices) -> list[int]:
        """Which environments inside the given slots belong to, one entry a slot."""
        return [int(self._slots[index]) for index in self._get_indices(indices)]

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Read an attribute of the environment behind each slot.

        :param attr_name: name of the attribute
        :param indices: slots, all by default
        :return: one value a slot
        """
        return [getattr(self.games[game], attr_name) for game in self._indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Write an attribute of the environments behind some slots.

        :param attr_name: name of the attribute
        :param value: its value
        :param indices: slots, all by default
        """
        for game in set(self._indices(indices)):
            setattr(self.games[game], attr_name, value)

    def has_attr(self, attr_name: str) -> bool:
        """Whether all environments inside have an attribute.

        :param attr_name: its name
        :return: true if they do
        """
        return all(hasattr(game, attr_name) for game in self.games)

    def set_options(self, options: list[dict[str, Any]] | dict[str, Any] | None = None) -> None:
        """Refuse options: the games know none.

        :param options: nothing, or empty
        :raises UserError: if there are any
        """
        if options:
            raise UserError("the training environment knows no reset options; LawnEnv takes missions by hand")

    def get_images(self) -> Sequence[None]:
        """Pictures of the games: none; render one with LawnEnv.

        :return: nothing for each slot
        """
        return [None] * self.num_envs

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the environments behind some slots, once each.

        :param method_name: name of the method
        :param method_args: its positional arguments
        :param indices: slots, all by default
        :param method_kwargs: its keyword arguments
        :return: the results, one a slot; slots of one environment share its result
        """
        slots = self._indices(indices)
        if method_name == "action_masks":  # sb3-contrib asks every slot for its own
            masks = self.action_masks()
            return [masks[slot] for slot in self._get_indices(indices)]
        results = {
            game: getattr(self.games[game], method_name)(*method_args, **method_kwargs) for game in dict.fromkeys(slots)
        }
        return [results[game] for game in slots]

    def action_masks(self) -> NDArray[np.bool_]:
        """Which moves are allowed.

        :return: true for a move that is, one row a slot [num_envs, A]
        """
        return np.concatenate([game.action_masks() for game in self.games])

    def flying(self) -> NDArray[np.bool_]:
        """Who is in the air; the others wait for their game to restart.

        :return: one answer a slot [num_envs]
        """
        return np.concatenate([game.simulator.state.flying.ravel() for game in self.games])

    def env_is_wrapped(self, wrapper_class: type[Any], indices: VecEnvIndices = None) -> list[bool]:
        """Whether a Gymnasium wrapper lies around the environments: never, they are PettingZoo's.

        :param wrapper_class: the wrapper
        :param indices: slots, all by default
        :return: one answer a slot
        """
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
    :param timeout: ``terminal`` (eq:terminal) or ``truncated`` (SB3 then bootstraps the value)
    :param without_reward: terms of the reward that the learner is not given: ``rate``, ``nav``, ``col``, ``term``
    :param extras: what the observations hold between o_i and x: ``clock``, ``memory``, ``destinations``, ``intents``,
        ``index``
    :param slack: allow in-time moves alone, by T_i^min and so many slots; without a number, all inside the airspace
    :param credit: whose reward a learner is given: ``own``, ``difference`` or ``team``
    :param fewest_uavs: games of so many to N UAVs, drawn anew for each (``episode``); all N without a number
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
