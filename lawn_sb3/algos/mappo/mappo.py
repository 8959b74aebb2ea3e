"""CTDE-MAPPO (Algorithm 1): SB3's PPO over flattened games, with a centralised critic and value normalisation."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Any, ClassVar

import torch as th
from stable_baselines3 import PPO
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.type_aliases import GymEnv, Schedule
from stable_baselines3.common.utils import FloatSchedule
from torch import nn

from lawn_sb3.algos.mappo.policies import CTDEPolicy
from lawn_sb3.algos.mappo.value_normalization import NormalizedRolloutBuffer, NormalizedValueHead
from lawn_sb3.game.simulator import Continuation


class MAPPO(PPO):
    """PPO whose policy class decides what the critic reads.

    Takes what SB3's ``PPO`` takes; the policy is given the environment's ``layout``.

    :param policy: a policy class, usually a subclass of :class:`CTDEPolicy`
    :param env: a vector environment from :func:`lawn_sb3.envs.make_vec_env`
    :param learning_rate: learning rate, or a schedule of the progress remaining
    :param n_steps: rollout length L in slots
    :param batch_size: minibatch size in agent steps
    :param n_epochs: update epochs K a rollout
    :param gamma: discount factor
    :param gae_lambda: GAE parameter lambda (eq:gae)
    :param clip_range: clip ratio epsilon (eq:ppo_clip)
    :param clip_range_vf: clip range of the value function in normalised units, or none
    :param normalize_advantage: bring advantages to zero mean and unit variance
    :param ent_coef: entropy coefficient c_e, or a schedule of the progress remaining
    :param vf_coef: weight of the critic's loss (eq:critic_loss)
    :param max_grad_norm: clip the norm of the gradient
    :param use_sde: as in SB3; meaningless for discrete actions
    :param sde_sample_freq: as in SB3
    :param rollout_buffer_class: :class:`NormalizedRolloutBuffer` or a subclass
    :param rollout_buffer_kwargs: its additional arguments
    :param target_kl: stop an update that moves the policy further than this
    :param stats_window_size: missions averaged over in the log
    :param tensorboard_log: where to log for TensorBoard
    :param policy_kwargs: additional arguments of the policy
    :param verbose: as in SB3
    :param seed: seed of networks, exploration, minibatches and missions
    :param device: as in SB3
    :param normalize_value: train the critic on returns of zero mean and unit variance
    :param _init_setup_model: whether to build the networks at once
    """

    continuation: ClassVar[Continuation] = "mission"
    """How UAVs that are done have to go on in its environment: a waiting UAV's actions would teach nothing."""

    def __init__(
        self,
        policy: str | type[ActorCriticPolicy],
        env: GymEnv | str,
        learning_rate: float | Schedule = 3e-4,
        n_steps: int = 2048,
        batch_size: int = 64,
        n_epochs: int = 10,
        gamma: float = 0.99,
        gae_lambda: float = 0.95,
        clip_range: float | Schedule = 0.2,
        clip_range_vf: float | Schedule | None = None,
        normalize_advantage: bool = True,
        ent_coef: float | Schedule = 0.0,
        vf_coef: float = 0.5,
        max_grad_norm: float = 0.5,
        use_sde: bool = False,
        sde_sample_freq: int = -1,
        rollout_buffer_class: type[NormalizedRolloutBuffer] | None = None,
        rollout_buffer_kwargs: dict[str, Any] | None = None,
        target_kl: float | None = None,
        stats_window_size: int = 100,
        tensorboard_log: str | None = None,
        policy_kwargs: dict[str, Any] | None = None,
        verbose: int = 0,
        seed: int | None = None,
        device: th.device | str = "auto",
        normalize_value: bool = True,
        _init_setup_model: bool = True,
    ) -> None:
        self.ent_coef_schedule = FloatSchedule(ent_coef)
        self.normalize_value = normalize_value
        self._value_head: NormalizedValueHead | None = None
        super().__init__(
            policy,
            env,
            learning_rate=learning_rate,
            n_steps=n_steps,
            batch_size=batch_size,
            n_epochs=n_epochs,
            gamma=gamma,
            gae_lambda=gae_lambda,
            clip_range=clip_range,
            clip_range_vf=clip_range_vf,
            normalize_advantage=normalize_advantage,
            ent_coef=self.ent_coef_schedule(1.0),
            vf_coef=vf_coef,
            max_grad_norm=max_grad_norm,
            use_sde=use_sde,
            sde_sample_freq=sde_sample_freq,
            rollout_buffer_class=rollout_buffer_class or NormalizedRolloutBuffer,
            rollout_buffer_kwargs=rollout_buffer_kwargs,
            target_kl=target_kl,
            stats_window_size=stats_window_size,
            tensorboard_log=tensorboard_log,
            policy_kwargs=dict(policy_kwargs or {}),
            verbose=verbose,
            seed=seed,
            device=device,
            _init_setup_model=False,
        )
        if normalize_value and not issubclass(self.rollout_buffer_class or RolloutBuffer, NormalizedRolloutBuffer):
            raise ValueError("value normalisation needs a rollout_buffer_class derived from NormalizedRolloutBuffer")
        if issubclass(self.policy_class, CTDEPolicy) and self.env is not None:
            if not self.env.has_attr("layout"):
                raise ValueError(f"{self.policy_class.__name__} needs an environment with a layout, from make_vec_env")
            self.policy_kwargs.setdefault("layout", self.env.get_attr("layout", [0])[0])
        if _init_setup_model:
            self._setup_model()

    def _setup_model(self) -> None:
        super()._setup_model()
        if self.normalize_value:
            head: nn.Module = self.policy.value_net
            if not isinstance(head, NormalizedValueHead):  # a stock policy
                head = NormalizedValueHead(self.policy.value_net).to(self.device)
                self.policy.value_net = head  # type: ignore[assignment]
            head.forget()
            self.rollout_buffer.value_head = head  # type: ignore[attr-defined]
            self._value_head = head

    def train(self) -> None:
        """Update actor and critic from the rollout, the critic in normalised units."""
        self.ent_coef = self.ent_coef_schedule(self._current_progress_remaining)
        self.logger.record("train/ent_coef", self.ent_coef)
        head = self._value_head
        if head is not None:
            head.update(self.rollout_buffer.returns)
            self.logger.record("train/return_mean", head.mean.item())
            self.logger.record("train/return_std", head.std.item())
        with head.normalized_units() if head is not None else nullcontext():
            super().train()

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "_value_head"]
