"""Independent Q-learning: N of SB3's DQN or QRDQN, one per UAV, in one shared flattened environment."""

import io
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import torch as th
from numpy.typing import NDArray
from sb3_contrib import QRDQN
from sb3_contrib.qrdqn.policies import QRDQNPolicy
from stable_baselines3 import DQN
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.noise import ActionNoise
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.save_util import load_from_pkl
from stable_baselines3.common.type_aliases import GymEnv
from stable_baselines3.dqn.policies import DQNPolicy, MlpPolicy

from lawn_sb3.algos.common.games import check_continuation
from lawn_sb3.algos.common.in_time import draw_actions
from lawn_sb3.algos.common.mission_statistics import MissionStatistics
from lawn_sb3.algos.common.plainly_saved import PlainlySaved
from lawn_sb3.algos.iql.learners import Learner, learner_class
from lawn_sb3.algos.iql.policies import IndependentPolicy
from lawn_sb3.algos.iql.replay import ReplayRouter, replay_content, restore_content
from lawn_sb3.algos.iql.views import LearnerViews
from lawn_sb3.choices import Continuation
from lawn_sb3.envs.observation import ObservationLayout

HANDED_ON = (
    "learning_rate",
    "batch_size",  # QRDQN's Adam depends on it
    "tau",
    "gamma",
    "replay_buffer_class",
    "n_steps",
    "exploration_fraction",
    "exploration_initial_eps",
    "exploration_final_eps",
    "max_grad_norm",
)
"""Settings that every learner has as they are."""


class IQL(PlainlySaved, MissionStatistics, DQN):
    """Every UAV learns by itself from its own o_i; the others are part of its environment.

    SB3's off-policy loop steps the environment once for all; every learner has a replay, networks and an optimiser of
    its own and is trained by its own class: SB3's ``DQN`` with a ``DQNPolicy``, sb3-contrib's ``QRDQN`` with a
    ``QRDQNPolicy``.

    Takes what SB3's ``DQN`` takes but for ``optimize_memory_usage``, with the same defaults whatever the learner. Where
    SB3 counts steps of a learner, each UAV counts its own: ``buffer_size``, ``learning_starts`` and
    ``target_update_interval`` are in env steps, ``train_freq`` is in vector steps (slots of all games), and
    ``gradient_steps`` and ``batch_size`` are for each learner. Only ``learn(total_timesteps)`` counts agent steps, N in
    every env step. Of ``policy_kwargs`` with neither ``optimizer_class`` nor ``optimizer_kwargs``, ``QRDQN`` makes an
    Adam with an epsilon of 0.01 / batch_size.

    :param policy: the policy class of each learner, one of :data:`lawn_sb3.algos.iql.learners.LEARNERS` over o_i
    :param env: a vector environment from :func:`lawn_sb3.envs.make_vec_env`
    :param args: settings of ``DQN``, in its order
    :param double_q: let the online network pick the next action that the target network judges; for a ``DQNPolicy``
    :param share_parameters: one network for all UAVs, which also sees the UAV's index: no longer independent learners
    :param _init_setup_model: whether to build the networks at once
    :param kwargs: settings of ``DQN``, by name
    :raises ValueError: if it has no learner for the policy class, or cannot learn in the environment
    """

    policy_aliases: ClassVar[dict[str, type[BasePolicy]]] = {"MlpPolicy": MlpPolicy}
    policy: IndependentPolicy  # type: ignore[assignment]
    layout: ObservationLayout
    replay_buffer: ReplayRouter  # type: ignore[assignment]

    continuation: ClassVar[Continuation] = "mission"
    """How UAVs that are done have to go on in its environment: a waiting UAV's actions would teach nothing."""
    not_taken: ClassVar[frozenset[str]] = frozenset({"optimize_memory_usage"})
    """Settings of ``DQN`` that it refuses: a checkpoint keeps next observations too."""

    def __init__(
        self,
        policy: str | type[DQNPolicy | QRDQNPolicy],
        env: GymEnv | str,
        *args: Any,
        double_q: bool = False,
        share_parameters: bool = False,
        _init_setup_model: bool = True,
        **kwargs: Any,
    ) -> None:
        if refused := self.not_taken & kwargs.keys():
            raise TypeError(f"IQL takes no {', '.join(sorted(refused))}")
        super().__init__(policy, env, *args, _init_setup_model=False, **kwargs)  # type: ignore[arg-type, misc]
        self.double_q, self.share_parameters = double_q, share_parameters
        self.learners: list[Learner] = []
        if self.env is not None:
            if not self.env.has_attr("layout"):
                raise ValueError("IQL needs an environment with a layout, from make_vec_env")
            if self._vec_normalize_env is not None:
                raise ValueError("IQL takes no VecNormalize: observations are scaled by their layout")
            self.layout = self.env.get_attr("layout", [0])[0]
            self.learning_starts *= self.layout.num_uavs  # SB3's outer loop counts agent steps
        if _init_setup_model:
            self._setup_model()

    def set_env(self, env: GymEnv, force_reset: bool = True) -> None:
        """Change the environment, as SB3 does; one that does not fit is refused."""
        check_continuation(IQL, env)
        super().set_env(env, force_reset)

    def _setup_model(self) -> None:  # in place of SB3's, which builds one network and one replay
        check_continuation(IQL, self.env)
        if self.env is not None and self.env.get_attr("layout", [0])[0] != self.layout:
            raise ValueError(f"the model is for games of {self.layout}, the environment has other ones")
        self._setup_lr_schedule()
        self.set_random_seed(self.seed)
        self._convert_train_freq()
        views = LearnerViews(self.layout, self.share_parameters, tuple(getattr(self.policy_class, "sees", ())))
        self.learners = [self._build_learner(views) for _ in range(views.num_learners)]
        policies = [learner.policy for learner in self.learners]
        self.policy = IndependentPolicy(self.observation_space, self.action_space, policies, views).to(self.device)  # type: ignore[arg-type]
        self.replay_buffer = ReplayRouter([learner.replay_buffer for learner in self.learners], views)  # type: ignore[misc]

    def _build_learner(self, views: LearnerViews) -> Learner:
        """One learner without an environment of its own, built as SB3 does when it loads one."""
        made_of, policy_kwargs = learner_class(self.policy_class, self.double_q), dict(self.policy_kwargs)
        if getattr(self.policy_class, "needs_scenario", False):
            assert self.env is not None
            for name in ("layout", "scenario", "slack"):
                policy_kwargs.setdefault(name, self.env.get_attr(name, [0])[0])
        if made_of is QRDQN and "optimizer_kwargs" in policy_kwargs:
            # QRDQN would replace them by its own wherever the class of the optimiser is left to it.
            policy_kwargs.setdefault("optimizer_class", th.optim.Adam)
        learner = made_of(
            self.policy_class,  # type: ignore[arg-type]
            None,  # type: ignore[arg-type]
            buffer_size=self.buffer_size * views.uavs_each,
            replay_buffer_kwargs=dict(self.replay_buffer_kwargs),
            target_update_interval=self.target_update_interval * views.uavs_each,
            policy_kwargs=policy_kwargs,
            device=self.device,
            _init_setup_model=False,
            **{name: getattr(self, name) for name in HANDED_ON},
        )
        learner.observation_space = views.space()
        learner.action_space = self.action_space
        learner.n_envs = self.n_envs // views.num_learners
        learner._setup_model()
        learner._n_calls, learner._n_updates = self._n_calls, self._n_updates
        learner.set_logger(Logger(None, []))
        return learner

    def train(self, gradient_steps: int, batch_size: int = 100) -> None:
        """Update every learner from its own replay, by ``gradient_steps`` minibatches of ``batch_size`` each."""
        if self.gradient_steps < 0:  # SB3 counted the transitions of all learners
            gradient_steps //= len(self.learners)
        for learner in self.learners:
            learner._current_progress_remaining = self._current_progress_remaining
            learner.train(gradient_steps, batch_size)
        self._n_updates = self.learners[0]._n_updates
        self.logger.record("train/n_updates", self._n_updates, exclude="tensorboard")
        for name in ("train/learning_rate", "train/loss"):
            self.logger.record(name, np.mean([learner.logger.name_to_value[name] for learner in self.learners]))

    def _on_step(self) -> None:
        for learner in self.learners:
            learner._current_progress_remaining = self._current_progress_remaining
            learner._on_step()
        self._n_calls = self.learners[0]._n_calls
        self.exploration_rate = self.learners[0].exploration_rate
        self.logger.record("rollout/exploration_rate", self.exploration_rate)

    def predict(
        self,
        observation: np.ndarray | dict[str, np.ndarray],
        state: tuple[np.ndarray, ...] | None = None,
        episode_start: np.ndarray | None = None,
        deterministic: bool = False,
    ) -> tuple[np.ndarray, tuple[np.ndarray, ...] | None]:
        """Choose actions, epsilon-greedy: every slot flips a coin of its own.

        :param observation: flat observations of whole games [G * N, flat_dim]; row g * N + i is UAV i of game g
        :param state: unused, as is ``episode_start``
        :param deterministic: greedy actions
        :return: actions [G * N], and ``state`` as it was
        """
        actions, state = self.policy.predict(observation, state, episode_start, deterministic)
        if deterministic:
            return actions, state
        explore = np.random.random_sample(actions.shape) < self.exploration_rate
        assert isinstance(observation, np.ndarray)
        allowed = self.policy.allowed(th.as_tensor(observation))
        drawn = draw_actions(allowed, self.action_space.n, actions.shape)  # type: ignore[attr-defined]
        return np.where(explore, drawn, actions), state

    def _sample_action(
        self, learning_starts: int, action_noise: ActionNoise | None = None, n_envs: int = 1
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        if self.num_timesteps < learning_starts:
            assert isinstance(self._last_obs, np.ndarray)
            allowed = self.policy.allowed(th.as_tensor(self._last_obs))
            if allowed is not None:
                drawn = draw_actions(allowed, allowed.shape[1], allowed.shape[:1])
                return drawn, drawn
        return super()._sample_action(learning_starts, action_noise, n_envs)

    def load_replay_buffer(self, path: str | Path | io.BufferedIOBase, truncate_last_traj: bool = True) -> None:
        """Load all learners' replays from a file that ``save_replay_buffer`` wrote.

        As in SB3 that is a pickle, which can run code: load none that you do not trust.
        """
        saved = load_from_pkl(path, self.verbose)
        for own, other in zip(self.replay_buffer.replays, saved.replays, strict=True):
            restore_content(own, replay_content(other))

    def memory(self) -> dict[str, Any]:
        """What is not saved with the model: the replays' content, and the state of the stream of random play."""
        return {
            "replays": [replay_content(replay) for replay in self.replay_buffer.replays],
            "random_play": self.action_space.np_random.bit_generator.state,
        }

    def restore_memory(self, memory: dict[str, Any]) -> None:
        """Take back what :meth:`memory` returned."""
        for replay, content in zip(self.replay_buffer.replays, memory["replays"], strict=True):
            restore_content(replay, content)
        self.action_space.np_random.bit_generator.state = memory["random_play"]

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "learners"]

    def _get_torch_save_params(self) -> tuple[list[str], list[str]]:
        return ["policy", *(f"policy.learners.{i}.optimizer" for i in range(len(self.learners)))], []
