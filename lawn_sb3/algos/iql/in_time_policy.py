"""A learner's policy whose moves are in time, in the symmetric frame."""

from __future__ import annotations

from typing import Any, ClassVar

import torch as th
from gymnasium import spaces
from stable_baselines3.common.torch_layers import create_mlp
from stable_baselines3.common.type_aliases import Schedule
from stable_baselines3.dqn.policies import DQNPolicy, QNetwork
from torch import nn

from lawn_sb3.algos.common.encoder import Encoder, Inputs
from lawn_sb3.algos.common.in_time import InTimeQ
from lawn_sb3.envs.observation import ObservationLayout, Sight
from lawn_sb3.scenario import Scenario


class InTimeQPolicy(DQNPolicy):
    """SB3's DQN policy over o_i and the clock: a Q-network in the symmetric frame, whose moves are in time.

    :param observation_space: what a learner sees
    :param action_space: the actions
    :param lr_schedule: learning rate as a function of the progress remaining
    :param layout: where o_i and the clock lie in it
    :param scenario: the game, for its airspace, cells and RBs
    :param slack: slots beyond T_i^min in which to arrive; without a number, all moves inside the airspace are allowed
    :param symmetric: turn the airspace so that the own position lies in one octant
    :param inputs: places ``one-hot``, or as numbers ``relative`` to the own position
    :param net_arch: widths of the hidden layers; two of 256, as the paper's networks have
    :param kwargs: what else SB3's ``DQNPolicy`` takes
    """

    sees: ClassVar[tuple[Sight, ...]] = ("clock",)
    """What it sees besides o_i."""
    needs_scenario: ClassVar[bool] = True
    """It takes the environment's ``layout``, ``scenario`` and ``slack`` too."""

    def __init__(
        self,
        observation_space: spaces.Box,
        action_space: spaces.Discrete,
        lr_schedule: Schedule,
        layout: ObservationLayout,
        scenario: Scenario,
        slack: int | None = None,
        symmetric: bool = True,
        inputs: Inputs = "one-hot",
        net_arch: list[int] | None = None,
        **kwargs: Any,
    ) -> None:
        self.layout, self.scenario, self.slack = layout, scenario, slack
        self.symmetric, self.inputs = symmetric, inputs
        net_arch = [256, 256] if net_arch is None else net_arch
        super().__init__(observation_space, action_space, lr_schedule, net_arch, **kwargs)

    def make_q_net(self) -> QNetwork:
        """SB3's Q-network, or its target, with layers that answer in the symmetric frame."""
        made = super().make_q_net()
        encoder = Encoder(self.scenario, self.layout, self.sees, symmetric=self.symmetric, inputs=self.inputs)
        hidden = nn.Sequential(
            *create_mlp(encoder.width, int(self.action_space.n), list(self.net_arch), self.activation_fn)  # type: ignore[attr-defined]
        )
        made.q_net = InTimeQ(encoder, hidden, self.scenario.max_slots, self.slack)  # type: ignore[assignment]
        return made.to(self.device)

    def allowed(self, seen: th.Tensor) -> th.Tensor:
        """Which moves are in time [B, A], by what the learner sees [B, anything]."""
        layers: Any = self.q_net.q_net
        moves: th.Tensor = layers.allowed(seen)
        return moves

    def _get_constructor_parameters(self) -> dict[str, Any]:
        own = {name: getattr(self, name) for name in ("layout", "scenario", "slack", "symmetric", "inputs")}
        return {**super()._get_constructor_parameters(), **own}
