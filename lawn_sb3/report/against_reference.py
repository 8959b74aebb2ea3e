"""A new run of a recipe held against the reference results that are kept with the code."""

import pandas as pd

from lawn_sb3.report.table import Table, row_of, sample_of, table_of
from lawn_sb3.results.pairing import Marks
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import Interval, welch_difference, welch_p

COMPARED = ("reward", "utility_mbps", "success_percent")


def against_reference(results: Results, reference: Results) -> Table:
    """How a new run compares with the reference: differences and a verdict for each method that both have.

    A method whose rows are equal is not tested; all differences of the others are one family for Holm's correction.
    """
    common = [key for key in results.methods if key in reference.methods]
    equal = {key for key in common if _rows(results, key).equals(_rows(reference, key))}
    found = {key: {name: _difference(results, reference, key, name) for name in COMPARED} for key in common}
    marks = Marks([tested for key in common if key not in equal for tested in found[key].values()])
    rows = []
    for key in common:
        row = row_of(results, key, equal=key in equal)
        for name, (interval, p_value) in found[key].items():
            row.add(name, QUANTITIES[name].difference_heading, interval, QUANTITIES[name].fine_decimals)
            row.numbers[f"{name}_p"] = p_value
        apart = [QUANTITIES[name].symbol for name, tested in found[key].items() if marks.is_sure(*tested)]
        known = all(interval.is_known for interval, _ in found[key].values())
        if key in equal:
            verdict = "equal to the last digit"
        elif known:
            verdict = f"differs in {', '.join(apart)}" if apart else "agrees"
        else:
            verdict = "cannot be told from one seed"
        row.numbers["differs_in"] = ", ".join(apart)
        row.cells |= {"Against the reference": verdict, "n": sample_of(results, key)}
        rows.append(row)
    caption = (
        "This run minus the reference results, on the same missions [95 % Welch's t interval over the seeds of both, "
        f"each by itself]. Differs: Welch's test finds it at 5 % after Holm's correction over all {marks.num_tested} "
        "differences in which seeds vary, of all methods whose rows are not equal, so that an interval may leave 0 out "
        "and not count; or no seed varies, and there is one. Agrees: none is found. Other processors round "
        "differently, which leads trainings apart, so equal digits can be expected on like machines alone. "
        "n: seeds × test episodes."
    )
    return table_of(rows, caption)


def _difference(results: Results, reference: Results, key: str, name: str) -> tuple[Interval, float]:
    """How much more of one of ``COMPARED`` the new run of a method has, and the p-value."""
    own, others = (every.scores(key, name).mean(axis=1) for every in (results, reference))
    return welch_difference(own, others), welch_p(own, others)


def _rows(results: Results, key: str) -> pd.DataFrame:
    rows = results.episodes[results.episodes["method"] == key]
    return rows.sort_values(["seed", "episode", "uav"]).reset_index(drop=True)
