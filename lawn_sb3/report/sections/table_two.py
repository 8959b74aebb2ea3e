"""Table II: every method's figures over seeds, the paper's beside them, and its share of the attainable welfare."""

from __future__ import annotations

import pandas as pd

from lawn_sb3.experiment.knowledge import bits_of
from lawn_sb3.paper.printed_values import TABLE_II
from lawn_sb3.report.table import Table, interval_columns
from lawn_sb3.results.attainable import Attainable, attainable, explanation, share
from lawn_sb3.results.results import BOUND, Results
from lawn_sb3.results.statistics import mean_interval

COLUMNS = {
    "reward": ("J̄", 2),
    "rate_mbps": ("R̂ (Mbps)", 2),
    "makespan_slots": ("T̄ (slots)", 1),
    "success_percent": ("Success (%)", 1),
    "utility_mbps": ("U (Mbps)", 1),
}
"""Figure: its heading and its decimals."""


def size(results: Results, method: str) -> str:
    """The sample behind a method's figures.

    :param results: what the runs left
    :param method: its key in the recipe
    :return: ``5 × 200``: seeds by episodes
    """
    seeds = results.episodes.loc[results.episodes["method"] == method, "seed"].nunique()
    return f"{seeds} × {results.recipe.evaluation.episodes}"


def table_two(results: Results) -> Table:
    """Mean over seeds of each figure, its 95 % bootstrap interval over seeds, and the paper's value.

    :param results: what the runs left
    :return: one row a method; numbers with the columns ``method, key, seeds, episodes`` and for each figure
        ``NAME, NAME_low, NAME_high, NAME_paper``; with results of the bound, ``share_low_percent`` and
        ``share_high_percent`` with intervals too
    """
    by_seed, limits = results.by_seed(), attainable(results)
    numbers, shown = [], []
    for key, method in results.methods.items():
        own = by_seed[by_seed["method"] == key]
        printed = TABLE_II[method.paper_row]._asdict() if method.paper_row else {}
        row: dict[str, object] = {
            "method": method.label,
            "key": key,
            "seeds": len(own),
            "episodes": results.recipe.evaluation.episodes,
        }
        cells = {"Method": method.label}
        for name, (heading, decimals) in COLUMNS.items():
            found = mean_interval(own[name])
            row |= dict(zip((name, f"{name}_low", f"{name}_high"), found, strict=True))
            row[f"{name}_paper"] = printed.get(name, float("nan"))
            paper = f" ({printed[name]:.{decimals}f})" if name in printed else ""
            cells[heading] = found.text(decimals) + paper
        bits = bits_of(method, results.recipe.game())
        row["told_bits"], cells["Told (bits)"] = bits, "–" if bits is None else str(bits)
        if limits is not None:
            figures, cells["Share (%)"] = _share(results, key, limits)
            row |= figures
        numbers.append(row)
        shown.append({**cells, "n": size(results, key)})
    return Table(pd.DataFrame(numbers), pd.DataFrame(shown), caption(results, limits))


def _share(results: Results, key: str, limits: Attainable) -> tuple[dict[str, float], str]:
    """The bracket of a method's share of the attainable welfare: numbers, and what is shown."""
    if results.methods[key].player == BOUND:
        return {}, "–"
    low, high = share(results, key, limits)
    figures = interval_columns({"share_low_percent": low, "share_high_percent": high})
    return figures, f"{low.value:.1f}–{high.value:.1f}"


def caption(results: Results, limits: Attainable | None = None) -> str:
    """What Table II shows.

    :param results: what the runs left
    :param limits: what the largest welfare lies between, if shares are shown
    :return: one paragraph
    """
    actions = "greedy" if results.recipe.evaluation.deterministic else "sampled"
    shares = f"{explanation(limits)} " if limits is not None else ""
    return (
        f"Mean over seeds [95 % bootstrap interval over seeds], {actions} actions, the same test missions for every "
        "method and seed; in parentheses the paper's value. T̄ is the makespan: slots until the last UAV is done. "
        "U is the mean utility, which the paper does not print. Told: bits that each UAV broadcasts in every slot so "
        f"that the others can act as they do. {shares}n: seeds × test episodes."
    )
