"""The paper's game in plain Python, UAV by UAV and slot by slot.

Written from the paper's equations and from the readings that :class:`Scenario` describes, apart from
``lawn_sb3.game``, of which it uses nothing. It is slow, and meant to be checked against the page.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from lawn_sb3.scenario import Scenario

Voxel = tuple[int, int, int]
Point = tuple[float, float, float]


class Slot(NamedTuple):
    """What one slot gave one UAV; the fields bear the names they have in the simulator's outcome."""

    reward_terms: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    rate_mbps: float = 0.0
    cell: int = 0
    cell_load: int = 0
    num_rbs: int = 0
    corrected_rate_mbps: float = 0.0
    utility_mbps: float = 0.0
    collided: bool = False
    arrived: bool = False
    timed_out: bool = False


@dataclass
class Uav:
    position: Voxel
    destination: Voxel
    min_slots: int
    slot: int = 0
    ema_rate_mbps: float = 0.0
    flying: bool = True
    has_arrived: bool = False


class ReferenceGame:
    """One game, with an origin and a destination for every UAV."""

    def __init__(self, scenario: Scenario, missions: Sequence[tuple[Voxel, Voxel]]) -> None:
        self.scenario = scenario
        height_m = scenario.max_altitude_m - scenario.min_altitude_m
        self.grid = (scenario.width_voxels, scenario.length_voxels, round(height_m / scenario.voxel_size_m))
        self.sites = gbs_sites(scenario)
        shared = scenario.rbs_per_gbs
        self.rbs = [shared] * len(self.sites) if isinstance(shared, int) else list(shared)
        self.uavs = [self.fresh_uav(*mission) for mission in missions]

    def fresh_uav(self, origin: Voxel, destination: Voxel) -> Uav:
        """A UAV at the start of a mission, with T_i^min of Eq. (8)."""
        steps = sum(abs(o - d) for o, d in zip(origin, destination, strict=True))
        return Uav(origin, destination, min_slots=math.ceil(steps / self.scenario.max_voxel_steps))

    def play(self, displacements: Sequence[Voxel]) -> list[Slot]:
        """Play one slot: everybody moves, then everybody is judged."""
        in_flight = [uav for uav in self.uavs if uav.flying]
        before = {id(uav): uav.position for uav in in_flight}
        for uav, displacement in zip(self.uavs, displacements, strict=True):
            if uav.flying:
                uav.position = self.moved(uav, displacement)
        rates = {id(uav): self.rate(uav) for uav in in_flight}
        collisions = {id(uav): self.collides(uav) for uav in in_flight}
        return [
            self.judged(uav, before[id(uav)], *rates[id(uav)], collisions[id(uav)]) if uav in in_flight else Slot()
            for uav in self.uavs
        ]

    def moved(self, uav: Uav, displacement: Voxel) -> Voxel:
        """Eq. (3), inside the airspace."""
        wanted = tuple(q + a for q, a in zip(uav.position, displacement, strict=True))
        x, y, z = (min(max(q, 0), size - 1) for q, size in zip(wanted, self.grid, strict=True))
        inside = x, y, z
        if wanted != inside and self.scenario.out_of_bounds == "hover":
            return uav.position
        if self.scenario.arrival == "fly-through":
            for voxel in way(uav.position, inside):
                if voxel == uav.destination:
                    return voxel
        return inside

    def distances_m(self, voxel: Voxel) -> list[float]:
        """Distance from the centre of a voxel to every GBS."""
        size = self.scenario.voxel_size_m
        x, y, z = ((k + 0.5) * size for k in voxel)
        return [math.dist((x, y, z + self.scenario.min_altitude_m), site) for site in self.sites]

    def cell(self, voxel: Voxel) -> int:
        """The nearest GBS; the first of those that are equally near."""
        distances = self.distances_m(voxel)
        return next(b for b, d in enumerate(distances) if d < min(distances) + 1e-6)

    def in_airspace(self, uav: Uav) -> bool:
        """Whether a UAV takes RBs and room."""
        return uav.flying or (uav.has_arrived and self.scenario.arrived_uav == "stays")

    def loads(self) -> list[int]:
        cells = [self.cell(uav.position) for uav in self.uavs if self.in_airspace(uav)]
        return [cells.count(b) for b in range(len(self.sites))]

    def rate(self, uav: Uav) -> tuple[int, int, int, float]:
        """Serving GBS, its load, RBs by Eq. (1) and rate in Mbps by Eq. (2)."""
        b = self.cell(uav.position)
        load = self.loads()[b]
        rbs = self.rbs[b] // load
        return b, load, rbs, rbs * one_rb_mbps(self.scenario, self.distances_m(uav.position)[b])

    def collides(self, uav: Uav) -> bool:
        """Whether Eq. (4) is violated at this UAV."""
        others = [other for other in self.uavs if other is not uav and self.in_airspace(other)]
        return any(other.position == uav.position for other in others)

    def judged(self, uav: Uav, before: Voxel, cell: int, load: int, rbs: int, rate: float, collided: bool) -> Slot:
        """EMA rate, utility and the four terms of the reward; a UAV that is done stops flying."""
        s = self.scenario
        old_ema = uav.ema_rate_mbps
        uav.slot += 1
        uav.ema_rate_mbps = (1 - s.ema_beta) * old_ema + s.ema_beta * rate
        horizon = uav.slot if s.bias_horizon == "completion" else s.max_slots
        corrected = uav.ema_rate_mbps / (1 - (1 - s.ema_beta) ** horizon)
        arrived = uav.position == uav.destination
        timed_out = uav.slot == s.max_slots and not arrived
        utility = corrected * uav.min_slots / uav.slot if arrived else 0.0
        uav.has_arrived = arrived
        uav.flying = not arrived and not timed_out

        progress = math.dist(before, uav.destination) - math.dist(uav.position, uav.destination)
        terms = (
            (uav.ema_rate_mbps - old_ema) / self.rate_unit_mbps(),
            s.nav_weight * progress,
            -s.collision_penalty if collided else 0.0,
            utility / self.rate_unit_mbps() if arrived else -s.fail_penalty if timed_out else 0.0,
        )
        return Slot(terms, rate, cell, load, rbs, corrected, utility, collided, arrived, timed_out)

    def rate_unit_mbps(self) -> float:
        """Unit of rates inside rewards: 1 Mbps, or a lone UAV's rate one voxel away from the richest GBS."""
        if self.scenario.rate_unit == "mbps":
            return 1.0
        return max(self.rbs) * one_rb_mbps(self.scenario, self.scenario.voxel_size_m)


def way(start: Voxel, end: Voxel) -> Iterator[Voxel]:
    """The voxels on the way, one step at a time: along x, then y, then z; without the start."""
    here = list(start)
    for axis in range(3):
        while here[axis] != end[axis]:
            here[axis] += 1 if end[axis] > here[axis] else -1
            yield here[0], here[1], here[2]


def gbs_sites(scenario: Scenario) -> list[Point]:
    if scenario.gbs_positions_m is not None:
        return list(scenario.gbs_positions_m)
    columns, rows = scenario.gbs_grid
    xs = along_side(scenario, columns, scenario.width_voxels * scenario.voxel_size_m)
    ys = along_side(scenario, rows, scenario.length_voxels * scenario.voxel_size_m)
    return [(x, y, scenario.gbs_height_m) for x in xs for y in ys]


def along_side(scenario: Scenario, count: int, side_m: float) -> list[float]:
    """Middles of equal parts of a side, or from corner to corner; a single one lies in the middle either way."""
    if scenario.gbs_layout == "tile-centres" or count == 1:
        part_m = side_m / count
        return [part_m / 2 + k * part_m for k in range(count)]
    return [side_m / (count - 1) * k for k in range(count)]


def one_rb_mbps(scenario: Scenario, distance_m: float) -> float:
    """Eq. (2) for a single RB, with powers in watts."""
    power_w = 10 ** ((scenario.tx_power_dbm - 30) / 10)
    gain = 10 ** (scenario.ref_gain_db / 10)
    noise_w = 10 ** ((scenario.noise_density_dbm_hz - 30) / 10) * scenario.rb_bandwidth_hz
    snr = power_w * gain / (noise_w * distance_m**scenario.path_loss_exponent)
    return scenario.rb_bandwidth_hz * math.log2(1 + snr) / 1e6
