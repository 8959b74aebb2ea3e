"""CTDE-MAPPO (Algorithm 1): SB3's PPO over flattened games, with a centralised critic and value normalisation."""

from __future__ import annotations

from typing import Any

import torch as th
from stable_baselines3 import PPO
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.type_aliases import GymEnv, Schedule

from lawn_sb3.algos.mappo.centralized_training import CentralizedTraining
from lawn_sb3.algos.mappo.value_normalization import NormalizedRolloutBuffer


class MAPPO(CentralizedTraining, PPO):
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

    default_buffer_class = NormalizedRolloutBuffer
    policy_base = ActorCriticPolicy

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
            ent_coef=ent_coef,
            vf_coef=vf_coef,
            max_grad_norm=max_grad_norm,
            use_sde=use_sde,
            sde_sample_freq=sde_sample_freq,
            rollout_buffer_class=rollout_buffer_class,
            rollout_buffer_kwargs=rollout_buffer_kwargs,
            target_kl=target_kl,
            stats_window_size=stats_window_size,
            tensorboard_log=tensorboard_log,
            policy_kwargs=policy_kwargs,
            verbose=verbose,
            seed=seed,
            device=device,
            normalize_value=normalize_value,
            _init_setup_model=_init_setup_model,
        )
