"""A new run of a recipe held against the reference results that are kept with the code."""

from __future__ import annotations

import numpy as np
import pandas as pd

from lawn_sb3.report.sections.table_two import size
from lawn_sb3.report.table import Table
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import welch_difference

QUANTITIES = {"reward": ("Δ J̄", 3, 1.0), "utility_mbps": ("Δ U (Mbps)", 2, 1.0), "arrived": ("Δ Success", 2, 100.0)}
"""Column of the raw rows: heading, decimals, and the factor that takes it to the figure."""


def against_reference(results: Results, reference: Results) -> Table:
    """How a new run compares with the reference.

    :param results: the new run
    :param reference: the reference
    :return: one row for each method that both have, with the differences of the new run and a verdict
    """
    numbers, shown = [], []
    common = [key for key in results.methods if key in reference.methods]
    # So that all intervals together hold their true differences with 95 %, as Bonferroni has it.
    confidence = 1.0 - 0.05 / max(1, len(common) * len(QUANTITIES))
    for key, method in results.methods.items():
        if key not in common:
            continue
        equal = _rows(results, key).equals(_rows(reference, key))
        row: dict[str, object] = {"method": method.label, "key": key, "equal": equal}
        cells = {"Method": method.label}
        apart, unknown = [], False
        for name, (heading, decimals, factor) in QUANTITIES.items():
            own, others = (factor * every.scores(key, name).mean(axis=1) for every in (results, reference))
            found = welch_difference(own, others, confidence=confidence)
            unknown = unknown or bool(np.isnan(found.low))
            row |= dict(zip((name, f"{name}_low", f"{name}_high"), found, strict=True))
            cells[heading] = found.text(decimals)
            if found.low > 0.0 or found.high < 0.0:
                apart.append(heading.split()[1])
        row["differs_in"] = ", ".join(apart)
        verdict = "equal to the last digit" if equal else f"differs in {', '.join(apart)}" if apart else "agrees"
        if unknown and not equal:
            verdict = "cannot be told from one seed"
        numbers.append(row)
        shown.append({**cells, "Against the reference": verdict, "n": size(results, key)})
    caption = (
        "This run minus the reference results, on the same missions [Welch's t interval over the seeds of both, "
        "widened so that all of them together hold with 95 %]. Agrees: every interval holds 0. Other processors round "
        "differently, which leads trainings apart, so equal digits can be expected on like machines alone. "
        "n: seeds × test episodes."
    )
    return Table(pd.DataFrame(numbers), pd.DataFrame(shown), caption)


def _rows(results: Results, key: str) -> pd.DataFrame:
    rows = results.episodes[results.episodes["method"] == key]
    return rows.sort_values(["seed", "episode", "uav"]).reset_index(drop=True)
