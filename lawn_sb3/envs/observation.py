"""What a UAV and a critic see: the local observation o_i and the global state x.

Both travel in one flat vector [o_i | x]; the layout knows where everything lies in it. What else a policy asks to see
stands between them, so that an actor that may not see x is handed only the columns before it.
"""

from collections.abc import Collection
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from lawn_sb3.game.radio import radio_map, rate_unit_mbps
from lawn_sb3.game.state import MEMORY_SLOTS, State
from lawn_sb3.scenario import Scenario

Floats32 = NDArray[np.float32]

POSITION_UNIT_VOXELS = 10.0
"""Positions are given in units of ten voxels, whatever the size of the airspace: one voxel stays visible."""
SLOT_UNIT = 10.0
"""Times are given in units of ten slots."""
LOAD_UNIT_UAVS = 4.0
"""Cell loads are given in units of four UAVs, whatever N: an actor can be moved to another N."""

OWN = 8  # numbers per UAV: position, destination, T_min, EMA rate
CELL = 4  # numbers per GBS: load, position
VOXEL = 3  # coordinates of a voxel

Extra = Literal["clock", "memory", "destinations", "intents", "index"]
"""What a policy can ask to see besides o_i, in the order in which it stands in the flat observation:

- ``clock``: how many slots of its mission it has flown;
- ``memory``: the cell loads it saw in the slots before, newest first;
- ``destinations``: how many other UAVs in the air head for each cell;
- ``intents``: position and destination of every other UAV, as a shared flight plan gives them;
- ``index``: which of the N UAVs it is, one-hot.
"""
EXTRAS: tuple[Extra, ...] = get_args(Extra)
Sight = Literal[Extra, "state"]
"""The same, or all of x."""
NOT_BY_N: frozenset[Extra] = frozenset({"clock", "memory", "destinations"})
"""Extras that have the same length for every number of UAVs."""


@dataclass(frozen=True)
class ObservationLayout:
    """Where everything lies in the flat observation [o_i | extras | x].

    :param num_uavs: N
    :param num_gbs: M
    :param extras: what stands between o_i and x, in the order of :data:`EXTRAS`

    >>> layout = ObservationLayout(num_uavs=4, num_gbs=4)
    >>> layout.local_dim, layout.state_dim  # 8 + 4 * 4 and 4 * 8 + 4 * 4
    (24, 48)
    """

    num_uavs: int
    num_gbs: int
    extras: tuple[Extra, ...] = ()

    position: ClassVar[slice] = slice(0, 3)
    """Columns of q_i in o_i."""
    destination: ClassVar[slice] = slice(3, 6)
    """Columns of d_i in o_i."""
    min_slots: ClassVar[slice] = slice(6, 7)
    """Column of T_i^min in o_i."""
    ema_rate: ClassVar[slice] = slice(7, 8)
    """Column of the EMA rate in o_i."""

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
        """Length of the flat observation."""
        return self.local_dim + self.extras_dim + self.state_dim

    @property
    def extras_dim(self) -> int:
        """Length of what stands between o_i and x."""
        return sum(self._width(extra) for extra in self.extras)

    @property
    def local(self) -> slice:
        """Columns of o_i in the flat observation."""
        return slice(0, self.local_dim)

    @property
    def state(self) -> slice:
        """Columns of x in the flat observation."""
        start = self.local_dim + self.extras_dim
        return slice(start, start + self.state_dim)

    def seen(self, sees: Collection[Sight]) -> slice:
        """Columns of the flat observation for an actor whose policy ``sees`` this: all, or those before x."""
        return slice(0, self.state.stop if "state" in sees else self.state.start)

    def _width(self, extra: Extra) -> int:
        others = self.num_uavs - 1
        widths: dict[Extra, int] = {
            "clock": 1,
            "memory": MEMORY_SLOTS * self.num_gbs,
            "destinations": self.num_gbs,
            "intents": 2 * VOXEL * others,
            "index": self.num_uavs,
        }
        return widths[extra]

    def extra(self, name: Extra) -> slice:
        """Columns of one of the extras in the flat observation; empty if the layout does not have it."""
        start = self.local_dim
        for extra in self.extras:
            if extra == name:
                return slice(start, start + self._width(extra))
            start += self._width(extra)
        return slice(start, start)

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


def space_of(length: int) -> spaces.Box:
    """Gymnasium space of an observation of so many numbers."""
    return spaces.Box(-np.inf, np.inf, (length,), np.float32)


class Observer:
    """Makes observations of a simulator's state, in units that are the same for all methods.

    :param scenario: the scenario
    :param extras: what stands between o_i and x
    """

    def __init__(self, scenario: Scenario, extras: Collection[Extra] = ()) -> None:
        chosen = tuple(extra for extra in EXTRAS if extra in extras)
        self.layout = ObservationLayout(scenario.num_uavs, scenario.num_gbs, chosen)
        self._rate_unit_mbps = rate_unit_mbps(scenario)
        self._arrived_stays = scenario.arrived_uav == "stays"
        voxels = (scenario.gbs_positions - scenario.voxel_centre((0, 0, 0))) / scenario.voxel_size_m
        self._gbs = (voxels / POSITION_UNIT_VOXELS).astype(np.float32)  # [M, 3]
        self._cell = radio_map(scenario).cell  # [W, L, H]

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

    def _extra(self, name: Extra, state: State) -> NDArray[np.floating]:
        """One of the extras [G, N, its width]; [1, N, ...] if it is the same in all games."""
        num_games, num_uavs = state.slot.shape
        if name == "clock":
            return state.slot[..., None] / SLOT_UNIT
        if name == "memory":  # of its own mission alone
            own = state.slot[..., None] > np.arange(MEMORY_SLOTS)  # [G, N, H]
            seen = own[..., None] * state.past_load[:, None] / LOAD_UNIT_UAVS
            return np.asarray(seen.reshape(num_games, num_uavs, -1))
        if name == "destinations":
            return np.asarray(self.headed(state) / LOAD_UNIT_UAVS)
        if name == "index":
            return np.eye(num_uavs)[None]
        others = (np.arange(num_uavs)[:, None] + np.arange(1, num_uavs)) % num_uavs  # [N, N - 1]
        intents = np.concatenate([state.position, state.destination], axis=-1)[:, others]  # [G, N, N - 1, 6]
        return np.asarray(intents.reshape(num_games, num_uavs, -1) / POSITION_UNIT_VOXELS)

    def headed(self, state: State) -> NDArray[np.int64]:
        """How many other UAVs head for each cell [G, N, M]: those in the air, and those that stay on arrival."""
        x, y, z = np.moveaxis(state.destination, -1, 0)
        counts = np.eye(self.layout.num_gbs, dtype=np.int64)[self._cell[x, y, z]]  # [G, N, M]
        if not self._arrived_stays:
            counts *= state.flying[..., None]
        return np.asarray(counts.sum(axis=1, keepdims=True) - counts)

    def local(self, state: State) -> Floats32:
        """Local observations, Eq. (12), eq:obs.

        o_i(t) = [q_i(t), d_i, T_i^min, R-bar_i(t), {n_b(t), g_b} for every GBS b]

        :param state: state of G games
        :return: one observation per UAV [G, N, local_dim]
        """
        own, cells = self._own(state), self._cells(state)[:, None]
        return np.concatenate([own, np.broadcast_to(cells, (*own.shape[:2], cells.shape[-1]))], axis=-1)

    def state(self, state: State) -> Floats32:
        """Global states, Eq. (11), eq:global_state.

        x(t) = [{q_i(t), d_i, T_i^min, R-bar_i(t)} for every UAV i, {n_b(t), g_b} for every GBS b]

        :param state: state of G games
        :return: one global state per game [G, state_dim]
        """
        return np.concatenate([self._own(state).reshape(len(state.slot), -1), self._cells(state)], axis=1)

    def flat(self, state: State) -> Floats32:
        """Flat observations [o_i | extras | x].

        :param state: state of G games
        :return: one observation per UAV [G, N, flat_dim]
        """
        return self._written(state, self.layout.flat_dim)

    def seen(self, state: State) -> Floats32:
        """The same without x, for actors that do not read it: [o_i | extras].

        :param state: state of G games
        :return: one observation per UAV [G, N, local_dim + extras_dim]
        """
        return self._written(state, self.layout.state.start)

    def _written(self, state: State, length: int) -> Floats32:
        """The first ``length`` columns of the flat observations, with x or without."""
        own, cells = self._own(state), self._cells(state)
        num_games, num_uavs, _ = own.shape
        flat = np.empty((num_games, num_uavs, length), dtype=np.float32)
        flat[..., :OWN] = own
        flat[..., OWN : self.layout.local_dim] = cells[:, None]
        for extra in self.layout.extras:
            flat[..., self.layout.extra(extra)] = self._extra(extra, state)
        if length > self.layout.state.start:
            x = flat[..., self.layout.state]
            x[..., self.layout.state_uavs] = own.reshape(num_games, 1, -1)
            x[..., self.layout.state_cells] = cells[:, None]
        return flat


def broadcast_bits(sees: Collection[Sight], scenario: Scenario) -> int:
    """Bits that every UAV has to broadcast in every slot so that the actors can see what they see.

    Cell loads are counted by the GBSs, and clock, memory and index are a UAV's own. The cell that it heads for is one
    of M; a position or a destination is one of the voxels; T_i^min is a whole number, and the EMA rate a 32-bit float.

    :param sees: what a policy says its actor sees
    :param scenario: the game
    :return: bits, without any coding

    >>> broadcast_bits({"destinations"}, Scenario()), broadcast_bits({"intents"}, Scenario())  # 4 cells, 300 voxels
    (2, 18)
    """
    voxel = (scenario.num_voxels - 1).bit_length()
    if "state" in sees:
        steps = sum(size - 1 for size in scenario.grid)
        return 2 * voxel + (-(-steps // scenario.max_voxel_steps)).bit_length() + 32
    if "intents" in sees:
        return 2 * voxel
    return (scenario.num_gbs - 1).bit_length() if "destinations" in sees else 0
