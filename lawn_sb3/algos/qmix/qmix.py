"""QMIX: Q-learning on the mixed value of a whole game, on SB3's off-policy base."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import torch as th
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.noise import ActionNoise
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.type_aliases import GymEnv, MaybeCallback, RolloutReturn, Schedule
from stable_baselines3.common.utils import LinearSchedule, polyak_update
from stable_baselines3.common.vec_env import VecEnv, unwrap_vec_normalize
from torch.nn import functional

from lawn_sb3.algos.common.in_time import draw_allowed
from lawn_sb3.algos.qmix.joint_replay import JointReplayBuffer, JointSamples
from lawn_sb3.algos.qmix.policies import QMIXPolicy
from lawn_sb3.game.simulator import Continuation


class QMIX(OffPolicyAlgorithm):
    """Off-policy learning of one value a game, mixed from the UAVs' own Qs; the policy class holds the mixer.

    Takes what SB3's ``DQN`` takes; policy and replay are given the environment's ``layout``. An env step is one slot
    of one game; a vector step is one slot of all games; ``num_timesteps`` counts agent steps, N an env step.

    :param policy: a subclass of :class:`QMIXPolicy`
    :param env: from :func:`lawn_sb3.envs.make_vec_env` with ``continuation="episode"``: games are whole
    :param learning_rate: learning rate, or a schedule of the progress remaining
    :param buffer_size: joint transitions kept, over all games: one an env step
    :param learning_starts: agent steps played at random before the first update
    :param batch_size: joint transitions an update
    :param tau: share of the trained networks in the targets at each of their updates; 1 copies them
    :param gamma: discount factor
    :param train_freq: vector steps between two calls of :meth:`train`
    :param gradient_steps: updates each time; -1 for one an agent step
    :param replay_buffer_class: :class:`JointReplayBuffer` or a subclass
    :param replay_buffer_kwargs: its additional arguments
    :param target_update_interval: updates between two updates of the targets
    :param exploration_fraction: share of training over which exploration falls
    :param exploration_initial_eps: chance at the start that a UAV's action is random, drawn for each UAV
    :param exploration_final_eps: the same at the end
    :param max_grad_norm: clip the norm of the gradient
    :param stats_window_size: missions averaged over in the log
    :param tensorboard_log: where to log for TensorBoard
    :param policy_kwargs: additional arguments of the policy
    :param verbose: as in SB3
    :param seed: seed of networks, exploration, replay and missions
    :param device: as in SB3
    :param double_q: let the trained Q-network choose the next actions that the targets value
    :param _init_setup_model: whether to build the networks at once
    :raises ValueError: if policy or environment do not fit
    """

    continuation: ClassVar[Continuation] = "episode"
    """How UAVs that are done have to go on in its environment."""

    policy: QMIXPolicy
    replay_buffer: JointReplayBuffer

    def __init__(
        self,
        policy: str | type[BasePolicy],
        env: GymEnv | str,
        learning_rate: float | Schedule = 5e-4,
        buffer_size: int = 50_000,
        learning_starts: int = 4_000,
        batch_size: int = 256,
        tau: float = 1.0,
        gamma: float = 0.99,
        train_freq: int | tuple[int, str] = 1,
        gradient_steps: int = 1,
        replay_buffer_class: type[JointReplayBuffer] | None = None,
        replay_buffer_kwargs: dict[str, Any] | None = None,
        target_update_interval: int = 200,
        exploration_fraction: float = 0.25,
        exploration_initial_eps: float = 1.0,
        exploration_final_eps: float = 0.05,
        max_grad_norm: float = 10.0,
        stats_window_size: int = 100,
        tensorboard_log: str | None = None,
        policy_kwargs: dict[str, Any] | None = None,
        verbose: int = 0,
        seed: int | None = None,
        device: th.device | str = "auto",
        double_q: bool = True,
        _init_setup_model: bool = True,
    ) -> None:
        super().__init__(
            policy,
            env,
            learning_rate,
            buffer_size,
            learning_starts,
            batch_size,
            tau,
            gamma,
            train_freq,
            gradient_steps,
            replay_buffer_class=replay_buffer_class or JointReplayBuffer,
            replay_buffer_kwargs=dict(replay_buffer_kwargs or {}),
            policy_kwargs=dict(policy_kwargs or {}),
            stats_window_size=stats_window_size,
            tensorboard_log=tensorboard_log,
            verbose=verbose,
            device=device,
            support_multi_env=True,
            seed=seed,
            sde_support=False,
            supported_action_spaces=(spaces.Discrete,),
        )
        self.target_update_interval = target_update_interval
        self.exploration_schedule = LinearSchedule(exploration_initial_eps, exploration_final_eps, exploration_fraction)
        self.exploration_rate = 0.0
        self.max_grad_norm = max_grad_norm
        self.double_q = double_q
        if not issubclass(self.policy_class, QMIXPolicy):
            raise ValueError(f"QMIX needs a policy with a mixer, derived from QMIXPolicy; {policy!r} is none")
        if self.env is not None:
            _check_games(self.env)
            for arguments in (self.policy_kwargs, self.replay_buffer_kwargs):
                arguments.setdefault("layout", self.env.get_attr("layout", [0])[0])
            self.replay_buffer_kwargs.setdefault("sees", self.policy_class.sees)
            if self.policy_class.needs_scenario:
                for name in ("scenario", "slack"):
                    self.policy_kwargs.setdefault(name, self.env.get_attr(name, [0])[0])
        if _init_setup_model:
            self._setup_model()

    def set_env(self, env: GymEnv, force_reset: bool = True) -> None:
        """Change the environment.

        :param env: the environment, as for the constructor
        :param force_reset: as in SB3
        :raises ValueError: if it does not fit
        """
        if isinstance(env, VecEnv):
            _check_games(env)
        super().set_env(env, force_reset)

    def train(self, gradient_steps: int, batch_size: int = 100) -> None:
        """Update Q-network, mixer and, when due, their targets.

        :param gradient_steps: updates
        :param batch_size: joint transitions an update
        """
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
        """What the values of a batch are drawn to: team reward and discounted value of what follows.

        :param batch: joint transitions
        :return: [B]
        """
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
        :param state: as in SB3
        :param episode_start: as in SB3
        :param deterministic: greedy; otherwise each action is random with the chance ``exploration_rate``
        :return: actions and the state
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
        if allowed is None:
            other = np.random.randint(self.action_space.n, size=actions.shape)
        else:
            other = draw_allowed(allowed.cpu().numpy()).reshape(actions.shape)
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

    def _setup_learn(
        self,
        total_timesteps: int,
        callback: MaybeCallback = None,
        reset_num_timesteps: bool = True,
        tb_log_name: str = "run",
        progress_bar: bool = False,
    ) -> tuple[int, BaseCallback]:
        restarts = reset_num_timesteps or self._last_obs is None
        result = super()._setup_learn(total_timesteps, callback, reset_num_timesteps, tb_log_name, progress_bar)
        if restarts:
            self.replay_buffer.start_games()
        self._update_current_progress_remaining(self.num_timesteps, self._total_timesteps)
        self.exploration_rate = self.exploration_schedule(self._current_progress_remaining)
        return result

    def collect_rollouts(self, *args: Any, **kwargs: Any) -> RolloutReturn:
        """Play as SB3 does.

        :param args: as in SB3
        :param kwargs: as in SB3
        :return: what was played
        """
        rollout = super().collect_rollouts(*args, **kwargs)
        if not rollout.continue_training:
            # A callback stopped SB3 between a step and its storing: the replay no longer knows who is flying.
            self._last_obs = None
        return rollout

    def memory(self) -> dict[str, Any]:
        """What a cut training needs besides the saved model: the content of the replay.

        :return: something that can be pickled
        """
        return self.replay_buffer.content()

    def restore_memory(self, memory: dict[str, Any]) -> None:
        """Take back the content of the replay.

        :param memory: what :meth:`memory` returned
        """
        self.replay_buffer.restore(memory)

    def _get_torch_save_params(self) -> tuple[list[str], list[str]]:
        return ["policy", "policy.optimizer"], []


def _check_games(env: VecEnv) -> None:
    """Refuse an environment whose games cannot be regrouped."""
    if not env.has_attr("layout"):
        raise ValueError("QMIX needs an environment with a layout, from make_vec_env")
    if unwrap_vec_normalize(env) is not None:
        raise ValueError("QMIX stores games as they are and cannot take VecNormalize")
    if env.has_attr("simulator") and env.get_attr("simulator", [0])[0].continuation != QMIX.continuation:
        raise ValueError(f"QMIX learns whole games: its environment needs continuation={QMIX.continuation!r}")
