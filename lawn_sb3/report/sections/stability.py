"""How stable an outcome is: what each UAV could gain by deviating alone, and how often nobody could."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lawn_sb3.experiment.measures import EQUILIBRIUM_MBPS
from lawn_sb3.report.cdf import distributions, panels_text
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.table import Table, interval_columns, interval_texts, sample_text
from lawn_sb3.results.results import Results, score_matrix
from lawn_sb3.results.statistics import mean_interval

HEADING = "How far from the optimum"
GAIN_MBPS = 1.0
"""A gain worth deviating for."""
SHOWN = 0.995
COLUMNS = {
    "regret_mbps": ("Mean regret (Mbps)", 2),
    "nash_gap_mbps": ("Nash gap (Mbps)", 2),
    "gaining_percent": (f"UAVs with > {GAIN_MBPS:g} Mbps to gain (%)", 1),
    "equilibria_percent": ("Equilibria (%)", 1),
}
"""Column: its heading and its decimals."""
LARGEST = "Largest regret (Mbps)"
CAPTION = (
    "How stable the outcome is. Regret of a UAV: the utility of its best response less the utility it had, never "
    "below 0. The best response is exact, over all trajectories and all flight times up to T_max, against the "
    "trajectories that the other UAVs of the episode flew: these stay as they were, although players who see the "
    "cell loads might have reacted. It avoids collisions, so a UAV that collided may have had more; that counts as "
    "regret 0. Nash gap: largest regret of an episode's UAVs, mean over episodes; largest regret: of all UAVs, "
    "episodes and seeds. Equilibria: episodes without collisions in which no UAV could gain more than "
    f"{EQUILIBRIUM_MBPS:g} Mbps. Means with 95 % bootstrap intervals over seeds; n: seeds × test episodes."
)


def section(results: Results) -> Section | None:
    """Regrets, where they were worked out."""
    if not len(results.regrets):
        return None
    figure = Picture(_figure(results), _cdf_caption(results))
    return Section(HEADING, {"regret": _table(results), "regret_cdf": figure})


def regrets_mbps(results: Results) -> pd.DataFrame:
    """What every UAV could have gained.

    :param results: what the runs left
    :return: rows of ``results.regrets`` with the column ``regret_mbps``: 0 where there is nothing to gain but rounding
    """
    gain = results.regrets["best_mbps"] - results.regrets["utility_mbps"]
    return results.regrets.assign(regret_mbps=gain.where(gain > EQUILIBRIUM_MBPS, 0.0))


def is_equilibrium(results: Results, method: str) -> NDArray[np.bool_]:
    """Which evaluations of a method are equilibria: nobody collides, and nobody could gain by deviating alone.

    :param results: what the runs left, with regrets of the method
    :param method: its key in the recipe
    :return: truth values [S, E]: the seeds that have regrets, and the episodes, in ascending order
    """
    own = regrets_mbps(results)
    own = own[own["method"] == method]
    flown = results.episodes[results.episodes["seed"].isin(own["seed"])]
    regret = score_matrix(own, method, "regret_mbps", per="uav")
    collisions = score_matrix(flown, method, "collisions", per="uav")
    return np.asarray((regret.max(axis=-1) == 0.0) & (collisions.max(axis=-1) == 0))


def _table(results: Results) -> Table:
    """Means over episodes and seeds with 95 % intervals over seeds, and the largest regret of each method."""
    found, rows = regrets_mbps(results), []
    for key, method in results.methods_in(found).items():
        own = score_matrix(found, key, "regret_mbps", per="uav")  # [S, E, N]
        by_seed = {
            "regret_mbps": own.mean(axis=(-2, -1)),
            "nash_gap_mbps": own.max(axis=-1).mean(axis=-1),
            "gaining_percent": 100.0 * (own > GAIN_MBPS).mean(axis=(-2, -1)),
            "equilibria_percent": 100.0 * is_equilibrium(results, key).mean(axis=-1),
        }
        figures = interval_columns({name: mean_interval(values) for name, values in by_seed.items()})
        rows.append({"method": method.label, "key": key, "seeds": len(own), **figures, "largest_mbps": own.max()})
    numbers = pd.DataFrame(rows)
    shown = pd.DataFrame({"Method": numbers["method"]})
    for name, (heading, decimals) in COLUMNS.items():
        shown[heading] = interval_texts(numbers, name, decimals)
        if name == "nash_gap_mbps":
            shown[LARGEST] = [f"{value:.1f}" for value in numbers["largest_mbps"]]
    shown["n"] = [sample_text(seeds, results.recipe.evaluation.episodes) for seeds in numbers["seeds"]]
    return Table(numbers, shown, CAPTION)


def _figure(results: Results) -> Figure:
    xlabel, ylabel = "regret of a UAV (Mbps): what it could gain by deviating alone", "share of the UAVs"
    rows = regrets_mbps(results)
    return distributions(results, rows, "regret_mbps", xlabel, ylabel, shown_mbps(results, rows))


def shown_mbps(results: Results, rows: pd.DataFrame) -> float:
    """Where the axis of the figure ends, so that the few UAVs with the most regret do not squeeze all others.

    :param results: what the runs left
    :param rows: what :func:`regrets_mbps` returned
    :return: regret in Mbps that 99.5 % of the UAVs of each method stay below; the random player counts if it is alone
    """
    found = results.methods_in(rows)
    chosen = [key for key, method in found.items() if method.player != "random"] or list(found)
    own = rows[rows["method"].isin(chosen)]
    return max(float(own.groupby("method")["regret_mbps"].quantile(SHOWN).max()), GAIN_MBPS)


def _cdf_caption(results: Results) -> str:
    return (
        "Share of the UAVs whose regret is at most the value on the axis, all test episodes and seeds; bands: range "
        "over seeds. Where a curve begins at the left is the share of UAVs that have nothing to gain: in equilibria "
        "all of them, along the upper edge. "
        f"{panels_text(results, results.regrets)}The axis ends where {100 * SHOWN:g} % of the UAVs of each method lie "
        "below, the random player aside."
    )
