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


def most_shown(num_uavs: int, most_seen: float) -> int:
    """The most UAVs in a cell that a figure has room for: all N, or in swarms as many as ever were in one.

    :param num_uavs: UAVs of an episode N
    :param most_seen: the highest cell load that there was
    """
    return num_uavs if num_uavs <= MOST_BINS + 1 else max(min(math.ceil(most_seen), num_uavs), 2)
