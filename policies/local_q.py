"""IQL's default: each UAV's own action values Q(o_i, .). An ablation changes the widths, or what Q sees of o_i."""

from typing import Any

from gymnasium import spaces
from stable_baselines3.common.type_aliases import Schedule
from stable_baselines3.dqn.policies import DQNPolicy


class LocalQPolicy(DQNPolicy):
    """Two hidden layers of 256 ReLU units, as the paper's networks have."""

    def __init__(
        self,
        observation_space: spaces.Box,
        action_space: spaces.Discrete,
        lr_schedule: Schedule,
        net_arch: list[int] | None = None,
        **kwargs: Any,
    ) -> None:
        net_arch = [256, 256] if net_arch is None else net_arch
        super().__init__(observation_space, action_space, lr_schedule, net_arch, **kwargs)
