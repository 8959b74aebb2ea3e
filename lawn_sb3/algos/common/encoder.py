"""How what a UAV sees is put to its networks: turned into one octant, and places one-hot.

The airspace is turned and mirrored so that the UAV's own position lies in one octant of the square; the networks then
learn one eighth of the game, and their answers are turned back.
"""

from collections.abc import Collection
from typing import Literal

import numpy as np
import torch as th
from torch import nn
from torch.nn import functional

from lawn_sb3.envs.observation import LOAD_UNIT_UAVS, OWN, POSITION_UNIT_VOXELS, SLOT_UNIT, ObservationLayout, Sight
from lawn_sb3.envs.symmetry import frames
from lawn_sb3.game.radio import radio_map
from lawn_sb3.game.state import MEMORY_SLOTS
from lawn_sb3.scenario import Scenario

Inputs = Literal["one-hot", "relative"]
MOST_COUNTED = 7
"""Other UAVs that a thermometer tells apart."""
SLOTS_AHEAD = 4
"""Slots for which the loads that the others' intents lead to are worked out."""


class Encoder(nn.Module):
    """Turns and encodes observations; it has no weights.

    :param scenario: the game
    :param layout: where everything lies in the flat observation
    :param sees: what is seen besides o_i
    :param loads: whether the cell loads are looked at, and the EMA rate that they leave
    :param symmetric: turn the airspace so that the own position lies in one octant
    :param inputs: places ``one-hot``, or as numbers ``relative`` to the own position
    :raises UserError: if the scenario has not the symmetries
    :raises ValueError: if the observations do not hold what is seen
    """

    column: th.Tensor
    cell: th.Tensor
    action: th.Tensor
    cell_of: th.Tensor
    num_rbs: th.Tensor
    last: th.Tensor

    def __init__(
        self,
        scenario: Scenario,
        layout: ObservationLayout,
        sees: Collection[Sight] = (),
        loads: bool = True,
        symmetric: bool = True,
        inputs: Inputs = "one-hot",
    ) -> None:
        super().__init__()
        if inputs not in ("one-hot", "relative"):
            raise ValueError(f"inputs = {inputs!r}: one-hot or relative")
        missing = [sight for sight in sees if sight != "state" and sight not in layout.extras]
        if missing:
            raise ValueError(f"the observations do not hold {', '.join(missing)}: make_vec_env(..., extras={missing})")
        self.layout, self.grid, self.max_voxel_steps = layout, scenario.grid, scenario.max_voxel_steps
        self.sees, self.loads, self.inputs = tuple(sees), loads, inputs
        self.counted = min(layout.num_uavs - 1, MOST_COUNTED)
        tables = frames(scenario, symmetric)
        known = {"cell_of": radio_map(scenario).cell, "num_rbs": scenario.num_rbs, "last": np.array(scenario.grid) - 1}
        for name, table in {**tables._asdict(), **known}.items():
            self.register_buffer(name, th.as_tensor(table), persistent=False)
        self.width = self.forward(th.zeros(1, layout.flat_dim))[0].shape[1]

    def forward(self, seen: th.Tensor) -> tuple[th.Tensor, th.Tensor]:
        """Encode.

        :param seen: local observations o_i and what else is seen [B, anything]
        :return: features [B, width], and the index of the turn [B]
        """
        layout = self.layout
        here, goal = (self.voxels(seen[:, columns]) for columns in (layout.position, layout.destination))
        turn = self._turn(here, goal)
        place, target = self.turned(here, turn), self.turned(goal, turn)
        least, clock = seen[:, layout.min_slots] * SLOT_UNIT, seen[:, layout.extra("clock")] * SLOT_UNIT
        steps = (goal - here).abs().sum(dim=1, keepdim=True)
        parts = [
            *self._places(place, target),
            least / SLOT_UNIT,
            steps / POSITION_UNIT_VOXELS,
        ]
        if self.loads:  # the rate tells how many shared the own cell
            parts.append(seen[:, layout.ema_rate])
        needed = (steps + self.max_voxel_steps - 1).div(self.max_voxel_steps, rounding_mode="floor")
        parts.append(functional.one_hot(needed[:, 0].clamp(min=0, max=MOST_COUNTED), MOST_COUNTED + 1).float())
        if "clock" in self.sees:
            parts += [clock / SLOT_UNIT, (least - clock) / SLOT_UNIT, least - clock - needed]
        own = self.cell_of[here[:, 0], here[:, 1], here[:, 2]]  # [B]
        if self.loads:
            parts += self._counts(seen[:, layout.cell_loads], turn, own)
            for columns in self._remembered():
                parts += self._counts(seen[:, columns], turn, None)[:1]
        if "destinations" in self.sees:
            parts += self._counts(seen[:, layout.extra("destinations")], turn, None)[:1]
        if "intents" in self.sees:
            others = self.voxels(seen[:, layout.extra("intents")].reshape(len(seen), -1, 2, 3))
            parts += self.others(others, place, turn)
        if "index" in self.sees:
            parts.append(seen[:, layout.extra("index")])
        if "state" in self.sees:
            uavs = seen[:, layout.state][:, layout.state_uavs].reshape(len(seen), -1, OWN)
            parts.append(uavs[..., OWN - 2 :].flatten(1))  # T_min and EMA rate; the rest is in the intents
        return th.cat([part.float() for part in parts], dim=1), turn

    def turn_back(self, answers: th.Tensor, turn: th.Tensor) -> th.Tensor:
        """Put answers for actions of the airspace after each row's turn [B] in the order of the actions [B, A]."""
        return answers.gather(1, self.action[turn])

    def voxels(self, columns: th.Tensor) -> th.Tensor:
        """Whole voxel coordinates inside the airspace, of coordinates as they are observed [..., 3]."""
        whole = (columns * POSITION_UNIT_VOXELS).round().long()
        return th.minimum(whole.clamp(min=0), self.last)

    def _remembered(self) -> list[slice]:
        """Columns of the loads of each slot that is remembered."""
        if "memory" not in self.sees:
            return []
        start, num_gbs = self.layout.extra("memory").start, self.layout.num_gbs
        return [slice(start + h * num_gbs, start + (h + 1) * num_gbs) for h in range(MEMORY_SLOTS)]

    def _turn(self, here: th.Tensor, goal: th.Tensor) -> th.Tensor:
        """The turn after which the own position, and where that leaves a choice the destination, comes last [B]."""
        length, columns = self.grid[1], self.grid[0] * self.grid[1]
        at, to = (self.column[:, voxel[:, 0] * length + voxel[:, 1]] for voxel in (here, goal))  # [K, B]
        return (at * columns + to).argmax(dim=0)

    def turned(self, voxels: th.Tensor, turn: th.Tensor) -> th.Tensor:
        """Voxels [B, 3] or [B, J, 3] as they lie after each row's turn."""
        length = self.grid[1]
        rows = turn.reshape(-1, *(1,) * (voxels.dim() - 2))
        column = self.column[rows, voxels[..., 0] * length + voxels[..., 1]]
        x = column.div(length, rounding_mode="floor")
        return th.stack([x, column - x * length, voxels[..., 2]], dim=-1)

    def _places(self, place: th.Tensor, target: th.Tensor) -> list[th.Tensor]:
        """Position, destination and the way between them."""
        relative = target - place
        if self.inputs == "relative":
            return [place / POSITION_UNIT_VOXELS, relative / POSITION_UNIT_VOXELS]
        parts = []
        for k, size in enumerate(self.grid):
            parts += [functional.one_hot(voxel[:, k], size) for voxel in (place, target)]
            parts.append(functional.one_hot(relative[:, k] + size - 1, 2 * size - 1))
        return parts

    def _counts(self, counts: th.Tensor, turn: th.Tensor, own: th.Tensor | None) -> list[th.Tensor]:
        """UAVs in each cell, without oneself, as a thermometer; and the RB share on joining it."""
        others = (counts * LOAD_UNIT_UAVS).round().long()
        if own is not None:
            others = others.scatter_add(1, own[:, None], th.full_like(own[:, None], -1)).clamp(min=0)
        lying = th.empty_like(others).scatter_(1, self.cell[turn], others)  # as the cells lie after the turn
        steps = th.arange(1, self.counted + 1, device=counts.device)
        num_rbs = self.num_rbs.expand_as(others)
        rbs = th.empty_like(others).scatter_(1, self.cell[turn], num_rbs)
        share = rbs.div(lying + 1, rounding_mode="floor") / rbs
        return [(lying[..., None] >= steps).flatten(1), share]

    def others(self, others: th.Tensor, place: th.Tensor, turn: th.Tensor) -> list[th.Tensor]:
        """The others' positions and destinations, nearest first, and the loads that they lead to if all fly straight.

        :param others: positions and destinations of the others in voxels [B, N - 1, 2, 3]
        :param place: the own position after the turn [B, 3]
        :param turn: the index of each row's turn [B]
        :return: features [B, anything] each
        """
        at, to = others[:, :, 0], others[:, :, 1]  # [B, J, 3]
        flying = (at != to).any(dim=-1)  # who has arrived is where it headed for
        at_turned, to_turned = self.turned(at, turn), self.turned(to, turn)
        apart = (at_turned - place[:, None]).abs().sum(dim=-1) + 1000 * (~flying).long()
        order = apart.argsort(dim=1, stable=True)
        rows = th.arange(len(at), device=at.device)[:, None]
        whole = th.cat([at_turned - place[:, None], to_turned - place[:, None], at_turned, to_turned], dim=-1)
        listed = (whole / POSITION_UNIT_VOXELS * flying[..., None])[rows, order]
        parts = [listed.flatten(1), flying[rows, order]]
        steps = (to - at).abs().sum(dim=-1)  # [B, J]
        for ahead in range(1, SLOTS_AHEAD + 1):
            flown = (ahead * self.max_voxel_steps / steps.clamp(min=1)).clamp(max=1.0)
            then = (at_turned + flown[..., None] * (to_turned - at_turned)).round().long()
            cell = self.cell_of[then[..., 0], then[..., 1], then[..., 2]]  # [B, J]
            there = flying & (steps > (ahead - 1) * self.max_voxel_steps)
            loads = th.zeros(len(at), self.layout.num_gbs, device=at.device).scatter_add_(1, cell, there.float())
            parts.append(loads / LOAD_UNIT_UAVS * 2.0)
        return parts
