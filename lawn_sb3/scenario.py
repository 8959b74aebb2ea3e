"""Every constant of the game: symbol, unit, bounds, and where its value comes from.

The paper's Table I states some constants; the others were inferred from the figures it prints, or chosen where these
leave several values possible or depend on none. Where the text can be read in more than one way, the reading is a field
too. The slot duration (delta_t) is in no equation of the paper, so it is not a field.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, Self, cast

import numpy as np
import yaml
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from lawn_sb3.config import parse_overrides, read_yaml_mapping, validated
from lawn_sb3.errors import UserError, unknown_name

MOST_GBS = 10_000
MOST_RBS = 1_000_000
MOST_SLOTS = 1_000_000
MOST_VOXELS = 10_000_000
"""Tables of the airspace hold two numbers per voxel."""

Source = Literal["stated", "inferred", "chosen"]


def constant(default: Any, symbol: str, unit: str, source: Source, text: str, **bounds: Any) -> Any:
    """Declare one constant of the game.

    :param default: its value in the preset ``paper``
    :param symbol: the paper's symbol, or ``-`` where it has none
    :param unit: the unit of the value
    :param source: ``stated`` in the paper, ``inferred`` from its figures, or ``chosen`` by this kit
    :param text: what it is, and for an inferred one the evidence
    :param bounds: pydantic's bounds: ``gt, ge, lt, le``
    :return: the pydantic field
    """
    extra: dict[str, Any] = {"symbol": symbol, "unit": unit, "source": source}
    return Field(default, description=text, json_schema_extra=extra, **bounds)


class Scenario(BaseModel):
    """The constants and readings that define one game; frozen, and valid once it exists."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: str = Field(default="paper", description="what tables and run directories call this scenario")

    # Airspace and flight (Section II-B)
    num_uavs: int = constant(4, "N", "UAVs", "stated", "number of UAVs", ge=1, le=10_000)
    width_voxels: int = constant(
        10, "W", "voxels", "inferred", "Table I's 100 read as metres: Random row", ge=1, le=10_000
    )
    length_voxels: int = constant(
        10, "L", "voxels", "inferred", "Table I's 100 read as metres: Random row", ge=1, le=10_000
    )
    voxel_size_m: float = constant(10.0, "Delta_s", "m", "stated", "edge of a voxel", ge=1e-3, le=1e6)
    min_altitude_m: float = constant(
        0.0, "h_min", "m", "chosen", "floor of the airspace; the paper names no value", ge=0, le=1e6
    )
    max_altitude_m: float = constant(
        30.0, "h_max", "m", "inferred", "Table I's 30 read as metres: H = 3 voxels", gt=0, le=1e6
    )
    max_voxel_steps: int = constant(3, "v_max", "voxels/slot", "stated", "most voxel steps a slot (L1)", ge=1, le=30)
    max_slots: int = constant(100, "T_max", "slots", "stated", "deadline of a mission", ge=1, le=MOST_SLOTS)

    # Base stations and radio link (Section II-A)
    gbs_grid: tuple[int, int] = constant((2, 2), "M", "GBSs", "stated", "columns and rows of the regular GBS grid")
    gbs_layout: Literal["tile-centres", "corners"] = constant(
        "tile-centres",
        "g_b",
        "-",
        "chosen",
        "where the regular grid lies; either is possible, with its own link budget",
    )
    gbs_height_m: float = constant(
        0.0, "g_b", "m", "stated", "antenna height of the regular grid: ground level", ge=0, le=1e6
    )
    gbs_positions_m: tuple[tuple[float, float, float], ...] | None = constant(
        None, "g_b", "m", "chosen", "explicit GBS positions (x, y, z), instead of the regular grid"
    )
    rbs_per_gbs: int | tuple[int, ...] = constant(10, "K_b", "RBs", "stated", "RBs of every GBS, or one number a GBS")
    rb_bandwidth_hz: float = constant(180e3, "Delta f", "Hz", "stated", "sub-bandwidth of an RB", gt=0, le=1e12)
    path_loss_exponent: float = constant(2.0, "alpha", "-", "stated", "path-loss exponent", gt=0, le=10)
    tx_power_dbm: float = constant(
        20.0, "P_tx", "dBm", "inferred", "transmit power per RB: rate of Random", ge=-100, le=100
    )
    ref_gain_db: float = constant(
        -30.0, "beta_0", "dB", "inferred", "channel gain at 1 m: rate of Random", ge=-200, le=100
    )
    noise_density_dbm_hz: float = constant(
        -174.0,
        "sigma^2",
        "dBm/Hz",
        "inferred",
        "noise density; over one RB it gives sigma^2: rate of Random",
        ge=-300,
        le=0,
    )

    # Payoff (Section III)
    ema_beta: float = constant(
        0.1, "beta", "-", "chosen", "smoothing of the EMA rate; the figures hardly depend on it", ge=1e-6, lt=1
    )
    nav_weight: float = constant(
        0.5, "omega", "1/voxel", "inferred", "reward per voxel of progress: reward rows", ge=0, le=1e6
    )
    collision_penalty: float = constant(
        1.0, "rho_col", "-", "inferred", "cost of a collision: reward of Random", ge=0, le=1e6
    )
    fail_penalty: float = constant(5.0, "r_fail", "-", "inferred", "cost of a timeout: reward of Random", ge=0, le=1e6)

    # Readings: where the text leaves more than one way to play
    rate_unit: Literal["lone-uav", "mbps"] | Annotated[float, Field(gt=0, le=1e9)] = constant(
        "lone-uav",
        "-",
        "-",
        "inferred",
        "unit of rates inside rewards: a lone UAV one voxel from its GBS, or mbps, or a number of Mbps",
    )
    out_of_bounds: Literal["clip", "hover"] = constant(
        "clip", "-", "-", "chosen", "a move out of the airspace is clipped by coordinate, or refused (hover)"
    )
    arrived_uav: Literal["leaves", "stays"] = constant(
        "leaves", "-", "-", "chosen", "a UAV that is done frees its RBs and voxel, or keeps both"
    )
    arrival: Literal["slot-end", "fly-through"] = constant(
        "slot-end", "-", "-", "chosen", "the destination counts at the end of a slot, or also on the way (x, y, z)"
    )
    bias_horizon: Literal["completion", "deadline"] = constant(
        "completion", "T-bar", "slots", "chosen", "horizon of the EMA's bias correction: T_i, or T_max"
    )

    @field_validator("*", mode="before")
    @classmethod
    def _no_switches(cls, value: Any) -> Any:
        if isinstance(value, bool):  # Python would count true as 1
            raise ValueError("no constant is true or false")
        return value

    @model_validator(mode="after")
    def _check(self) -> Self:
        for problem in (self._altitude_problem(), self._gbs_problem(), self._size_problem()):
            if problem:
                raise ValueError(problem)
        return self

    def _altitude_problem(self) -> str | None:
        low, high = self.min_altitude_m, self.max_altitude_m
        if low >= high:
            return f"min_altitude_m = {low:g} must lie below max_altitude_m = {high:g}"
        layers = (high - low) / self.voxel_size_m
        if abs(layers - round(layers)) > 1e-9 or round(layers) < 1:
            span = f"max_altitude_m - min_altitude_m = {high - low:g} m"
            return f"{span} must be a whole number of voxels of voxel_size_m = {self.voxel_size_m:g} m"
        return None

    def _gbs_problem(self) -> str | None:
        if min(self.gbs_grid) < 1:
            return f"gbs_grid = {self.gbs_grid}: columns and rows must be at least 1"
        if self.gbs_positions_m is not None and not self.gbs_positions_m:
            return "gbs_positions_m must hold at least one position (x, y, z) in metres"
        if self.num_gbs > MOST_GBS:
            return f"{self.num_gbs} GBSs: at most {MOST_GBS}"
        counts = self.rbs_per_gbs if isinstance(self.rbs_per_gbs, tuple) else (self.rbs_per_gbs,)
        if not counts or min(counts) < 1 or max(counts) > MOST_RBS:
            return f"rbs_per_gbs = {self.rbs_per_gbs}: every GBS needs 1 to {MOST_RBS} RBs"
        if isinstance(self.rbs_per_gbs, tuple) and len(counts) != self.num_gbs:
            return f"rbs_per_gbs names {len(counts)} GBSs, the scenario has {self.num_gbs}"
        for b, site in enumerate(self.gbs_positions):
            voxel = (site - self.voxel_centre((0, 0, 0))) / self.voxel_size_m
            inside = np.all(voxel > -0.5) and np.all(voxel < np.array(self.grid) - 0.5)
            if inside and np.allclose(voxel, np.round(voxel), atol=1e-6):
                return f"GBS {b} at {tuple(site.tolist())} m lies on a voxel centre, where the link distance would be 0"
        return None

    def _size_problem(self) -> str | None:
        if self.num_voxels > MOST_VOXELS:
            return f"the grid {self.grid} has {self.num_voxels} voxels: at most {MOST_VOXELS}"
        if 2 * self.num_uavs > self.num_voxels:
            return (
                f"num_uavs = {self.num_uavs} needs {2 * self.num_uavs} distinct origins and destinations, "
                f"the airspace has {self.num_voxels} voxels: at most {self.num_voxels // 2} UAVs"
            )
        return None

    @property
    def grid(self) -> tuple[int, int, int]:
        """Airspace in voxels (W, L, H)."""
        layers = round((self.max_altitude_m - self.min_altitude_m) / self.voxel_size_m)
        return self.width_voxels, self.length_voxels, layers

    @property
    def num_voxels(self) -> int:
        """Number of voxels, W * L * H."""
        return math.prod(self.grid)

    @property
    def num_gbs(self) -> int:
        """Number of base stations M."""
        return len(self.gbs_positions_m) if self.gbs_positions_m is not None else math.prod(self.gbs_grid)

    @property
    def gbs_positions(self) -> NDArray[np.float64]:
        """GBS positions g_b in metres, [M, 3]."""
        if self.gbs_positions_m is not None:
            return np.array(self.gbs_positions_m, dtype=np.float64)
        columns, rows = self.gbs_grid
        xs = self._sites(columns, self.width_voxels * self.voxel_size_m)
        ys = self._sites(rows, self.length_voxels * self.voxel_size_m)
        return np.array([(x, y, self.gbs_height_m) for x in xs for y in ys])

    def _sites(self, count: int, extent_m: float) -> list[float]:
        """Coordinates of ``count`` sites along one side of the area."""
        if self.gbs_layout == "corners" and count > 1:
            return [extent_m * k / (count - 1) for k in range(count)]
        return [extent_m * (k + 0.5) / count for k in range(count)]

    @property
    def num_rbs(self) -> NDArray[np.int64]:
        """RBs K_b of each GBS, [M]."""
        return np.broadcast_to(np.array(self.rbs_per_gbs, dtype=np.int64), (self.num_gbs,)).copy()

    @property
    def noise_power_dbm(self) -> float:
        """Noise power sigma^2 over one RB in dBm."""
        return self.noise_density_dbm_hz + 10.0 * math.log10(self.rb_bandwidth_hz)

    @property
    def snr_at_1m(self) -> float:
        """P_tx * beta_0 / sigma^2 of Eq. (2), eq:rate, linear."""
        return float(10.0 ** ((self.tx_power_dbm + self.ref_gain_db - self.noise_power_dbm) / 10.0))

    def voxel_centre(self, voxel: Sequence[int] | NDArray[np.int64]) -> NDArray[np.float64]:
        """Centre of a voxel, where the paper defines every position.

        :param voxel: voxel coordinates, [..., 3]
        :return: position in metres, [..., 3]

        >>> Scenario().voxel_centre((2, 0, 1))
        array([25.,  5., 15.])
        """
        floor = np.array([0.0, 0.0, self.min_altitude_m])
        return floor + (np.asarray(voxel) + 0.5) * self.voxel_size_m

    def changed(self, /, **changes: Any) -> Self:
        """A copy with some constants changed, validated anew.

        :param changes: field names and their new values
        :return: the new scenario
        :raises UserError: if the result would not be a valid scenario
        """
        return validated(type(self), {**self.model_dump(), **changes}, where=f"scenario {self.name!r}")

    def grown(self, num_uavs: int) -> Self:
        """The same densities of UAVs and of GBSs with another number of UAVs: the airspace and its grid of GBSs grow.

        :param num_uavs: N
        :return: the new scenario
        :raises UserError: if the sides would not stay whole, or the GBSs are no regular grid of equals

        >>> Scenario().grown(16).grid, Scenario().grown(16).gbs_grid  # four times the area
        ((20, 20, 3), (4, 4))
        """
        where = f"num_uavs = {num_uavs} at the density of scenario {self.name!r}"
        if self.gbs_positions_m is not None or isinstance(self.rbs_per_gbs, tuple):
            raise UserError(f"{where}: only a regular grid of GBSs with as many RBs each can grow")
        now = (self.width_voxels, self.length_voxels, *self.gbs_grid)
        sides = [math.isqrt(side * side * num_uavs // self.num_uavs) for side in now]
        for side, new in zip(now, sides, strict=True):
            if new < 1 or new * new * self.num_uavs != side * side * num_uavs:
                raise UserError(
                    f"{where}: {self.num_uavs} UAVs have {now[0]} x {now[1]} voxels and {now[2]} x {now[3]} GBSs; all "
                    f"four numbers times the square root of {num_uavs} / {self.num_uavs} must be whole"
                )
        width, length, columns, rows = sides
        return self.changed(num_uavs=num_uavs, width_voxels=width, length_voxels=length, gbs_grid=(columns, rows))

    @property
    def title(self) -> str:
        """The name, and for a changed preset what differs from it: ``paper, num_uavs=8``."""
        preset = PRESETS.get(self.name)
        if preset is None:
            return self.name
        mine, theirs = self.model_dump(), preset.model_dump()
        return ", ".join([self.name, *(f"{key}={value}" for key, value in mine.items() if value != theirs[key])])

    def source(self, key: str) -> Source | Literal["preset", "yours"]:
        """Where the value of a constant comes from.

        :param key: the constant's field
        :return: for a value of the preset ``paper`` what that says of it, ``preset`` for one of another preset of this
            name, and ``yours`` for any other
        """
        field, value = type(self).model_fields[key], getattr(self, key)
        if value == field.default:
            declared: Source = cast("dict[str, Any]", field.json_schema_extra)["source"]
            return declared
        return "preset" if self.name in PRESETS and value == getattr(PRESETS[self.name], key) else "yours"

    def to_yaml(self) -> str:
        """The scenario as YAML that :func:`load_scenario` reads back."""
        return yaml.safe_dump(self.model_dump(mode="json"), sort_keys=False)


PRESETS: dict[str, Scenario] = {
    "paper": Scenario(),
    "as-printed": Scenario(name="as-printed", width_voxels=100, length_voxels=100, max_altitude_m=300.0),
    "tiny": Scenario(name="tiny", num_uavs=2, width_voxels=4, length_voxels=4, max_altitude_m=10.0),
}


FILE_ENDINGS = (".yaml", ".yml")
"""Of a scenario's file."""


def load_scenario(name: str, overrides: Sequence[str] = (), option: str = "--set") -> Scenario:
    """Find a scenario and change some of its constants.

    :param name: a preset (``paper``, ``as-printed``, ``tiny``) or the path of a YAML file
    :param overrides: changes written ``key=value``, the value in YAML, such as ``num_uavs=8``
    :param option: where the changes came from, for the error
    :return: the scenario
    :raises UserError: if there is no such scenario, or it is impossible
    """
    if name in PRESETS:
        values = PRESETS[name].model_dump()
    elif Path(name).suffix in FILE_ENDINGS:
        values = {"name": Path(name).stem, **read_yaml_mapping(Path(name), "scenario")}
    else:
        raise unknown_name("scenario", name, [*PRESETS, "a path ending in .yaml"])
    return validated(Scenario, {**values, **parse_overrides(overrides, option)}, where=f"scenario {name!r}")
