"""A new run of a recipe held against the reference results that are kept with the code."""

from __future__ import annotations

import pandas as pd

from lawn_sb3.report.results import Results
from lawn_sb3.report.statistics import paired_difference
from lawn_sb3.report.table_two import size
from lawn_sb3.report.tables import Table

QUANTITIES = {"reward": ("Δ J̄", 3, 1.0), "utility_mbps": ("Δ U (Mbps)", 2, 1.0), "arrived": ("Δ Success", 2, 100.0)}
"""Column of the raw rows: heading, decimals, and the factor that takes it to the figure."""


def against_reference(results: Results, reference: Results) -> Table:
    """How a new run compares with the reference.

    :param results: the new run
    :param reference: the reference
    :return: one row for each method that both have, with the differences of the new run and a verdict
    """
    numbers, shown = [], []
    for key, method in results.methods.items():
        if key not in reference.methods:
            continue
        equal = _rows(results, key).equals(_rows(reference, key))
        row: dict[str, object] = {"method": method.label, "key": key, "equal": equal}
        cells = {"Method": method.label}
        apart = []
        for name, (heading, decimals, factor) in QUANTITIES.items():
            found = paired_difference(factor * results.scores(key, name), factor * reference.scores(key, name))
            row |= dict(zip((name, f"{name}_low", f"{name}_high"), found, strict=True))
            cells[heading] = found.text(decimals)
            if found.low > 0.0 or found.high < 0.0:
                apart.append(heading.split()[1])
        row["differs_in"] = ", ".join(apart)
        verdict = "equal to the last digit" if equal else f"differs in {', '.join(apart)}" if apart else "agrees"
        numbers.append(row)
        shown.append({**cells, "Against the reference": verdict, "n": size(results, key)})
    caption = (
        "This run minus the reference results, on the same missions [95 % bootstrap interval over the seeds of both]. "
        "Agrees: every interval holds 0. Other processors round differently, which leads trainings apart, so equal "
        "digits can be expected on like machines alone. n: seeds × test episodes."
    )
    return Table(pd.DataFrame(numbers), pd.DataFrame(shown), caption)


def _rows(results: Results, key: str) -> pd.DataFrame:
    rows = results.episodes[results.episodes["method"] == key]
    return rows.sort_values(["seed", "episode", "uav"]).reset_index(drop=True)
