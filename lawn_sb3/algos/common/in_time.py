"""In-time moves for networks of action values: what is not allowed is worth less than anything that is."""

from typing import Any

import numpy as np
import torch as th
from numpy.typing import NDArray
from stable_baselines3.common.torch_layers import create_mlp
from torch import nn

from lawn_sb3.algos.common.encoder import Encoder
from lawn_sb3.algos.common.framed import Framed
from lawn_sb3.envs.observation import POSITION_UNIT_VOXELS, SLOT_UNIT, ObservationLayout
from lawn_sb3.game.airspace import action_table, moves_in_time, moves_inside
from lawn_sb3.scenario import Scenario

FORBIDDEN = -1e6
"""The value of a move that is not allowed; finite, so that a target that multiplies it by 0 stays a number."""


class InTimeQ(nn.Module):
    """Action values in the symmetric frame, of moves that are in time.

    :param encoder: how what is seen is put to the hidden layers; its observations hold the clock
    :param hidden: layers from the encoder's features to the values of the turned actions
    :param scenario: the game
    :param slack: as for :func:`in_time`
    """

    def __init__(self, encoder: Encoder, hidden: nn.Module, scenario: Scenario, slack: int | None = None) -> None:
        super().__init__()
        self.encoder, self.hidden = encoder, hidden
        self.scenario, self.slack = scenario, slack

    def forward(self, seen: th.Tensor) -> th.Tensor:
        """Value all moves.

        :param seen: local observations o_i and what else is seen [B, anything]
        :return: action values [B, A], :data:`FORBIDDEN` where a move is not allowed
        """
        features, turn = self.encoder(seen)
        values = self.encoder.turn_back(self.hidden(features), turn)
        allowed = in_time(self.scenario, self.encoder.layout, seen, self.slack)
        return values.masked_fill(~allowed, FORBIDDEN)


class InTimeValues(Framed):
    """Mixin for a policy of action values: in the symmetric frame, of moves that are in time.

    :param slack: slots beyond T_i^min in which to arrive; without a number, all moves inside the airspace are allowed
    """

    net_arch: list[int]
    activation_fn: type[nn.Module]

    def __init__(self, *args: Any, slack: int | None = None, **kwargs: Any) -> None:
        self.slack = slack
        super().__init__(*args, **kwargs)

    def make_layers(self, num_actions: int) -> InTimeQ:
        """Build a Q-network's layers, from what is seen [B, anything] to action values [B, A]."""
        encoder = self.make_encoder(self.sees)
        hidden = nn.Sequential(*create_mlp(encoder.width, num_actions, self.net_arch, self.activation_fn))
        return InTimeQ(encoder, hidden, self.scenario, self.slack)

    def allowed(self, seen: th.Tensor) -> th.Tensor:
        """Which moves are in time [B, A], by what is seen [B, anything]."""
        return in_time(self.scenario, self.layout, seen, self.slack)

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return {**super()._get_constructor_parameters(), "slack": self.slack}


def in_time(scenario: Scenario, layout: ObservationLayout, seen: th.Tensor, slack: int | None) -> th.Tensor:
    """Which moves are in time, by what a UAV sees of itself: position, destination, T_i^min and clock.

    :param scenario: the game
    :param layout: where they lie in what is seen; it has the clock
    :param seen: local observations o_i and what else is seen [B, anything]
    :param slack: arrival by T_i^min and so many slots; without a number, all moves inside the airspace are in time
    :return: true for a move that is [B, A]
    """
    own, actions = seen.detach().cpu().numpy(), action_table(scenario.max_voxel_steps)
    here, goal = (
        np.rint(own[:, columns] * POSITION_UNIT_VOXELS).astype(np.int64)
        for columns in (layout.position, layout.destination)
    )
    if slack is None:
        return th.as_tensor(moves_inside(here, actions, scenario.grid), device=seen.device)
    least, clock = (
        np.rint(own[:, columns][:, 0] * SLOT_UNIT).astype(np.int64)
        for columns in (layout.min_slots, layout.extra("clock"))
    )
    left = np.minimum(least + slack, scenario.max_slots) - clock
    moves = moves_in_time(here, goal, left, actions, scenario.grid, scenario.max_voxel_steps)
    return th.as_tensor(moves, device=seen.device)


def draw_actions(allowed: th.Tensor | None, num_actions: int, shape: tuple[int, ...]) -> NDArray[np.int64]:
    """Draw actions, each that is allowed as likely as any other.

    :param allowed: true for an action that is allowed, at least one in each row [B, A]; none if all are
    :param num_actions: A
    :param shape: of the actions, B in all
    :return: the actions
    """
    if allowed is None:
        return np.random.randint(num_actions, size=shape)
    rows = allowed.cpu().numpy()
    return np.asarray(np.where(rows, np.random.random(rows.shape), -1.0).argmax(axis=1).reshape(shape))
