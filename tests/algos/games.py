"""Games whose every number can be worked out by hand."""

from types import SimpleNamespace
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from lawn_sb3.envs import ObservationLayout
from lawn_sb3.envs.observation import space_of


class ScriptedVecEnv(VecEnv):
    """A vector environment of whole games that a subclass plays; nothing but SB3's interface and a layout."""

    def __init__(self, num_games: int, layout: ObservationLayout, num_actions: int) -> None:
        self.num_games = num_games
        self.layout = layout
        self.render_mode = None
        super().__init__(num_games * layout.num_uavs, space_of(layout.flat_dim), spaces.Discrete(num_actions))

    def step_async(self, actions: NDArray[Any]) -> None:
        self.actions = np.asarray(actions).reshape(self.num_games, self.layout.num_uavs)

    def close(self) -> None:
        """Nothing to free."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        setattr(self, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        return [getattr(self, method_name)(*args, **kwargs) for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False for _ in self._get_indices(indices)]


class MatrixGame(ScriptedVecEnv):
    """A one-step game of two players who see nothing: the payoff [first, second] of their actions is both's reward."""

    def __init__(self, payoff: Any, num_games: int = 16) -> None:
        self.payoff = np.asarray(payoff, dtype=np.float32)
        super().__init__(num_games, ObservationLayout(2, 0), len(self.payoff))
        self.nothing = np.zeros((self.num_envs, self.layout.flat_dim), dtype=np.float32)
        # The Q-network is shared: only what a player sees of itself can tell the second from the first.
        self.nothing[1::2, 0] = self.nothing[:, self.layout.local_dim + 8] = 1.0

    def reset(self) -> NDArray[Any]:
        return self.nothing.copy()

    def step_wait(self) -> Any:
        rewards = np.repeat(self.payoff[self.actions[:, 0], self.actions[:, 1]], 2)
        infos = [{"terminal_observation": row} for row in self.nothing]
        return self.nothing.copy(), rewards, np.ones(self.num_envs, dtype=bool), infos


class Countdown(ScriptedVecEnv):
    """Games in which UAV i of game g is done after (i + g) % 3 + 1 slots; every number tells game, UAV, round, slot.

    A number is ``10000 * game + 1000 * UAV + 10 * round + slot`` in o_i and the same with UAV 9 in x.
    """

    def __init__(self, num_games: int = 3, num_uavs: int = 2) -> None:
        super().__init__(num_games, ObservationLayout(num_uavs, 0), 5)
        games, uavs = np.indices((num_games, num_uavs))
        self.names = 10_000 * games + 1_000 * uavs
        self.duration = (uavs + games) % 3 + 1
        self.clock = SimpleNamespace(round=np.zeros(num_games, dtype=int), slot=np.zeros(num_games, dtype=int))

    def observe(self) -> NDArray[Any]:
        time = 10 * self.clock.round + self.clock.slot  # [G]
        flat = np.empty((self.num_games, self.layout.num_uavs, self.layout.flat_dim), dtype=np.float32)
        flat[..., self.layout.local] = (self.names + time[:, None])[..., None]
        flat[..., self.layout.state] = (self.names[:, :1] + 9_000 + time[:, None])[..., None]
        return flat.reshape(self.num_envs, -1)

    def reset(self) -> NDArray[Any]:
        self.clock.round[:] = self.clock.slot[:] = 0
        return self.observe()

    def step_wait(self) -> Any:
        flew = self.clock.slot[:, None] < self.duration
        rewards = np.where(flew, self.names + self.actions, 0.0).astype(np.float32)
        self.clock.slot += 1
        ended = (flew & (self.clock.slot[:, None] >= self.duration)).ravel()
        last = self.observe()
        infos = [{"terminal_observation": last[k]} if ended[k] else {} for k in range(self.num_envs)]
        over = self.clock.slot >= self.duration.max(axis=1)
        self.clock.round[over] += 1
        self.clock.slot[over] = 0
        return self.observe(), rewards.ravel(), ended, infos
