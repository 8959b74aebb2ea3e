"""Which outcomes are stable: what every UAV could gain by deviating alone, and the welfare of certified equilibria."""

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.experiment.measures import EQUILIBRIUM_MBPS
from lawn_sb3.game.payoff import welfare
from lawn_sb3.results.attainable import attainable
from lawn_sb3.results.results import EQUILIBRIA, Results, score_matrix

Floats = NDArray[np.float64]


def regrets_mbps(results: Results) -> pd.DataFrame:
    """Rows of ``results.regrets`` with a column ``regret_mbps``: 0 where there is nothing to gain but rounding."""
    gain = results.regrets["best_mbps"] - results.regrets["utility_mbps"]
    return results.regrets.assign(regret_mbps=gain.where(gain > EQUILIBRIUM_MBPS, 0.0))


def is_equilibrium(results: Results, method: str) -> NDArray[np.bool_]:
    """Which evaluations of a method are equilibria: nobody collides, and nobody could gain by deviating alone.

    Truth values [S, E]: the seeds that have regrets, and the episodes, in ascending order.
    """
    own = regrets_mbps(results)
    own = own[own["method"] == method]
    flown = results.episodes[results.episodes["seed"].isin(own["seed"])]
    regret = score_matrix(own, method, "regret_mbps", per="uav")
    collisions = score_matrix(flown, method, "collisions", per="uav")
    return np.asarray((regret.max(axis=-1) == 0.0) & (collisions.max(axis=-1) == 0))


class Welfares(NamedTuple):
    """What is known of the welfare of the missions that have a certified equilibrium, in Mbps [E]."""

    bound_mbps: Floats
    best_known_mbps: Floats
    best_equilibrium_mbps: Floats
    """Of those found."""
    worst_equilibrium_mbps: Floats
    """Of those found."""
    guaranteed_mbps: Floats
    """What no equilibrium is below."""


class Certified(NamedTuple):
    """Equilibria that were found and certified."""

    welfares: Welfares
    missions: int
    """Missions of the evaluation, with a certified equilibrium or without."""
    searches: int
    """Joint trajectories that players who look for equilibria have flown."""
    certified: int
    """Those of them that are equilibria."""


def certified_welfares(results: Results) -> Certified | None:
    """The welfare of the equilibria; none without results of the bound, what is guaranteed, or a certified one."""
    limits, guaranteed = attainable(results), results.checks.get("guaranteed")
    keys = [key for key, method in results.methods_in(results.regrets).items() if method.player in EQUILIBRIA]
    if limits is None or not keys or not isinstance(guaranteed, pd.DataFrame):
        return None
    holds = np.concatenate([is_equilibrium(results, key) for key in keys])  # [R, E]
    found = np.concatenate([welfare(score_matrix(results.regrets, key, "utility_mbps", per="uav")) for key in keys])
    known = holds.any(axis=0)
    if not known.any():
        return None
    best, worst = np.where(holds, found, -np.inf).max(axis=0), np.where(holds, found, np.inf).min(axis=0)
    least = guaranteed.groupby("episode")["guaranteed_mbps"].sum().to_numpy()
    parts = (limits.bound_mbps, limits.best_known_mbps, best, worst, least)
    return Certified(Welfares(*(part[known] for part in parts)), known.size, holds.size, int(holds.sum()))
