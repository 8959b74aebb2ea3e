"""Every method held against one of them, mission by mission: differences, and how often it is better."""

from __future__ import annotations

from lawn_sb3.report.section import Section
from lawn_sb3.report.sections.table_two import HEADING
from lawn_sb3.report.table import interval_columns, sample_of, table_of
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import UNKNOWN, interquartile_mean, paired_difference, probability_of_improvement

BASES = ("state_critic", "centralized_critic")
"""Policies of the method that others are held against, the first there is: the paper's own critic."""
COMPARED = ("reward", "utility_mbps")


def section(results: Results) -> Section | None:
    """Interquartile means, and differences to CTDE-MAPPO with the probability of being better.

    :param results: what the runs left
    :return: a table with one row for each method whose UAVs meet; none without CTDE-MAPPO
    """
    results = results.without_bound()
    base = _base_method(results)
    if base is None:
        return None
    rows = []
    for key, method in results.methods.items():
        row: dict[str, object] = {"method": method.label, "key": key}
        cells = {"Method": method.label}
        for name in COMPARED:
            quantity = QUANTITIES[name]
            own, others = results.scores(key, name), results.scores(base, name)
            difference, better = paired_difference(own, others), probability_of_improvement(own, others)
            for column, heading, found, decimals in (
                (f"{name}_iqm", f"IQM {quantity.heading}", interquartile_mean(own), quantity.fine_decimals),
                (f"{name}_difference", quantity.difference_heading, difference, quantity.fine_decimals),
                (f"{name}_improvement", f"P(better {quantity.symbol})", better, 2),
            ):
                itself = key == base and not column.endswith("iqm")
                row |= interval_columns({column: UNKNOWN if itself else found})
                cells[heading] = "–" if itself else found.text(decimals)
        rows.append((row, {**cells, "n": sample_of(results, key)}))
    label = results.methods[base].label
    caption = (
        f"IQM: mean of the middle half of all scores of seeds and missions. Δ: difference to {label} on the same "
        f"missions. P: probability that a seed of the method does better than one of {label} on the same mission, "
        "ties counted half. In brackets 95 % bootstrap intervals over seeds, missions held fixed; with five seeds they "
        "hold the true value in about five of six cases. n: seeds × test episodes."
    )
    return Section(HEADING, {"comparison": table_of(rows, caption)})


def _base_method(results: Results) -> str | None:
    """Key of CTDE-MAPPO with the paper's critic, or with another one."""
    for policy in BASES:
        for key, method in results.methods.items():
            if method.algo == "mappo" and method.policy == policy:
                return key
    return None
