"""How evenly utilities fall on the UAVs of an episode."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.game.fairness import gini, jain_index, nash_welfare
from lawn_sb3.report.section import Section
from lawn_sb3.report.table import Table, interval_columns, interval_texts, sample_of
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import mean_interval

HEADING = "Who got the low utilities"
COLUMNS = {
    "jain": ("Jain index", 3),
    "gini": ("Gini", 3),
    "nash_welfare_mbps": ("Nash welfare (Mbps)", 1),
    "worst_mbps": ("Worst UAV's U (Mbps)", 1),
    "utility_mbps": ("Mean U (Mbps)", 1),
    "nobody_percent": ("Nobody arrives (%)", 1),
}
"""Column: its heading and decimals."""


def section(results: Results) -> Section | None:
    """Fairness of all methods whose UAVs meet."""
    joint = results.without_bound()
    return Section(HEADING, {"fairness": fairness(joint)}) if joint.methods else None


def fairness(results: Results) -> Table:
    """Compare how the methods spread utility over the UAVs of an episode.

    :param results: what the runs left
    :return: one row a method: means over episodes and seeds with 95 % intervals over seeds
    """
    rows = []
    for key, method in results.methods.items():
        figures = {name: mean_interval(by_seed) for name, by_seed in _by_seed(results, key).items()}
        rows.append({"method": method.label, "key": key, "seeds": len(results.seeds(key)), **interval_columns(figures)})
    numbers = pd.DataFrame(rows)
    shown = pd.DataFrame({"Method": numbers["method"]})
    for name, (heading, decimals) in COLUMNS.items():
        shown[heading] = interval_texts(numbers, name, decimals)
    shown["n"] = [sample_of(results, key) for key in results.methods]
    return Table(numbers, shown, _caption(results))


def _by_seed(results: Results, method: str) -> dict[str, NDArray[np.float64]]:
    """Means over the episodes of each seed [S]."""
    utility = results.scores(method, "utility_mbps", per="uav")  # [S, E, N]
    return {
        "jain": jain_index(utility).mean(axis=-1),
        "gini": gini(utility).mean(axis=-1),
        "nash_welfare_mbps": nash_welfare(utility).mean(axis=-1),
        "worst_mbps": utility.min(axis=-1).mean(axis=-1),
        "utility_mbps": utility.mean(axis=(-2, -1)),
        "nobody_percent": 100.0 * (utility.max(axis=-1) == 0.0).mean(axis=-1),
    }


def _caption(results: Results) -> str:
    return (
        f"How evenly the utilities U of an episode fall on its {results.recipe.game().num_uavs} UAVs. Jain index: 1 if "
        "all have the same, 1/N if one has everything; Gini: 0 and (N - 1)/N. An episode in which nobody arrives, and "
        "everybody has 0, counts as even, so both have to be read beside the share of such episodes. Nash welfare: the "
        "geometric mean of an episode's utilities, which is high if all have much and 0 if one has nothing. Worst UAV: "
        "lowest utility of an episode. Means with 95 % bootstrap intervals over seeds; n: seeds × test episodes."
    )
