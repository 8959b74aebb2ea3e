"""CTDE-MAPPO (Algorithm 1): SB3's PPO over flattened games, with a centralised critic and value normalisation."""

from __future__ import annotations

from contextlib import nullcontext
from typing import Any

from stable_baselines3 import PPO
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.type_aliases import GymEnv, Schedule
from stable_baselines3.common.utils import FloatSchedule

from lawn_sb3.algos.mappo.policies import CTDEPolicy
from lawn_sb3.algos.mappo.value_normalization import NormalizedRolloutBuffer, NormalizedValueHead


class MAPPO(PPO):
    """
    PPO whose policy class decides what the critic reads.

    Takes what SB3's ``PPO`` takes; the policy is given the environment's ``layout``.

    :param policy: a policy class, usually a subclass of :class:`CTDEPolicy`
    :param env: a vector environment from :func:`lawn_sb3.envs.make_vec_env`
    :param ent_coef: entropy coefficient c_e, or a schedule of the progress remaining
    :param normalize_value: train the critic on returns of zero mean and unit variance
    :param policy_kwargs: additional arguments of the policy
    :param kwargs: what else SB3's ``PPO`` takes
    """

    def __init__(
        self,
        policy: str | type[ActorCriticPolicy],
        env: GymEnv | str | None,
        *args: Any,
        ent_coef: float | Schedule = 0.0,
        normalize_value: bool = True,
        policy_kwargs: dict[str, Any] | None = None,
        _init_setup_model: bool = True,
        **kwargs: Any,
    ) -> None:
        self.ent_coef_schedule = FloatSchedule(ent_coef)
        self.normalize_value = normalize_value
        self._value_head: NormalizedValueHead | None = None
        kwargs.setdefault("rollout_buffer_class", NormalizedRolloutBuffer)
        super().__init__(
            policy,
            env,  # type: ignore[arg-type]
            *args,
            ent_coef=self.ent_coef_schedule(1.0),
            policy_kwargs=dict(policy_kwargs or {}),
            _init_setup_model=False,
            **kwargs,
        )
        if issubclass(self.policy_class, CTDEPolicy) and self.env is not None:
            self.policy_kwargs.setdefault("layout", self.env.get_attr("layout", 0)[0])
        if _init_setup_model:
            self._setup_model()

    def _setup_model(self) -> None:
        super()._setup_model()
        if self.normalize_value:
            head = NormalizedValueHead(self.policy.value_net).to(self.device)  # type: ignore[arg-type]
            self.policy.value_net = head  # type: ignore[assignment]
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
