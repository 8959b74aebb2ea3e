"""Milestones of the learning curves: when success is first high, and where a method is nearest to the paper's."""

from __future__ import annotations

import pandas as pd

from lawn_sb3.paper.printed_values import TABLE_II, PaperRow
from lawn_sb3.report.section import Section
from lawn_sb3.report.sections.training import HEADING, shows
from lawn_sb3.report.table import Table, table_of
from lawn_sb3.results.learning import THRESHOLD
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results

HEADING_OF = {"missions": "training missions", "greedy": "greedy evaluation"}


def section(results: Results) -> Section | None:
    """First crossing, and what is nearest to the paper."""
    if not shows(results):
        return None
    tables = {"first_crossing": _first_crossing(results), "nearest_to_paper": _nearest_to_paper(results)}
    return Section(HEADING, tables)


def _first_crossing(results: Results) -> Table:
    """When each training first reached 95 % success, by its slowest seed, in training missions and greedy play."""
    rows = []
    for key, method in results.methods.items():
        if method.algo is None or not len(results.curves):
            continue
        own = results.curves[results.curves["method"] == key]
        row: dict[str, object] = {"method": method.label, "key": key}
        cells = {"Method": method.label}
        for source, heading in HEADING_OF.items():
            column = f"{source}/success_percent"
            if column not in own or own[column].isna().all():
                cells[heading] = "not measured"
                continue
            seeds = [curve.dropna(subset=[column]) for _, curve in own.groupby("seed")]
            first = [curve.loc[curve[column] >= THRESHOLD, "time/env_steps"].min() for curve in seeds]
            reached = [value for value in first if pd.notna(value)]
            row |= {f"{source}_seeds": len(first), f"{source}_reached": len(reached)}
            cells[heading] = f"{len(reached)} of {len(first)} seeds"
            if len(reached) == len(first):
                at_once = max(reached) <= max(curve["time/env_steps"].min() for curve in seeds)
                row[f"{source}_env_steps"] = max(reached)
                cells[heading] = f"{'at most ' if at_once else ''}{max(reached):,.0f}"
        rows.append((row, {**cells, "n": str(own["seed"].nunique())}))
    caption = (
        f"Env steps until the first rollout (or greedy evaluation) with {THRESHOLD:.0f} % success, slowest seed; the "
        "paper: about 150 K. At most: that was the first figure there is. Training missions are not smoothed here and "
        "count too few failures early on, as those take longest to end. n: seeds."
    )
    return table_of(rows, caption)


def _nearest_to_paper(results: Results) -> Table | None:
    """Where on its learning curve a method comes nearest to the success of its row in the paper."""
    rows, columns = [], [f"greedy/{name}" for name in PaperRow._fields]
    if not set(columns) <= set(results.curves):
        return None
    for key, method in results.methods.items():
        own = results.curves[results.curves["method"] == key].dropna(subset=columns)
        if method.algo is None or method.paper_row is None or not len(own):
            continue
        curve = own.groupby("time/env_steps")[columns].mean()
        printed = TABLE_II[method.paper_row]._asdict()
        distance = (curve["greedy/success_percent"] - printed["success_percent"]).abs()
        at = int(distance.to_numpy().argmin())
        row: dict[str, object] = {"method": method.label, "key": key, "env_steps": curve.index[at]}
        cells = {"Method": method.label, "env steps": f"{curve.index[at]:,.0f}"}
        for name, paper in printed.items():
            quantity, value = QUANTITIES[name], float(curve.iloc[at][f"greedy/{name}"])
            row |= {name: value, f"{name}_paper": paper}
            cells[quantity.heading] = f"{value:.{quantity.decimals}f} ({paper:.{quantity.decimals}f})"
        rows.append((row, {**cells, "n": str(own["seed"].nunique())}))
    caption = (
        "Where on its learning curve each learner comes nearest to its success in the paper: greedy evaluation during "
        "training, mean over seeds; in parentheses the paper's final values. n: seeds."
    )
    return table_of(rows, caption)
