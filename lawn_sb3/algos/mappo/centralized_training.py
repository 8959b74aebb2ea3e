"""What SB3's PPO and its relatives lack for CTDE: the layout for the policy, value normalisation, annealed entropy."""

from contextlib import nullcontext
from typing import Any, ClassVar

from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.on_policy_algorithm import OnPolicyAlgorithm
from stable_baselines3.common.policies import BasePolicy
from stable_baselines3.common.type_aliases import GymEnv, Schedule
from stable_baselines3.common.utils import FloatSchedule
from stable_baselines3.common.vec_env import VecEnv
from torch import nn

from lawn_sb3.algos.common.games import check_continuation
from lawn_sb3.algos.common.mission_statistics import MissionStatistics
from lawn_sb3.algos.common.plainly_saved import PlainlySaved
from lawn_sb3.algos.mappo.policies import CTDEViews
from lawn_sb3.algos.mappo.precision import check_autocast, networks_in
from lawn_sb3.algos.mappo.value_normalization import NormalizedRolloutBuffer, NormalizedValueHead
from lawn_sb3.choices import Continuation

CRITIC_PARTS = ("mlp_extractor.value_net.", "value_net.", "vf_features_extractor.", "lstm_critic.", "critic.")
"""How the names of a critic's parameters begin, in SB3 and sb3-contrib."""


class CentralizedTraining(PlainlySaved, MissionStatistics, OnPolicyAlgorithm):
    """Mixin for SB3's or sb3-contrib's PPO: takes what that PPO takes.

    :param policy: a policy class; one with :class:`CTDEViews` is given the environment's ``layout``
    :param env: a vector environment from :func:`lawn_sb3.envs.make_vec_env`
    :param args: settings of that PPO, in its order
    :param ent_coef: entropy coefficient c_e, or a schedule of the progress remaining
    :param rollout_buffer_class: ``default_buffer_class`` or a subclass
    :param normalize_value: train the critic on returns of zero mean and unit variance
    :param normalize_per_rollout: normalise advantages once over the rollout, as MAPPO's own code does, in place of
        once a minibatch, as SB3 does
    :param clip_apart: hold the gradients of actor and critic to ``max_grad_norm`` each by itself, as MAPPO's own code
        does with its two optimisers, in place of both together, as SB3 does
    :param autocast: ``bfloat16``: precision of the networks in updates, by ``torch.autocast``; by default float32, in
        which they always act
    :param _init_setup_model: whether to build the networks at once
    :param kwargs: settings of that PPO, by name
    :raises ValueError: if policy, environment or buffer do not fit
    """

    continuation: ClassVar[Continuation] = "mission"
    """How UAVs that are done have to go on in its environment: a waiting UAV's actions would teach nothing."""
    default_buffer_class: ClassVar[type[NormalizedRolloutBuffer]]
    """The rollout buffer of that PPO, with normalised returns."""

    def __init__(
        self,
        policy: str | type[BasePolicy],
        env: GymEnv | str,
        *args: Any,
        ent_coef: float | Schedule = 0.0,
        rollout_buffer_class: type[RolloutBuffer] | None = None,
        normalize_value: bool = True,
        normalize_per_rollout: bool = False,
        clip_apart: bool = False,
        autocast: str | None = None,
        _init_setup_model: bool = True,
        **kwargs: Any,
    ) -> None:
        check_autocast(autocast)
        self.autocast = autocast
        self.ent_coef_schedule = FloatSchedule(ent_coef)
        self.normalize_value = normalize_value
        self.normalize_per_rollout = normalize_per_rollout
        self.clip_apart = clip_apart
        self._value_head: NormalizedValueHead | None = None
        self._norm_each = 0.0
        super().__init__(  # type: ignore[misc]
            policy,  # type: ignore[arg-type]
            env,
            *args,
            ent_coef=self.ent_coef_schedule(1.0),
            _init_setup_model=False,
            **kwargs,
        )
        if normalize_per_rollout:
            self.normalize_advantage = False
        self.rollout_buffer_class = rollout_buffer_class or self.default_buffer_class
        if normalize_value and not issubclass(self.rollout_buffer_class, self.default_buffer_class):
            raise ValueError(
                f"value normalisation needs a rollout_buffer_class derived from {self.default_buffer_class.__name__}"
            )
        if issubclass(self.policy_class, CTDEViews) and self.env is not None:
            if not self.env.has_attr("layout"):
                raise ValueError(f"{self.policy_class.__name__} needs an environment with a layout, from make_vec_env")
            known = ("layout", "scenario") if self.policy_class.needs_scenario else ("layout",)
            self.policy_kwargs = {name: self.env.get_attr(name, [0])[0] for name in known} | self.policy_kwargs
        if _init_setup_model:
            self._setup_model()

    def set_env(self, env: GymEnv, force_reset: bool = True) -> None:
        """Change the environment, as SB3 does; one whose UAVs go on in another way is refused."""
        check_continuation(type(self), env)
        super().set_env(env, force_reset)

    def _setup_model(self) -> None:
        check_continuation(type(self), self.env)
        super()._setup_model()
        if self.normalize_value:
            head: nn.Module = self.policy.value_net
            if not isinstance(head, NormalizedValueHead):  # a stock policy
                head = NormalizedValueHead(self.policy.value_net).to(self.device)
                self.policy.value_net = head  # type: ignore[assignment]
            head.forget()
            self.rollout_buffer.value_head = head  # type: ignore[attr-defined]
            self._value_head = head
        self._norm_each = self.max_grad_norm
        if self.clip_apart:
            self.policy.optimizer.register_step_pre_hook(self._clip_actor_and_critic)

    def _clip_actor_and_critic(self, *_: Any) -> None:
        """Hold the gradients of each to ``max_grad_norm``, right before the optimiser uses them."""
        named = list(self.policy.named_parameters())
        for of_critic in (True, False):
            group = [one for name, one in named if name.startswith(CRITIC_PARTS) == of_critic]
            nn.utils.clip_grad_norm_(group, self._norm_each)

    def train(self) -> None:
        """Update actor and critic from the rollout, the critic in normalised units."""
        self.ent_coef = self.ent_coef_schedule(self._current_progress_remaining)
        self.logger.record("train/ent_coef", self.ent_coef)
        head = self._value_head
        if head is not None:
            head.update(self.rollout_buffer.returns)
            self.logger.record("train/return_mean", head.mean.item())
            self.logger.record("train/return_std", head.std.item())
        if self.normalize_per_rollout:
            advantages = self.rollout_buffer.advantages
            self.rollout_buffer.advantages = (advantages - advantages.mean()) / (advantages.std() + 1e-8)
        self._norm_each = self.max_grad_norm
        if self.clip_apart:
            self.max_grad_norm = float("inf")  # what SB3 holds both together to
        try:
            with (
                head.normalized_units() if head is not None else nullcontext(),
                networks_in(self.autocast, self.policy),
            ):
                super().train()
        finally:
            self.max_grad_norm = self._norm_each

    @classmethod
    def _fitted(cls, values: dict[str, Any], env: VecEnv) -> dict[str, Any]:
        """Games of another N fit if the networks are the same for every N."""
        trained = values["policy_kwargs"].get("layout")
        asked = env.get_attr("layout", [0])[0] if env.has_attr("layout") else None
        if None in (trained, asked) or trained == asked:
            return {}
        policy_kwargs = {**values["policy_kwargs"], "layout": asked}
        return {"observation_space": env.observation_space, "policy_kwargs": policy_kwargs}

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "_value_head"]
