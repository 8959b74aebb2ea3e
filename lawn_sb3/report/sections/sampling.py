"""What greedy play is worth: the test missions flown greedily, and once more with sampled actions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.report.section import Section
from lawn_sb3.report.table import interval_columns, sample_text, table_of
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results, score_matrix
from lawn_sb3.results.statistics import mean_interval

DECIMALS = {"success_percent": 1, "reward": 3, "makespan_slots": 1}
"""The quantities compared; both plays have nearly the same reward."""
CAPTION = (
    "Greedy actions / sampled ones (IQL and QMIX: epsilon-greedy with the last epsilon of their training) on the same "
    "test missions, means over seeds. Δ: greedy minus sampled, seed by seed, with a 95 % bootstrap interval over "
    "seeds. T̄ is the makespan. n: seeds × test episodes."
)


def section(results: Results) -> Section:
    """Compare greedy with sampled play, seed by seed on the same missions.

    :param results: what the runs left
    :return: a table with one row for each method that has both: figures of both kinds of play, and their difference
    """
    rows, episodes = [], results.recipe.evaluation.episodes
    for key, method in results.methods_in(results.sampled).items():
        row: dict[str, object] = {"method": method.label, "key": key}
        cells = {"Method": method.label}
        for name, decimals in DECIMALS.items():
            greedy, sampled = _both_plays(results, key, name)
            plays = {"greedy": greedy, "sampled": sampled, "difference": greedy - sampled}
            figures = {f"{name}_{play}": mean_interval(by_seed) for play, by_seed in plays.items()}
            row |= interval_columns(figures)
            heading = QUANTITIES[name].heading
            cells[heading] = f"{greedy.mean():.{decimals}f} / {sampled.mean():.{decimals}f}"
            cells[f"Δ {heading}"] = figures[f"{name}_difference"].text(decimals)
        row |= {"seeds": len(greedy), "episodes": episodes}
        rows.append((row, {**cells, "n": sample_text(len(greedy), episodes)}))
    return Section("Greedy against sampled play", {"sampling": table_of(rows, CAPTION)})


def _both_plays(results: Results, method: str, name: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Means over the test missions of the seeds that were flown both ways: greedy and sampled play, each [S]."""
    sampled = results.sampled[results.sampled["method"] == method]
    greedy = results.episodes[results.episodes["seed"].isin(sampled["seed"])]
    greedy_mean, sampled_mean = (score_matrix(rows, method, name).mean(axis=-1) for rows in (greedy, sampled))
    return greedy_mean, sampled_mean
