"""How much welfare there is: each mission's largest is not known, but lies between the best known and a bound."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.payoff import welfare
from lawn_sb3.results.results import BOUND, Results
from lawn_sb3.results.statistics import Interval, mean_interval

Floats = NDArray[np.float64]


class Attainable(NamedTuple):
    """What the largest welfare of each test episode lies between."""

    best_known_mbps: Floats  # [E] the highest of any method and seed
    bound_mbps: Floats  # [E] that of all UAVs if each were alone in the network


class Share(NamedTuple):
    """The share of the attainable welfare that a method collects, as a bracket."""

    low_percent: Interval
    """Of the bound: at least so much."""
    high_percent: Interval
    """Of the best known: at most so much."""


def welfares_mbps(results: Results, method: str) -> Floats:
    """Welfare W (Eq. (10), eq:welfare) of every evaluation of a method in Mbps [S, E], in ascending order."""
    return np.asarray(welfare(results.scores(method, "utility_mbps", per="uav")))


def attainable(results: Results) -> Attainable | None:
    """The best known and the bound; none without results of the bound and of another method that has welfare."""
    bounds = [key for key, method in results.methods.items() if method.player == BOUND]
    others = [key for key in results.methods if key not in bounds]
    if not bounds or not others:
        return None
    best = np.max([welfares_mbps(results, key).max(axis=0) for key in others], axis=0)
    if not best.any():
        return None  # nobody has arrived: no share of nothing
    return Attainable(best, welfares_mbps(results, bounds[0]).min(axis=0))  # each seed's is a bound


def share(results: Results, method: str, limits: Attainable) -> Share:
    """The share of the attainable welfare that a method collects: mean over missions by mean over missions."""
    by_seed = welfares_mbps(results, method).mean(axis=-1)  # [S]
    low, high = (mean_interval(100.0 * by_seed / mbps.mean()) for mbps in (limits.bound_mbps, limits.best_known_mbps))
    return Share(low, high)


def explanation(limits: Attainable) -> str:
    """What the shares are shares of, for the caption."""
    best, bound = (float(mbps.mean()) for mbps in limits)
    return (
        "Share: how much of the largest possible welfare (sum of the UAVs' utilities) a method collects, as a bracket, "
        f"since nobody knows the largest exactly: on average over the missions it lies between {best:.1f} Mbps, the "
        f"best that any method and seed here has flown, and {bound:.1f} Mbps, what the UAVs would have if each were "
        "alone in the network. The first number is the share of the latter, the second of the former."
    )
