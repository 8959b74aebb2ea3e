"""In-time moves for networks of action values: what is not allowed is worth less than anything that is."""

from __future__ import annotations

import numpy as np
import torch as th
from numpy.typing import NDArray
from torch import nn

from lawn_sb3.algos.common.encoder import Encoder
from lawn_sb3.envs.observation import POSITION_UNIT_VOXELS, SLOT_UNIT
from lawn_sb3.game.airspace import action_table, moves_in_time, moves_inside

FORBIDDEN = -1e6
"""The value of a move that is not allowed; finite, so that a target that multiplies it by 0 stays a number."""


class InTimeQ(nn.Module):
    """Action values in the symmetric frame, of moves that are in time.

    The moves are worked out from what the UAV sees of itself: position, destination, T_i^min and clock.

    :param encoder: how what is seen is put to the hidden layers; its observations hold the clock
    :param hidden: layers from the encoder's features to the values of the turned actions
    :param max_slots: T_i^max
    :param slack: allow arrival by T_i^min and so many slots; without a number, all moves inside the airspace
    """

    def __init__(self, encoder: Encoder, hidden: nn.Module, max_slots: int, slack: int | None = None) -> None:
        super().__init__()
        self.encoder, self.hidden = encoder, hidden
        self.max_slots, self.slack = max_slots, slack

    def forward(self, seen: th.Tensor) -> th.Tensor:
        """Value all moves.

        :param seen: local observations o_i and what else is seen [B, anything]
        :return: action values [B, A], :data:`FORBIDDEN` where a move is not allowed
        """
        features, turn = self.encoder(seen)
        values = self.encoder.turn_back(self.hidden(features), turn)
        return values.masked_fill(~self.allowed(seen), FORBIDDEN)

    def allowed(self, seen: th.Tensor) -> th.Tensor:
        """Which moves are allowed [B, A], by what is seen [B, anything]."""
        return in_time(self.encoder, seen, self.max_slots, self.slack)


def in_time(encoder: Encoder, seen: th.Tensor, max_slots: int, slack: int | None) -> th.Tensor:
    """Which moves are in time, by what a UAV sees of itself.

    :param encoder: whose observations they are; they hold the clock
    :param seen: local observations o_i and what else is seen [B, anything]
    :param max_slots: T_i^max
    :param slack: arrival by T_i^min and so many slots; without a number, all moves inside the airspace are in time
    :return: true for a move that is [B, A]
    """
    layout, own = encoder.layout, seen.detach().cpu().numpy()
    here, goal = (
        np.rint(own[:, columns] * POSITION_UNIT_VOXELS).astype(np.int64)
        for columns in (layout.position, layout.destination)
    )
    actions = action_table(encoder.max_voxel_steps)
    if slack is None:
        return th.as_tensor(moves_inside(here, actions, encoder.grid), device=seen.device)
    least, clock = (
        np.rint(own[:, columns][:, 0] * SLOT_UNIT).astype(np.int64)
        for columns in (layout.min_slots, layout.extra("clock"))
    )
    left = np.minimum(least + slack, max_slots) - clock
    moves = moves_in_time(here, goal, left, actions, encoder.grid, encoder.max_voxel_steps)
    return th.as_tensor(moves, device=seen.device)


def draw_allowed(allowed: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Draw one allowed action per row, each as likely as any other.

    :param allowed: true for an action that is allowed, at least one in each row [B, A]
    :return: actions [B]
    """
    drawn: NDArray[np.int64] = np.where(allowed, np.random.random(allowed.shape), -1.0).argmax(axis=1)
    return drawn
