"""How much welfare there is: limits by mission, and the shares that follow, worked out by hand."""

import numpy as np
import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.results.attainable import attainable, explanation, share
from lawn_sb3.results.results import Results, read_results
from tests.handmade import flown, player, recipe_with, results_of

RECIPE = recipe_with({key: player(key) for key in ("random", "welfare", "bound")}, evaluation={"episodes": 2})


@pytest.fixture
def results() -> Results:
    """Two missions of two UAVs: the welfare of the first is 6 or 8 (random) and 10, of the second 14, 2 and 12."""
    return results_of(
        RECIPE,
        flown("random", 0, 2, utility_mbps=[6.0, 0.0, 7.0, 7.0]),
        flown("random", 1, 2, utility_mbps=[4.0, 4.0, 1.0, 1.0]),
        flown("welfare", 0, 2, utility_mbps=[5.0, 5.0, 6.0, 6.0]),
        flown("bound", 0, 2, utility_mbps=[8.0, 8.0, 10.0, 6.0]),
    )


def test_the_best_known_is_the_best_of_any_method_and_seed_mission_by_mission(results: Results) -> None:
    limits = attainable(results)
    assert limits is not None
    assert limits.best_known_mbps.tolist() == [10.0, 14.0]
    assert limits.bound_mbps.tolist() == [16.0, 16.0]


def test_shares_are_of_means_with_intervals_over_seeds(results: Results) -> None:
    limits = attainable(results)
    assert limits is not None
    # Random: means 10 and 5 over the missions, so 7.5 of 16 and of 12; a bootstrap of two seeds reaches to each.
    low, high = share(results, "random", limits)
    assert low == pytest.approx((46.875, 31.25, 62.5))
    assert high == pytest.approx((62.5, 100 * 5 / 12, 100 * 10 / 12))
    low, high = share(results, "welfare", limits)
    assert (low.value, high.value) == pytest.approx((100 * 11 / 16, 100 * 11 / 12))
    assert np.isnan(low.low)  # one seed tells no spread
    assert "lies between 12.0 Mbps" in explanation(limits)
    assert "and 16.0 Mbps" in explanation(limits)


def test_without_a_bound_or_anything_below_it_there_are_no_limits(results: Results) -> None:
    assert attainable(results.without_bound()) is None
    assert attainable(results_of(RECIPE, flown("bound", 0, 2, utility_mbps=[1.0] * 4))) is None
    failed = flown("random", 0, 2, utility_mbps=[0.0] * 4)
    assert attainable(results_of(RECIPE, failed, flown("bound", 0, 2, utility_mbps=[1.0] * 4))) is None


def test_nothing_that_was_flown_is_above_the_bound(planned: Recipe, planned_cells: list[Cell]) -> None:
    limits = attainable(read_results(planned, planned_cells))
    assert limits is not None
    assert (limits.best_known_mbps <= limits.bound_mbps + 1e-6).all()  # files keep nine digits
