"""Table II: every method's figures over seeds, the paper's beside them, and its share of the attainable welfare."""

from __future__ import annotations

from lawn_sb3.experiment.knowledge import bits_of
from lawn_sb3.paper.printed_values import TABLE_II
from lawn_sb3.report.section import Section
from lawn_sb3.report.table import interval_columns, sample_of, table_of
from lawn_sb3.results.attainable import Attainable, attainable, explanation, share
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import BOUND, Results
from lawn_sb3.results.statistics import mean_interval

HEADING = "Table II: performance"
COLUMNS = ("reward", "rate_mbps", "makespan_slots", "success_percent", "utility_mbps")
"""The paper's four quantities, and the utility that they stand for."""


def section(results: Results) -> Section:
    """Mean over seeds of each quantity, its 95 % bootstrap interval over seeds, and the paper's value.

    :param results: what the runs left
    :return: a table with one row for each method; numbers with the columns ``method, key, seeds, episodes`` and for
        each quantity ``NAME, NAME_low, NAME_high, NAME_paper``; with results of the bound, ``share_low_percent`` and
        ``share_high_percent`` with intervals too
    """
    by_seed, limits = results.by_seed(), attainable(results)
    rows = []
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
        for name in COLUMNS:
            quantity, found = QUANTITIES[name], mean_interval(own[name])
            row |= interval_columns({name: found}) | {f"{name}_paper": printed.get(name, float("nan"))}
            paper = f" ({printed[name]:.{quantity.decimals}f})" if name in printed else ""
            cells[quantity.heading] = found.text(quantity.decimals) + paper
        bits = bits_of(method, results.recipe.game())
        row["told_bits"], cells["Told (bits)"] = bits, "–" if bits is None else str(bits)
        if limits is not None:
            figures, cells["Share (%)"] = _share(results, key, limits)
            row |= figures
        rows.append((row, {**cells, "n": sample_of(results, key)}))
    return Section(HEADING, {"table2": table_of(rows, _caption(results, limits))})


def _share(results: Results, key: str, limits: Attainable) -> tuple[dict[str, float], str]:
    """The bracket of a method's share of the attainable welfare: numbers, and what is shown."""
    if results.methods[key].player == BOUND:
        return {}, "–"
    low, high = share(results, key, limits)
    figures = interval_columns({"share_low_percent": low, "share_high_percent": high})
    return figures, f"{low.value:.1f}–{high.value:.1f}"


def _caption(results: Results, limits: Attainable | None) -> str:
    actions = "greedy" if results.recipe.evaluation.deterministic else "sampled"
    shares = f"{explanation(limits)} " if limits is not None else ""
    return (
        f"Mean over seeds [95 % bootstrap interval over seeds], {actions} actions, the same test missions for every "
        "method and seed; in parentheses the paper's value. T̄ is the makespan: slots until the last UAV is done. "
        "U is the mean utility, which the paper does not print. Told: bits that each UAV broadcasts in every slot so "
        f"that the others can act as they do. {shares}n: seeds × test episodes."
    )
