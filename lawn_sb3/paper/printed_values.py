"""The figures that the paper prints, to be set beside ours."""

from types import MappingProxyType
from typing import NamedTuple


class PaperConstant(NamedTuple):
    """One value of the paper's Table I."""

    printed: str
    """As it is printed, with its unit."""
    value: float
    """In the unit of the scenario's field; of counts and grid sizes, the number itself."""


TABLE_I = MappingProxyType(
    {
        "num_uavs": PaperConstant("4", 4),
        "gbs_grid": PaperConstant("4", 4),
        "width_voxels": PaperConstant("100", 100),
        "length_voxels": PaperConstant("100", 100),
        "max_altitude_m": PaperConstant("H = 30", 30),
        "voxel_size_m": PaperConstant("10 m", 10.0),
        "max_voxel_steps": PaperConstant("3", 3),
        "max_slots": PaperConstant("100 slots", 100),
        "rbs_per_gbs": PaperConstant("10", 10),
        "rb_bandwidth_hz": PaperConstant("180 kHz", 180e3),
        "path_loss_exponent": PaperConstant("2.0", 2.0),
    }
)
"""tab:params, by the field of the scenario; M stands at the GBS grid, H, in voxels, at the ceiling."""


class PaperRow(NamedTuple):
    """One row of the paper's Table II."""

    reward: float
    rate_mbps: float
    makespan_slots: float
    success_percent: float


TABLE_II = MappingProxyType(
    {
        "Random": PaperRow(-3.57, 36.20, 100.0, 22.4),
        "IQL": PaperRow(-1.96, 44.46, 99.7, 25.6),
        "QMIX": PaperRow(3.01, 38.80, 34.6, 96.1),
        "CTDE-MAPPO": PaperRow(3.19, 35.68, 8.7, 100.0),
    }
)
"""tab:perf, by the name of its rows."""

ROUNDING = PaperRow(0.005, 0.005, 0.05, 0.05)
"""Half a unit of the last digit that tab:perf prints: how far a printed figure may lie from the computed one."""

LATEST_SLOTS = TABLE_II["CTDE-MAPPO"].makespan_slots + ROUNDING.makespan_slots
"""The largest mean makespan that is printed as that of CTDE-MAPPO."""

TEST_EPISODES = 200
"""Episodes behind a row of tab:perf. "Averaged over five seeds" may mean 1,000; the fewer, the less is claimed."""
