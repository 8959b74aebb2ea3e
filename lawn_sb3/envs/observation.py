"""What a UAV and a critic see: the local observation o_i (eq:obs) and the global state x (eq:global_state).

Policies get both in one flat vector [o_i | x]; the layout knows where everything lies in it. A policy that asks for it
also gets the UAV's index i behind them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from lawn_sb3.game.kernel import State
from lawn_sb3.game.radio import rate_unit_mbps
from lawn_sb3.scenario import Scenario

Floats32 = NDArray[np.float32]

POSITION_UNIT_VOXELS = 10.0
"""Positions are given in units of ten voxels, whatever the size of the airspace: one voxel stays visible."""
SLOT_UNIT = 10.0
"""Times are given in units of ten slots."""
LOAD_UNIT_UAVS = 4.0
"""Cell loads are given in units of four UAVs, whatever N: an actor can be moved to another N."""

OWN = 8  # numbers a UAV contributes: position, destination, T_min, EMA rate
CELL = 4  # numbers a GBS contributes: load, position


@dataclass(frozen=True)
class ObservationLayout:
    """Where everything lies in the flat observation [o_i | x], or [o_i | x | i] with the UAV's index, one-hot.

    :param num_uavs: N
    :param num_gbs: M
    :param with_index: whether the UAV's index follows
    """

    num_uavs: int
    num_gbs: int
    with_index: bool = False

    @property
    def local_dim(self) -> int:
        """Length of the local observation o_i."""
        return OWN + CELL * self.num_gbs

    @property
    def state_dim(self) -> int:
        """Length of the global state x."""
        return OWN * self.num_uavs + CELL * self.num_gbs

    @property
    def flat_dim(self) -> int:
        """Length of the flat observation [o_i | x], with the index if it has one."""
        return self.local_dim + self.state_dim + self.num_uavs * self.with_index

    @property
    def local(self) -> slice:
        """Columns of o_i in the flat observation."""
        return slice(0, self.local_dim)

    @property
    def state(self) -> slice:
        """Columns of x in the flat observation."""
        return slice(self.local_dim, self.local_dim + self.state_dim)

    @property
    def index(self) -> slice:
        """Columns of the UAV's index in the flat observation; empty without one."""
        return slice(self.local_dim + self.state_dim, self.flat_dim)

    @property
    def position(self) -> slice:
        """Columns of q_i in o_i."""
        return slice(0, 3)

    @property
    def destination(self) -> slice:
        """Columns of d_i in o_i."""
        return slice(3, 6)

    @property
    def min_slots(self) -> slice:
        """Column of T_i^min in o_i."""
        return slice(6, 7)

    @property
    def ema_rate(self) -> slice:
        """Column of the EMA rate in o_i."""
        return slice(7, 8)

    @property
    def cell_loads(self) -> slice:
        """Columns of the cell loads n_b in o_i."""
        return slice(OWN, self.local_dim, CELL)

    @property
    def state_uavs(self) -> slice:
        """Columns of the UAVs in x, OWN numbers each."""
        return slice(0, OWN * self.num_uavs)

    @property
    def state_cells(self) -> slice:
        """Columns of the GBSs in x."""
        return slice(OWN * self.num_uavs, self.state_dim)

    def local_space(self) -> spaces.Box:
        """Gymnasium space of o_i."""
        return spaces.Box(-np.inf, np.inf, (self.local_dim,), np.float32)

    def state_space(self) -> spaces.Box:
        """Gymnasium space of x."""
        return spaces.Box(-np.inf, np.inf, (self.state_dim,), np.float32)

    def flat_space(self) -> spaces.Box:
        """Gymnasium space of the flat observation."""
        return spaces.Box(-np.inf, np.inf, (self.flat_dim,), np.float32)


class Observer:
    """Reads observations off a simulator's state, in units that are the same for all methods.

    :param scenario: the scenario
    :param with_index: append each UAV's index
    """

    def __init__(self, scenario: Scenario, with_index: bool = False) -> None:
        self.layout = ObservationLayout(scenario.num_uavs, scenario.num_gbs, with_index)
        self._rate_unit_mbps = rate_unit_mbps(scenario)
        voxels = (scenario.gbs_positions - scenario.voxel_centre((0, 0, 0))) / scenario.voxel_size_m
        self._gbs = (voxels / POSITION_UNIT_VOXELS).astype(np.float32)  # [M, 3]

    def _own(self, state: State) -> Floats32:
        """q_i, d_i, T_min and EMA rate of every UAV [G, N, OWN]."""
        own = np.empty((*state.slot.shape, OWN), dtype=np.float32)
        own[..., 0:3] = state.position / POSITION_UNIT_VOXELS
        own[..., 3:6] = state.destination / POSITION_UNIT_VOXELS
        own[..., 6] = state.min_slots / SLOT_UNIT
        own[..., 7] = state.ema_rate_mbps / self._rate_unit_mbps
        return own

    def _cells(self, state: State) -> Floats32:
        """n_b and g_b of every GBS [G, M * CELL]."""
        cells = np.empty((len(state.cell_load), *self._gbs.shape[:1], CELL), dtype=np.float32)
        cells[..., 0] = state.cell_load / LOAD_UNIT_UAVS
        cells[..., 1:] = self._gbs
        return cells.reshape(len(cells), -1)

    def local(self, state: State) -> Floats32:
        """Local observations o_i (eq:obs).

        :param state: state of G games
        :return: one observation a UAV [G, N, local_dim]
        """
        return self.flat(state)[..., self.layout.local]

    def state(self, state: State) -> Floats32:
        """Global states x (eq:global_state).

        :param state: state of G games
        :return: one global state a game [G, state_dim]
        """
        return np.concatenate([self._own(state).reshape(len(state.slot), -1), self._cells(state)], axis=1)

    def flat(self, state: State) -> Floats32:
        """Flat observations [o_i | x], with the index if the layout has one.

        :param state: state of G games
        :return: one observation a UAV [G, N, flat_dim]
        """
        own, cells = self._own(state), self._cells(state)
        num_games, num_uavs, _ = own.shape
        flat = np.empty((num_games, num_uavs, self.layout.flat_dim), dtype=np.float32)
        flat[..., :OWN] = own
        flat[..., OWN : self.layout.local_dim] = cells[:, None]
        x = flat[..., self.layout.state]
        x[..., self.layout.state_uavs] = own.reshape(num_games, 1, -1)
        x[..., self.layout.state_cells] = cells[:, None]
        if self.layout.with_index:
            flat[..., self.layout.index] = np.eye(num_uavs, dtype=np.float32)
        return flat
