"""How far a figure of ours lies from one that the paper prints, in standard errors, and what that says.

The unit is the episode: the UAVs of one share cells and cannot be counted one by one. The paper prints no spread, so
its figures are given that of our episodes over its 200 (:data:`TEST_EPISODES`), at least the preset's spread: under
some candidates success or makespan do not vary at all, and a zero would make any difference infinite. Our own sampling
error and half a unit of the last printed digit add in quadrature. The latter counts for T-bar alone, which lies so near
the cap of T_max that its error is only twice its rounding; in the other figures it is some 3 % of the error.
"""

import math

import pandas as pd

from lawn_sb3.paper.printed_values import TEST_EPISODES

RULED_OUT_Z = 3.0
"""A candidate is ruled out if one of its figures lies more standard errors from the paper's."""
DISFAVOURED_Z = 2.0
"""It is disfavoured above this many; below, it agrees."""


def standard_error(own: pd.Series, rounding: float = 0.0, least_spread: float = 0.0) -> float:
    """Standard error of the difference between a mean of ours and a figure that the paper prints.

    :param own: our values, one per episode; NaN where an episode has none
    :param rounding: half a unit of the figure's last printed digit
    :param least_spread: the least standard deviation over episodes that is assumed
    :return: the error, in the unit of the figure
    """
    counted = int(own.count())
    variance = max(float(own.std()) if counted > 1 else 0.0, least_spread) ** 2
    theirs = TEST_EPISODES * counted / len(own)
    return math.sqrt(variance / theirs + variance / counted + rounding**2)


def verdict(z: float) -> str:
    """What the paper says of a candidate by the largest distance of its figures, in standard errors."""
    if abs(z) > RULED_OUT_Z:
        return "ruled out"
    return "disfavoured" if abs(z) > DISFAVOURED_Z else "agrees"
