"""No sharing of parameters: every UAV has an actor of its own, which learns from that UAV's missions alone.

The critic is that of ``centralized_critic``, V([o_i, x]), one for all.
"""

from collections.abc import Sequence
from typing import Any

import torch as th
from gymnasium import spaces
from stable_baselines3.common.torch_layers import create_mlp
from stable_baselines3.common.type_aliases import Schedule
from torch import nn

from lawn_sb3.algos.mappo import CTDEPolicy


class NetworkPerUAV(nn.Module):
    """One network per UAV: each row is answered by its own UAV's.

    :param networks: one network per UAV
    """

    def __init__(self, networks: Sequence[nn.Module]) -> None:
        super().__init__()
        self.networks = nn.ModuleList(networks)

    def forward(self, rows: th.Tensor) -> th.Tensor:
        """Ask each row's own network.

        :param rows: inputs, followed by the UAV's index, one-hot [B, F + N]
        :return: outputs [B, anything]
        """
        inputs, index = rows[:, : -len(self.networks)], rows[:, -len(self.networks) :]
        mine = [index[:, i].nonzero()[:, 0] for i in range(len(self.networks))]
        answers = th.cat([network(inputs[own]) for network, own in zip(self.networks, mine, strict=True)])
        return answers[th.cat(mine).argsort()]


class SeparateActorsPolicy(CTDEPolicy):
    """N actors over o_i, of which the UAV's index picks its own, and a critic V([o_i, x])."""

    sees = ("index",)

    def __init__(
        self, observation_space: spaces.Box, action_space: spaces.Discrete, lr_schedule: Schedule, **kwargs: Any
    ) -> None:
        super().__init__(observation_space, action_space, lr_schedule, **kwargs)
        self.mlp_extractor.policy_net = NetworkPerUAV([self._actor() for _ in range(self.layout.num_uavs)])
        self.action_net = nn.Identity()
        self.optimizer = self.optimizer_class(self.parameters(), lr=lr_schedule(1), **self.optimizer_kwargs)  # type: ignore[call-arg]

    def _actor(self) -> nn.Module:
        """An actor as SB3 makes it: orthogonal weights, the last layer's small."""
        assert isinstance(self.net_arch, dict)
        assert isinstance(self.action_space, spaces.Discrete)
        layers = create_mlp(self.layout.local_dim, int(self.action_space.n), self.net_arch["pi"], self.activation_fn)
        for layer in layers:
            self.init_weights(layer, gain=0.01 if layer is layers[-1] else 2.0**0.5)
        return nn.Sequential(*layers)

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return th.cat([local[:, self.layout.local], state], dim=1)
