"""Joint replay: the flat slots regrouped into games, one joint transition per entry."""

from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np
import torch as th
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.buffers import ReplayBuffer
from stable_baselines3.common.vec_env import VecNormalize

from lawn_sb3.envs.observation import ObservationLayout, Sight, space_of

STORED = ("observations", "next_observations", "actions", "rewards", "dones", "flying", "next_flying")
"""The arrays that hold the transitions."""


class JointSamples(NamedTuple):
    """A batch of joint transitions."""

    local: th.Tensor
    """Local observations o_i and what else is seen [B, N, anything]."""
    state: th.Tensor
    """Global states x [B, state_dim]."""
    actions: th.Tensor
    """Joint actions [B, N]."""
    rewards: th.Tensor
    """Team rewards [B]."""
    flying: th.Tensor
    """Who was flying and thus acted [B, N]."""
    next_local: th.Tensor
    """Local observations one slot later [B, N, anything]."""
    next_state: th.Tensor
    """Global states one slot later [B, state_dim]."""
    next_flying: th.Tensor
    """Who was flying one slot later [B, N]."""
    game_over: th.Tensor
    """Whether nobody was [B]."""


class JointReplayBuffer(ReplayBuffer):
    """SB3's replay of games instead of slots: an entry is one slot of one whole game.

    Slot g * N + i of the vector environment is UAV i of game g, and a UAV that is done waits until its game restarts
    (``continuation="episode"``). The buffer follows who is flying from the dones; a game is over when nobody is. A UAV
    that was cut off by a truncation has stopped flying, but its transition says that it flies on, so that its value
    is bootstrapped. The team reward is the mean of the rewards of all N UAVs; those that wait earn 0.

    :param buffer_size: joint transitions kept, over all games
    :param observation_space: the flat observation [o_i | x] of one slot
    :param action_space: the actions of one UAV
    :param device: where samples go
    :param n_envs: slots G * N of the vector environment
    :param optimize_memory_usage: as in SB3; must be false
    :param layout: where o_i and x lie in the flat observation
    :param sees: what the policy sees besides o_i; kept with it
    :raises ValueError: if the slots are not whole games
    """

    def __init__(
        self,
        buffer_size: int,
        observation_space: spaces.Space[Any],
        action_space: spaces.Space[Any],
        device: th.device | str = "auto",
        n_envs: int = 1,
        optimize_memory_usage: bool = False,
        *,
        layout: ObservationLayout,
        sees: Collection[Sight] = (),
    ) -> None:
        if optimize_memory_usage:
            raise ValueError("optimize_memory_usage = True: joint replay keeps next observations, give False")
        num_games, rest = divmod(n_envs, layout.num_uavs)
        if rest:
            raise ValueError(f"{n_envs} slots are no whole number of games of {layout.num_uavs} UAVs")
        assert isinstance(action_space, spaces.Discrete)
        self.layout, self.seen = layout, layout.seen(sees)
        self._shape = (num_games, layout.num_uavs)
        joint_dim = layout.num_uavs * self.seen.stop + layout.state_dim
        super().__init__(
            buffer_size,
            space_of(joint_dim),
            spaces.MultiDiscrete([int(action_space.n)] * layout.num_uavs),
            device,
            n_envs=num_games,
            handle_timeout_termination=False,
        )
        self.flying = np.zeros((self.buffer_size, *self._shape), dtype=bool)  # [size, G, N]
        self.next_flying = np.zeros_like(self.flying)
        self.start_games()

    def start_games(self) -> None:
        """Note that the environment was reset: all UAVs fly."""
        self.now_flying = np.ones(self._shape, dtype=bool)  # [G, N]

    def add(
        self,
        obs: NDArray[Any],
        next_obs: NDArray[Any],
        action: NDArray[Any],
        reward: NDArray[Any],
        done: NDArray[Any],
        infos: list[dict[str, Any]],
    ) -> None:
        """Store one slot of all games, and follow who is flying.

        :param obs: flat observations [G * N, flat_dim]
        :param next_obs: flat observations one slot later; a slot that is done has its terminal one
        :param action: actions [G * N]
        :param reward: rewards [G * N]
        :param done: whose missions ended [G * N]
        :param infos: infos, one per slot
        """
        flying, ended = self.now_flying, done.astype(bool).reshape(self._shape)
        truncated = np.array([info.get("TimeLimit.truncated", False) for info in infos], dtype=bool)
        next_flying = flying & (~ended | truncated.reshape(self._shape))
        over = ~(flying & ~ended).any(axis=1)  # [G]
        before, after = (rows.reshape(*self._shape, self.layout.flat_dim) for rows in (obs, next_obs))
        # A game that is over has restarted already: the last of its x is with a UAV whose mission ended in this slot,
        # and who had been waiting sees the new game.
        last = ended.argmax(axis=1)
        waiting = (over[:, None] & ~flying)[..., None]
        after_local = np.where(waiting, before[..., self.seen], after[..., self.seen])
        self.flying[self.pos], self.next_flying[self.pos] = flying, next_flying
        super().add(
            self._joint(before[..., self.seen], before[:, 0, self.layout.state]),
            self._joint(after_local, after[np.arange(len(last)), last, self.layout.state]),
            action.reshape(self._shape),
            reward.reshape(self._shape).mean(axis=1),
            ~next_flying.any(axis=1),
            [{}] * len(last),
        )
        self.now_flying = (flying & ~ended) | over[:, None]

    @staticmethod
    def _joint(local: NDArray[Any], state: NDArray[Any]) -> NDArray[Any]:
        """Joint observations [G, N * anything + state_dim]."""
        return np.concatenate([local.reshape(len(local), -1), state], axis=1)

    def sample(self, batch_size: int, env: VecNormalize | None = None) -> JointSamples:  # type: ignore[override]
        """Draw joint transitions at random, with replacement.

        :param batch_size: joint transitions
        :param env: must be none
        :return: the batch
        """
        samples: Any = super().sample(batch_size, env)
        assert isinstance(samples, JointSamples)
        return samples

    def _get_samples(  # type: ignore[override]
        self, batch_inds: NDArray[np.integer[Any]], env: VecNormalize | None = None
    ) -> JointSamples:
        assert env is None, "joint replay knows no normalisation"
        entry = batch_inds, np.random.randint(0, self.n_envs, size=len(batch_inds))
        local, state = self._split(self.observations[entry])
        next_local, next_state = self._split(self.next_observations[entry])
        return JointSamples(
            local=local,
            state=state,
            actions=self.to_torch(self.actions[entry]).long(),
            rewards=self.to_torch(self.rewards[entry]),
            flying=self.to_torch(self.flying[entry]),
            next_local=next_local,
            next_state=next_state,
            next_flying=self.to_torch(self.next_flying[entry]),
            game_over=self.to_torch(self.dones[entry]),
        )

    def _split(self, joint: NDArray[Any]) -> tuple[th.Tensor, th.Tensor]:
        """Joint observations as local observations [B, N, anything] and global states [B, state_dim]."""
        tensor, end = self.to_torch(joint, copy=False), self.layout.num_uavs * self.seen.stop
        return tensor[:, :end].reshape(len(joint), self.layout.num_uavs, -1), tensor[:, end:]

    def content(self) -> dict[str, Any]:
        """All that the buffer holds, without the room that is still empty."""
        arrays = {name: getattr(self, name)[: self.size()].copy() for name in STORED}
        return {**arrays, "pos": self.pos, "full": self.full, "now_flying": self.now_flying.copy()}

    def restore(self, content: dict[str, Any]) -> None:
        """Go back to what a buffer of the same size held when :meth:`content` returned it."""
        for name in STORED:
            getattr(self, name)[: len(content[name])] = content[name]
        self.pos, self.full = content["pos"], content["full"]
        self.now_flying = content["now_flying"].copy()
