"""MAPPO on batches of whole episodes: every game of a batch is played from its start to its end, without bootstrapping.

UAVs that have arrived wait for their game to end: nobody asks the networks about them, and their slots teach nothing.
"""

from collections.abc import Generator
from typing import Any, ClassVar

import numpy as np
import torch as th
from gymnasium import spaces
from numpy.typing import NDArray
from sb3_contrib.common.maskable.buffers import MaskableRolloutBufferSamples
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from lawn_sb3.algos.mappo.value_normalization import NormalizedMaskableBuffer
from lawn_sb3.algos.mappo.variants import MaskableMAPPO
from lawn_sb3.envs.flatten import FlatVecEnv


class EpisodeBuffer(NormalizedMaskableBuffer):
    """SB3's rollout buffer for episodes of unequal length: it holds the slots of the UAVs that flew, and no others."""

    def reset(self) -> None:
        """Forget everything."""
        self._slots: list[tuple[NDArray[Any], ...]] = []
        self._rewards: list[NDArray[np.float32]] = []  # of all UAVs, also of those that wait [G * N]
        assert isinstance(self.action_space, spaces.Discrete)
        self.mask_dims = int(self.action_space.n)
        self.observations = np.zeros((0, *self.obs_shape), dtype=np.float32)
        self.values = self.returns = np.zeros(0, dtype=np.float32)
        self.pos, self.full, self.generator_ready = 0, False, True

    def add_slot(
        self,
        flying: NDArray[np.bool_],
        rewards: NDArray[np.float32],
        obs: NDArray[np.float32],
        actions: NDArray[np.int64],
        values: NDArray[np.float32],
        log_probs: NDArray[np.float32],
        masks: NDArray[np.bool_],
    ) -> None:
        """Add one slot of all games.

        :param flying: who acted [G * N]
        :param rewards: rewards, also of those that wait [G * N]
        :param obs: flat observations of those that acted, as all that follows [R, flat_dim]
        :param actions: their actions [R]
        :param values: the critic's values [R]
        :param log_probs: log-probabilities of the actions [R]
        :param masks: which actions were allowed [R, A]
        """
        self._slots.append((flying.copy(), obs, actions, values, log_probs, masks))
        self._rewards.append(rewards.astype(np.float32))
        self.pos += 1

    def finish(self) -> None:
        """Work out advantages (Eq. (20), eq:gae) and returns of whole episodes; what follows one is worth 0.

        A UAV's reward while it waits, as a team's may be, counts for the slot in which it arrived.
        """
        flying = np.stack([slot[0] for slot in self._slots])  # [T, G * N]
        values = np.zeros(flying.shape, dtype=np.float32)
        values[flying] = np.concatenate([slot[3] for slot in self._slots])
        advantages = np.zeros_like(values)
        later = np.zeros(flying.shape[1], dtype=np.float32)  # rewards after the arrival, discounted
        next_value, next_advantage = np.zeros_like(later), np.zeros_like(later)
        for t in range(len(flying) - 1, -1, -1):
            flies, reward = flying[t], self._rewards[t] + self.gamma * later
            delta = reward + self.gamma * next_value - values[t]
            next_advantage = np.where(flies, delta + self.gamma * self.gae_lambda * next_advantage, 0.0)
            advantages[t], next_value = next_advantage, values[t]
            later = np.where(flies, 0.0, reward)
        self.observations, self.actions, self.values, self.log_probs, self.action_masks = (
            np.concatenate([slot[k] for slot in self._slots]) for k in range(1, 6)
        )
        self.actions = self.actions[:, None]
        self.advantages = advantages[flying]
        self.returns = self.advantages + self.values
        self._slots, self.full = [], True

    def get(self, batch_size: int | None = None) -> Generator[MaskableRolloutBufferSamples, None, None]:  # type: ignore[override]
        """Hand out the slots in minibatches of nearly equal size, in random order.

        :param batch_size: slots in a minibatch, at most; all of them without a number
        :return: the minibatches
        """
        assert self.full
        count = len(self.actions)
        for chosen in np.array_split(np.random.permutation(count), -(-count // (batch_size or count))):
            yield self._get_samples(chosen)


class EpisodeMAPPO(MaskableMAPPO):
    """MAPPO on whole episodes, with masked moves: what ``n_steps`` is for others, the number of games is here.

    Takes what :class:`MaskableMAPPO` takes; ``n_steps`` has no effect. Where all games of the environment are over, the
    networks are updated and all games start anew. An env step counts as long as its game lasts.
    """

    continuation = "episode"
    whole_batches = True
    takes_crowds: ClassVar[bool] = True  # UAVs that are in no game leave nothing in the batch
    default_buffer_class = EpisodeBuffer
    rollout_buffer: EpisodeBuffer

    def choose(self, obs: NDArray[np.float32], masks: NDArray[np.bool_], flying: NDArray[np.bool_]) -> Any:
        """Sample the actions of the UAVs in the air.

        :param obs: their flat observations [R, flat_dim]
        :param masks: which actions are allowed [R, A]
        :param flying: who is in the air, of all UAVs [G * N]
        :return: actions [R], values [R] and log-probabilities [R]
        """
        with th.no_grad():
            actions, values, log_probs = self.policy(th.as_tensor(obs, device=self.device), action_masks=masks)
        return tuple(part.cpu().numpy().reshape(len(obs)) for part in (actions, values, log_probs))

    def collect_rollouts(
        self,
        env: VecEnv,
        callback: BaseCallback,
        rollout_buffer: Any,
        n_rollout_steps: int,
        use_masking: bool = True,
    ) -> bool:
        """Play one episode of every game.

        :param env: from :func:`lawn_sb3.envs.make_vec_env` with ``continuation="episode"``
        :param n_rollout_steps: unused, as is ``use_masking``: masks are always used
        :return: false if the callback ended the training
        """
        assert isinstance(env, FlatVecEnv)
        num_uavs = env.games[0].scenario.num_uavs
        self.policy.set_training_mode(False)
        rollout_buffer.reset()
        callback.on_rollout_start()
        self._last_obs = env.reset()  # type: ignore[assignment]
        flying = env.flying()
        actions = np.zeros(env.num_envs, dtype=np.int64)
        while flying.any():
            obs = np.asarray(self._last_obs)[flying]
            masks = env.action_masks()[flying]
            acted, values, log_probs = self.choose(obs, masks, flying)
            actions[:] = 0
            actions[flying] = acted
            new_obs, rewards, dones, infos = env.step(actions)
            playing = flying.reshape(-1, num_uavs).any(axis=1)
            self.num_timesteps += int(playing.sum()) * num_uavs
            rewards = np.where(np.repeat(playing, num_uavs), rewards, 0.0)
            infos = [info if flew else {} for info, flew in zip(infos, flying, strict=True)]
            callback.update_locals(locals())
            if not callback.on_step():
                return False
            self._update_info_buffer(infos, dones & flying)
            rollout_buffer.add_slot(flying, rewards, obs, acted, values, log_probs, masks)
            self._last_obs = new_obs  # type: ignore[assignment]
            flying = flying & ~dones
        rollout_buffer.finish()
        callback.on_rollout_end()
        return True
