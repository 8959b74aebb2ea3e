"""QMIX: Q-learning on the mixed value of a whole game, with SB3's DQN for its loop and settings."""

from typing import Any, ClassVar

import numpy as np
import torch as th
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3 import DQN
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.noise import ActionNoise
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.type_aliases import GymEnv, RolloutReturn
from stable_baselines3.common.utils import LinearSchedule, polyak_update
from stable_baselines3.common.vec_env import VecEnv, unwrap_vec_normalize
from torch.nn import functional

from lawn_sb3.algos.common.games import check_continuation
from lawn_sb3.algos.common.in_time import draw_actions
from lawn_sb3.algos.common.mission_statistics import MissionStatistics
from lawn_sb3.algos.common.plainly_saved import PlainlySaved
from lawn_sb3.algos.qmix.joint_replay import JointReplayBuffer, JointSamples
from lawn_sb3.algos.qmix.policies import QMIXPolicy
from lawn_sb3.choices import Continuation


class QMIX(PlainlySaved, MissionStatistics, DQN):
    """Off-policy learning of one value per game, mixed from the UAVs' own Qs; the policy class holds the mixer.

    Takes what SB3's ``DQN`` takes but for :attr:`not_taken`, by name, with the defaults of :attr:`DEFAULTS`. An env
    step is one slot of one game; a vector step is one slot of all games; ``num_timesteps`` counts agent steps, N per
    env step. ``buffer_size`` is in joint transitions over all games, one per env step, ``batch_size`` in joint
    transitions per update, ``learning_starts`` in agent steps, ``train_freq`` in vector steps, and
    ``target_update_interval`` in updates. Exploration is drawn for each UAV. Policy and replay are given the
    environment's ``layout``; ``replay_buffer_class`` is :class:`JointReplayBuffer` or a subclass.

    :param policy: a subclass of :class:`QMIXPolicy`
    :param env: from :func:`lawn_sb3.envs.make_vec_env` with ``continuation="episode"``: games are whole
    :param double_q: let the trained Q-network choose the next actions that the targets value
    :param _init_setup_model: whether to build the networks at once
    :param kwargs: settings of ``DQN``
    :raises ValueError: if policy or environment do not fit
    """

    DEFAULTS: ClassVar[dict[str, Any]] = {
        "learning_rate": 5e-4,
        "buffer_size": 50_000,
        "learning_starts": 4_000,
        "batch_size": 256,
        "train_freq": 1,
        "target_update_interval": 200,
        "exploration_fraction": 0.25,
    }
    """Where its defaults are not those of ``DQN``."""
    not_taken: ClassVar[frozenset[str]] = frozenset({"n_steps", "optimize_memory_usage"})
    """Settings of ``DQN`` that it refuses: joint replay has single steps, and keeps next observations too."""
    continuation: ClassVar[Continuation] = "episode"
    """How UAVs that are done have to go on in its environment."""

    policy: QMIXPolicy  # type: ignore[assignment]
    replay_buffer: JointReplayBuffer

    def __init__(
        self,
        policy: str | type[BasePolicy],
        env: GymEnv | str,
        *,
        double_q: bool = True,
        _init_setup_model: bool = True,
        **kwargs: Any,
    ) -> None:
        if refused := self.not_taken & kwargs.keys():
            raise TypeError(f"QMIX takes no {', '.join(sorted(refused))}")
        super().__init__(policy, env, _init_setup_model=False, **{**self.DEFAULTS, **kwargs})  # type: ignore[arg-type]
        self.double_q = double_q
        self.replay_buffer_class = self.replay_buffer_class or JointReplayBuffer
        if not issubclass(self.policy_class, QMIXPolicy):
            raise ValueError(f"QMIX needs a policy with a mixer, derived from QMIXPolicy; {policy!r} is none")
        if self.env is not None:
            _check_games(self.env)
            known = ("layout", "scenario", "slack") if self.policy_class.needs_scenario else ("layout",)
            given = {name: self.env.get_attr(name, [0])[0] for name in known}
            self.policy_kwargs = given | self.policy_kwargs
            own = {"layout": given["layout"], "sees": self.policy_class.sees}
            self.replay_buffer_kwargs = own | self.replay_buffer_kwargs
        if _init_setup_model:
            self._setup_model()

    def _setup_model(self) -> None:
        if self.env is not None:
            self._check_fit(self.env)
        OffPolicyAlgorithm._setup_model(self)  # DQN's updates its targets by env steps, and warns of long vectors
        self.exploration_schedule = LinearSchedule(
            self.exploration_initial_eps, self.exploration_final_eps, self.exploration_fraction
        )

    def _check_fit(self, env: VecEnv) -> None:
        """Refuse games that cannot be regrouped, or of another size, though their vectors may be as long."""
        _check_games(env)
        games, trained = env.get_attr("layout", [0])[0], self.policy_kwargs["layout"]
        if games != trained:
            raise ValueError(f"the model is for games of {trained}, the environment has {games}")

    def set_env(self, env: GymEnv, force_reset: bool = True) -> None:
        """Change the environment, as SB3 does; one that does not fit is refused."""
        if isinstance(env, VecEnv):
            self._check_fit(env)
        super().set_env(env, force_reset)

    def train(self, gradient_steps: int, batch_size: int = 100) -> None:
        """Update Q-network and mixer by ``gradient_steps`` minibatches, and their targets when they are due."""
        self.policy.set_training_mode(True)
        self._update_learning_rate(self.policy.optimizer)
        losses = []
        for _ in range(gradient_steps):
            batch = self.replay_buffer.sample(batch_size)
            values = self.policy.game_values(batch.local, batch.state, batch.actions, batch.flying)
            loss = functional.smooth_l1_loss(values, self.target_values(batch))
            self.policy.optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            th.nn.utils.clip_grad_norm_(self.policy.trained_parameters(), self.max_grad_norm)
            self.policy.optimizer.step()
            losses.append(loss.item())
            self._n_updates += 1
            if self._n_updates % self.target_update_interval == 0:
                polyak_update(self.policy.trained_parameters(), self.policy.target_parameters(), self.tau)
        self.logger.record("train/n_updates", self._n_updates, exclude="tensorboard")
        self.logger.record("train/loss", np.mean(losses))
        self.logger.record("train/value_mean", values.mean().item())

    @th.no_grad()
    def target_values(self, batch: JointSamples) -> th.Tensor:
        """What the values of a batch are drawn to [B]: team reward and discounted value of what follows."""
        policy, flying = self.policy, batch.next_flying
        actions = policy.greedy_actions(batch.next_local, flying, target=not self.double_q)
        following = policy.game_values(batch.next_local, batch.next_state, actions, flying, target=True)
        return batch.rewards + self.gamma * (1.0 - batch.game_over) * following

    def predict(
        self,
        observation: NDArray[Any] | dict[str, NDArray[Any]],
        state: tuple[NDArray[Any], ...] | None = None,
        episode_start: NDArray[Any] | None = None,
        deterministic: bool = False,
    ) -> tuple[NDArray[Any], tuple[NDArray[Any], ...] | None]:
        """Act, each UAV by its own Q.

        :param observation: flat observations
        :param state: unused, as is ``episode_start``
        :param deterministic: greedy; otherwise each action is random with the chance ``exploration_rate``
        :return: actions, and ``state`` as it was
        """
        actions, state = self.policy.predict(observation, state, episode_start, deterministic)
        if deterministic:
            return actions, state
        assert isinstance(observation, np.ndarray)
        return self._explore(observation, actions, self.exploration_rate), state

    def _explore(self, observation: NDArray[Any], actions: NDArray[Any], rate: float) -> NDArray[Any]:
        """Replace each action by a random one, of those that the policy allows, with the given chance."""
        assert isinstance(self.action_space, spaces.Discrete)
        flat = th.as_tensor(observation).reshape(-1, observation.shape[-1])
        allowed = self.policy.allowed(self.policy.seen(flat))
        other = draw_actions(allowed, int(self.action_space.n), actions.shape)
        return np.where(np.random.random(actions.shape) < rate, other, actions)

    def _sample_action(
        self, learning_starts: int, action_noise: ActionNoise | None = None, n_envs: int = 1
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        # Not drawn from the action space as SB3 does: its random state would have to be saved too.
        if self.num_timesteps < learning_starts:
            assert isinstance(self._last_obs, np.ndarray)
            actions = self._explore(self._last_obs, np.zeros(n_envs, dtype=np.int64), 1.0)
        else:
            assert self._last_obs is not None
            actions, _ = self.predict(self._last_obs)
        return actions, actions

    def _on_step(self) -> None:
        self.exploration_rate = self.exploration_schedule(self._current_progress_remaining)
        self.logger.record("rollout/exploration_rate", self.exploration_rate)

    def _setup_learn(self, *args: Any, **kwargs: Any) -> tuple[int, BaseCallback]:
        before = self._last_obs
        result = super()._setup_learn(*args, **kwargs)
        if self._last_obs is not before:  # the environment was reset
            self.replay_buffer.start_games()
        self._update_current_progress_remaining(self.num_timesteps, self._total_timesteps)
        self.exploration_rate = self.exploration_schedule(self._current_progress_remaining)
        return result

    def collect_rollouts(self, *args: Any, **kwargs: Any) -> RolloutReturn:
        """Play as SB3 does, to where a callback may stop it."""
        rollout = super().collect_rollouts(*args, **kwargs)
        if not rollout.continue_training:
            # A callback stopped SB3 between a step and its storing: the replay no longer knows who is flying.
            self._last_obs = None
        return rollout

    def memory(self) -> dict[str, Any]:
        """What is not saved with the model: the content of the replay."""
        return self.replay_buffer.content()

    def restore_memory(self, memory: dict[str, Any]) -> None:
        """Take back what :meth:`memory` returned."""
        self.replay_buffer.restore(memory)


def _check_games(env: VecEnv) -> None:
    """Refuse an environment whose games cannot be regrouped."""
    if not env.has_attr("layout"):
        raise ValueError("QMIX needs an environment with a layout, from make_vec_env")
    if unwrap_vec_normalize(env) is not None:
        raise ValueError("QMIX stores games as they are and cannot take VecNormalize")
    check_continuation(QMIX, env)
