"""Fairness over the UAVs of an episode, with figures worked out on paper."""

import numpy as np
import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.report.sections.low_utilities import fairness
from lawn_sb3.results.results import read_results
from tests.handmade import flown, recipe_of, results_of
from tests.report.reading import interval_in, numbers_of


def test_indices_are_means_over_episodes_by_hand() -> None:
    # Episode 0: utilities 10, 30: Jain 40^2 / (2 * 1000) = 0.8; Gini 2 * 20 / (2 * 2 * 40) = 0.25; the worst has 10.
    # Episode 1: 20, 20: Jain 1, Gini 0, worst 20. Episode 2: nobody arrives: Jain 1, Gini 0, worst 0.
    # Nash welfare: sqrt(10 * 30), 20, and 0.
    rows = flown("a", 0, 2, utility_mbps=[10.0, 30.0, 20.0, 20.0, 0.0, 0.0])
    numbers = fairness(results_of(recipe_of(2, ("a",), episodes=3), rows)).numbers.iloc[0]
    assert numbers["jain"] == pytest.approx((0.8 + 1 + 1) / 3)
    assert numbers["gini"] == pytest.approx(0.25 / 3)
    assert numbers["nash_welfare_mbps"] == pytest.approx((300**0.5 + 20) / 3)
    assert numbers["worst_mbps"] == pytest.approx(10.0)
    assert numbers["utility_mbps"] == pytest.approx(80 / 6)
    assert numbers["nobody_percent"] == pytest.approx(100 / 3)
    assert np.isnan(numbers["jain_low"])  # one seed tells no spread


def test_intervals_are_over_seeds() -> None:
    # Jain of seed 0 is 1, of seed 1 1/2: resampled means are 1/2, 3/4, 1 with probability 1/4, 1/2, 1/4.
    rows = [flown("a", seed, 2, utility_mbps=values) for seed, values in enumerate(([7.0, 7.0], [7.0, 0.0]))]
    table = fairness(results_of(recipe_of(2, ("a",), seeds=2), *rows))
    assert interval_in(numbers_of(table)["a"], "jain") == [0.75, 0.5, 1.0]
    assert table.shown.loc[0, "Jain index"] == "0.750 [0.500, 1.000]"
    assert table.shown.loc[0, "n"] == "2 × 1"


def test_every_method_of_real_runs_has_a_row(recipe: Recipe, small_cells: list[Cell]) -> None:
    results = read_results(recipe, small_cells)
    table = fairness(results)
    assert table.shown["Method"].tolist() == ["Random", "CTDE-MAPPO"]
    assert table.numbers["jain"].between(0.25, 1.0).all()  # from 1/N to 1
    assert table.numbers["utility_mbps"].tolist() == pytest.approx(
        [results.scores(key, "utility_mbps").mean() for key in results.methods]
    )
    assert "its 4 UAVs" in table.caption
