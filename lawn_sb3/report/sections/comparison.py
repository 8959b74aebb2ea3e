"""Every method held against one of them, mission by mission: differences, and how often it is better."""

from __future__ import annotations

import numpy as np
import pandas as pd

from lawn_sb3.report.sections.table_two import size
from lawn_sb3.report.table import Table
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import interquartile_mean, paired_difference, probability_of_improvement

BASES = ("state_critic", "centralized_critic")
"""Policies of the method that others are held against, the first there is: the paper's own critic."""

QUANTITIES = {"reward": ("J̄", 3), "utility_mbps": ("U (Mbps)", 2)}
"""Column of the raw rows: its heading and decimals."""


def base_method(results: Results) -> str | None:
    """The method that the others are held against.

    :param results: what the runs left
    :return: its key: CTDE-MAPPO with the paper's critic, or with another one, or none
    """
    for policy in BASES:
        for key, method in results.methods.items():
            if method.algo == "mappo" and method.policy == policy:
                return key
    return None


def comparison(results: Results, base: str) -> Table:
    """Interquartile means, and differences to one method with the probability of being better.

    :param results: what the runs left
    :param base: key of the method that the others are held against
    :return: one row a method
    """
    numbers, shown = [], []
    for key, method in results.methods.items():
        row: dict[str, object] = {"method": method.label, "key": key}
        cells = {"Method": method.label}
        for name, (heading, decimals) in QUANTITIES.items():
            own, others = results.scores(key, name), results.scores(base, name)
            figures = {
                f"{name}_iqm": (f"IQM {heading}", interquartile_mean(own), decimals),
                f"{name}_difference": (f"Δ {heading}", paired_difference(own, others), decimals),
                f"{name}_improvement": (f"P(better {heading.split()[0]})", probability_of_improvement(own, others), 2),
            }
            for column, (title, found, digits) in figures.items():
                itself = key == base and not column.endswith("iqm")
                row |= dict(zip((column, f"{column}_low", f"{column}_high"), found, strict=True))
                cells[title] = "–" if itself else found.text(digits)
                if itself:
                    row |= dict.fromkeys((column, f"{column}_low", f"{column}_high"), np.nan)
        numbers.append(row)
        shown.append({**cells, "n": size(results, key)})
    label = results.methods[base].label
    caption = (
        f"IQM: mean of the middle half of all scores of seeds and missions. Δ: difference to {label} on the same "
        f"missions. P: probability that a seed of the method does better than one of {label} on the same mission, "
        "ties counted half. In brackets 95 % bootstrap intervals over seeds, missions held fixed; with five seeds they "
        "hold the true value in about five of six cases. n: seeds × test episodes."
    )
    return Table(pd.DataFrame(numbers), pd.DataFrame(shown), caption)
