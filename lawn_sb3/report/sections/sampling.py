"""What greedy play is worth: the test missions flown greedily, and once more with sampled actions."""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.report.table import Table, interval_columns
from lawn_sb3.results.results import Results, score_matrix
from lawn_sb3.results.statistics import mean_interval

COLUMNS = {
    "success_percent": ("arrived", "Success (%)", 100.0, 1),
    "reward": ("reward", "J̄", 1.0, 3),
    "makespan_slots": ("makespan_slots", "T̄ (slots)", 1.0, 1),
}
"""Figure: the column of the raw rows, its heading, its factor and decimals."""


def sampling(results: Results) -> Table:
    """Compare greedy with sampled play, seed by seed on the same missions.

    :param results: what the runs left
    :return: one row for each method that has both; figures of both kinds of play, and their difference
    """
    numbers, shown = [], []
    for key, method in results.methods_in(results.sampled).items():
        row: dict[str, object] = {"method": method.label, "key": key}
        cells = {"Method": method.label}
        for name, (column, heading, factor, decimals) in COLUMNS.items():
            greedy, sampled = (factor * values for values in both_plays(results, key, column))
            plays = {"greedy": greedy, "sampled": sampled, "difference": greedy - sampled}
            figures = {f"{name}_{play}": mean_interval(by_seed) for play, by_seed in plays.items()}
            row |= interval_columns(figures)
            cells[heading] = f"{greedy.mean():.{decimals}f} / {sampled.mean():.{decimals}f}"
            cells[f"Δ {heading}"] = figures[f"{name}_difference"].text(decimals)
        row |= {"seeds": len(greedy), "episodes": results.recipe.evaluation.episodes}
        numbers.append(row)
        shown.append({**cells, "n": f"{len(greedy)} × {results.recipe.evaluation.episodes}"})
    return Table(pd.DataFrame(numbers), pd.DataFrame(shown), caption(results))


def both_plays(results: Results, method: str, name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Means over the test missions, of the seeds that were flown both ways.

    :param results: what the runs left
    :param method: its key in the recipe
    :param name: a column of the raw rows
    :return: greedy and sampled play, each [S]
    """
    sampled = results.sampled[results.sampled["method"] == method]
    greedy = results.episodes[results.episodes["seed"].isin(sampled["seed"])]
    greedy_mean, sampled_mean = (score_matrix(rows, method, name).mean(axis=-1) for rows in (greedy, sampled))
    return greedy_mean, sampled_mean


def caption(results: Results) -> str:
    """What the table of greedy and sampled play shows.

    :param results: what the runs left
    :return: one paragraph
    """
    return (
        "Greedy actions / sampled ones (IQL and QMIX: epsilon-greedy with the last epsilon of their training) on the "
        "same test missions, means over seeds. Δ: greedy minus sampled, seed by seed, with a 95 % bootstrap interval "
        "over seeds. T̄ is the makespan. n: seeds × test episodes."
    )
