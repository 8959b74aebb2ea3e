"""Milestones of the learning curves, worked out by hand on curves of a few points."""

import pandas as pd

from lawn_sb3.report.sections.training import section
from lawn_sb3.results.results import Results
from tests.handmade import flown, learner, recipe_with, results_of
from tests.report.reading import table_in

RECIPE = recipe_with({"mappo": learner("CTDE-MAPPO", paper_row="CTDE-MAPPO")})
ONE = {"method": "mappo", "seed": [0, 0, 1, 1], "time/env_steps": [1000, 2000, 1000, 2000]}


def made(**columns: list[float]) -> Results:
    """Two seeds with two points each."""
    curves = pd.DataFrame({**ONE, **{name.replace("__", "/"): values for name, values in columns.items()}})
    return results_of(RECIPE, flown("mappo", 0), curves=curves)


def test_first_crossing_is_that_of_the_slowest_seed() -> None:
    both = made(missions__success_percent=[95.0, 90.0, 80.0, 96.0], greedy__success_percent=[10.0, 20.0, 97.0, 98.0])
    row = table_in(section(both), "first_crossing").shown.iloc[0]
    assert row["training missions"] == "2,000"  # seed 0 at 1,000, seed 1 at 2,000
    assert row["greedy evaluation"] == "1 of 2 seeds"
    assert row["n"] == "2"


def test_a_first_point_that_is_high_already_bounds_the_crossing() -> None:
    high = made(missions__success_percent=[95.0, 96.0, 99.0, 96.0])
    row = table_in(section(high), "first_crossing").shown.iloc[0]
    assert row["training missions"] == "at most 1,000"
    assert row["greedy evaluation"] == "not measured"


def test_nearest_to_the_paper_is_the_evaluation_with_the_nearest_mean_success() -> None:
    # Means over the two seeds: 50 % at 1,000 env steps, 99 % at 2,000; the paper's CTDE-MAPPO has 100 %.
    others = {f"greedy__{name}": [1.0, 2.0, 3.0, 4.0] for name in ("reward", "rate_mbps", "makespan_slots")}
    results = made(greedy__success_percent=[20.0, 99.0, 80.0, 99.0], **others)
    row = table_in(section(results), "nearest_to_paper").shown.iloc[0]
    assert row["env steps"] == "2,000"
    assert row["Success (%)"] == "99.0 (100.0)"
    assert row["J̄"] == "3.00 (3.19)"


def test_without_curves_there_are_no_milestones() -> None:
    bare = results_of(RECIPE, flown("mappo", 0))
    assert section(bare) is None
