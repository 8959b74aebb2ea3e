"""A new run of a recipe held against the reference results that are kept with the code."""

import pandas as pd

from lawn_sb3.report.table import Table, row_of, sample_of, table_of
from lawn_sb3.results.pairing import significant
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import welch_difference

COMPARED = ("reward", "utility_mbps", "success_percent")


def against_reference(results: Results, reference: Results) -> Table:
    """How a new run compares with the reference: differences and a verdict for each method that both have."""
    common = [key for key in results.methods if key in reference.methods]
    # So that all intervals together hold their true differences with 95 %, as Bonferroni has it.
    confidence = 1.0 - 0.05 / max(1, len(common) * len(COMPARED))
    rows = []
    for key in common:
        equal = _rows(results, key).equals(_rows(reference, key))
        row = row_of(results, key, equal=equal)
        apart, known = [], True
        for name in COMPARED:
            quantity = QUANTITIES[name]
            own, others = (every.scores(key, name).mean(axis=1) for every in (results, reference))
            found = welch_difference(own, others, confidence=confidence)
            known = known and found.is_known
            row.add(name, quantity.difference_heading, found, quantity.fine_decimals)
            if significant(found):
                apart.append(quantity.symbol)
        verdict = "equal to the last digit" if equal else f"differs in {', '.join(apart)}" if apart else "agrees"
        if not known and not equal:
            verdict = "cannot be told from one seed"
        row.numbers["differs_in"] = ", ".join(apart)
        row.cells |= {"Against the reference": verdict, "n": sample_of(results, key)}
        rows.append(row)
    caption = (
        "This run minus the reference results, on the same missions [Welch's t interval over the seeds of both, "
        "widened so that all of them together hold with 95 %]. Agrees: every interval holds 0. Other processors round "
        "differently, which leads trainings apart, so equal digits can be expected on like machines alone. "
        "n: seeds × test episodes."
    )
    return table_of(rows, caption)


def _rows(results: Results, key: str) -> pd.DataFrame:
    rows = results.episodes[results.episodes["method"] == key]
    return rows.sort_values(["seed", "episode", "uav"]).reset_index(drop=True)
