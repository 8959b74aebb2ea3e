"""The figures that the paper prints, to be set beside ours."""

from __future__ import annotations

from types import MappingProxyType
from typing import NamedTuple


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
