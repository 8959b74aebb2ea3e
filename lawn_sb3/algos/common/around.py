"""What lies around a UAV, put to its networks so that neither N, nor M, nor the size of the airspace changes anything.

A UAV sees a map of the rates that it would have in the places around it: what an RB carries there, times the RBs that
it would be given on joining the cell that serves the place. Cells are thereby a set, in reach or not, and their loads
count as what they leave of K_b. The map is turned and mirrored so that the destination lies in one octant ahead.
"""

import numpy as np
import torch as th
from torch import nn
from torch.nn import functional

from lawn_sb3.envs.observation import LOAD_UNIT_UAVS, POSITION_UNIT_VOXELS, SLOT_UNIT, ObservationLayout
from lawn_sb3.envs.symmetry import EIGHT, Ints, Turn
from lawn_sb3.game.airspace import action_table
from lawn_sb3.game.radio import radio_map, rate_unit_mbps
from lawn_sb3.scenario import Scenario

NEAR_VOXELS = 4
"""Up to so many voxels away, every voxel is on the map."""
FAR_VOXELS = tuple(range(-6, 19, 3))
"""Along x and y, where else it is looked at: farther ahead than behind."""
TOLD_APART = 12
"""Voxels along each axis, and slots, up to which the way to the destination is told apart exactly."""


class Around(nn.Module):
    """Turns and encodes observations; it has no weights.

    :param scenario: the game
    :param layout: where everything lies in the flat observation, which holds the clock
    """

    action: th.Tensor
    place: th.Tensor
    cell_of: th.Tensor
    rate: th.Tensor
    num_rbs: th.Tensor
    last: th.Tensor

    def __init__(self, scenario: Scenario, layout: ObservationLayout) -> None:
        super().__init__()
        self.layout, self.max_voxel_steps = layout, scenario.max_voxel_steps
        moves = action_table(scenario.max_voxel_steps)
        index = {tuple(move): a for a, move in enumerate(moves.tolist())}
        back = [[index[tuple(move)] for move in _turned_back(moves, turn).tolist()] for turn in EIGHT]
        link = radio_map(scenario)
        tables = {
            "action": np.argsort(back, axis=1),  # which turned move each action is
            "place": np.stack([_turned_back(_places(), turn) for turn in EIGHT]),
            "cell_of": link.cell,
            "rate": (link.rb_rate_mbps / rate_unit_mbps(scenario)).astype(np.float32),
            "num_rbs": scenario.num_rbs,
            "last": np.array(scenario.grid) - 1,
        }
        for name, table in tables.items():
            self.register_buffer(name, th.as_tensor(table), persistent=False)
        self.width = self.forward(th.zeros(1, layout.flat_dim))[0].shape[1]

    def forward(self, seen: th.Tensor) -> tuple[th.Tensor, th.Tensor]:
        """Encode.

        :param seen: local observations o_i and what else is seen [B, anything]
        :return: features [B, width], and the index of the turn [B]
        """
        layout = self.layout
        here, goal = (self._voxels(seen[:, columns]) for columns in (layout.position, layout.destination))
        way, turn = self._ahead(goal - here)
        steps = way.abs().sum(dim=1)
        needed = (steps + self.max_voxel_steps - 1).div(self.max_voxel_steps, rounding_mode="floor")
        least, clock = (
            (seen[:, columns] * SLOT_UNIT).round().long().flatten()
            for columns in (layout.min_slots, layout.extra("clock"))
        )
        spare = (least - clock) * self.max_voxel_steps - steps  # voxel steps aside that are still in time
        parts = [
            way.clamp(min=-TOLD_APART, max=TOLD_APART) / POSITION_UNIT_VOXELS,
            *(_told_apart(way[:, k], 0, TOLD_APART) for k in (0, 1)),
            _told_apart(way[:, 2], -self.max_voxel_steps, self.max_voxel_steps),
            _told_apart(here[:, 2], 0, self.max_voxel_steps),
            _told_apart(needed, 0, TOLD_APART),
            _told_apart(spare, 0, self.max_voxel_steps),
            seen[:, layout.ema_rate],
            self._rates(seen[:, layout.cell_loads], here, turn),
        ]
        return th.cat([part.float() for part in parts], dim=1), turn

    def turn_back(self, answers: th.Tensor, turn: th.Tensor) -> th.Tensor:
        """Put answers for turned moves after each row's turn [B] in the order of the actions [B, A]."""
        return answers.gather(1, self.action[turn])

    def _voxels(self, columns: th.Tensor) -> th.Tensor:
        """Whole voxel coordinates inside the airspace, of coordinates as they are observed [..., 3]."""
        return th.minimum((columns * POSITION_UNIT_VOXELS).round().long().clamp(min=0), self.last)

    def _ahead(self, way: th.Tensor) -> tuple[th.Tensor, th.Tensor]:
        """A way [B, 3] after the turn that makes it lead along x, and less far along y; which of EIGHT it is."""
        x, y, z = way.unbind(dim=1)
        swap = y.abs() > x.abs()
        first, second = th.where(swap, y, x), th.where(swap, x, y)
        turn = 4 * swap.long() + 2 * (first < 0).long() + (second < 0).long()
        return th.stack([first.abs(), second.abs(), z], dim=1), turn

    def _rates(self, loads: th.Tensor, here: th.Tensor, turn: th.Tensor) -> th.Tensor:
        """Rates that the UAV would have around it, in the unit of the rewards [B, P]; 0 out of the airspace."""
        others = (loads * LOAD_UNIT_UAVS).round().long()  # [B, M]
        own = self.cell_of[here[:, 0], here[:, 1], here[:, 2]][:, None]
        others = others.scatter_add(1, own, th.full_like(own, -1)).clamp(min=0)
        there = here[:, None] + self.place[turn]  # [B, P, 3]
        inside = ((there >= 0) & (there <= self.last)).all(dim=-1)
        x, y, z = th.minimum(there.clamp(min=0), self.last).unbind(dim=-1)
        cell = self.cell_of[x, y, z]
        share = self.num_rbs[cell].div(others.gather(1, cell) + 1, rounding_mode="floor")
        rates: th.Tensor = share * self.rate[x, y, z] * inside
        return rates


def _places() -> Ints:
    """The places on the map, from the own one [P, 3]: all that are near, and a coarse grid of those that are far."""
    near = range(-NEAR_VOXELS, NEAR_VOXELS + 1)
    close = [(x, y, 0) for x in near for y in near if abs(x) + abs(y) <= NEAR_VOXELS]
    far = [(x, y, 0) for x in FAR_VOXELS for y in FAR_VOXELS if abs(x) + abs(y) > NEAR_VOXELS]
    return np.array(close + far, dtype=np.int64)


def _turned_back(ways: Ints, turn: Turn) -> Ints:
    """Displacements [..., 3] as they are in the airspace, of those that lie as given after a turn."""
    swap, mirror_x, mirror_y = turn
    x, y, z = np.moveaxis(ways, -1, 0)
    x, y = (-x if mirror_x else x), (-y if mirror_y else y)
    return np.stack([y, x, z] if swap else [x, y, z], axis=-1)


def _told_apart(values: th.Tensor, low: int, high: int) -> th.Tensor:
    """Whole numbers [B] one-hot, those beyond the bounds as the bounds."""
    return functional.one_hot(values.clamp(min=low, max=high) - low, high - low + 1)
