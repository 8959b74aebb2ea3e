"""Bins of cell loads."""

import math

MOST_BINS = 7
"""Bins of the co-served UAVs beyond the one for nobody."""


def co_served_bounds(num_uavs: int) -> tuple[float, ...]:
    """Bounds of the bins of co-served UAVs.

    :param num_uavs: UAVs of an episode N
    :return: 0, then equal steps up to N - 1 or beyond: of one UAV, or of more where that made too many bins
    """
    step = max(math.ceil((num_uavs - 1) / MOST_BINS), 1)
    return tuple(float(bound) for bound in range(0, num_uavs - 1 + step, step))
