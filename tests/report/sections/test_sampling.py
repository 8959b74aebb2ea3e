"""Greedy against sampled play: paired by seed on the same missions."""

import pandas as pd
import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.report.sections.sampling import section
from lawn_sb3.report.table import Table
from lawn_sb3.results.results import Results, read_results
from tests.handmade import flown, recipe_of, results_of
from tests.report.reading import interval_in, numbers_of, table_in


@pytest.fixture
def results() -> Results:
    recipe = recipe_of(2, ("untrained", "a"), seeds=3)
    greedy = [
        flown("a", 0, 2, reward=[1.0, 3.0], arrived=[True, False], makespan_slots=[9, 9]),
        flown("a", 1, 2, reward=[4.0, 4.0], makespan_slots=[4, 4]),
        flown("a", 2, 2, reward=[100.0, 100.0], makespan_slots=[50, 50]),
        flown("untrained", 0, 2, reward=[0.0, 0.0]),
    ]
    sampled = [
        flown("a", 1, 2, reward=[2.0, 3.0], makespan_slots=[6, 6]),
        flown("a", 0, 2, reward=[1.0, 2.0], makespan_slots=[5, 5]),
    ]
    return results_of(recipe, *greedy, sampled=pd.concat(sampled, ignore_index=True))


def sampled_table(results: Results) -> Table:
    return table_in(section(results), "sampling")


def test_differences_are_taken_seed_by_seed_of_those_that_were_flown_both_ways(results: Results) -> None:
    # Seeds 0 and 1 have rewards 2 - 1.5 = 0.5 and 4 - 2.5 = 1.5: 1 on average, resampled between 0.5 and 1.5.
    # Slots 9 - 5 = 4 and 4 - 6 = -2; success 50 - 100 = -50 and 100 - 100 = 0 percent.
    table = sampled_table(results)
    (row,) = table.shown.to_dict("records")
    assert row == {
        "Method": "M2",
        "Success (%)": "75.0 / 100.0",
        "Δ Success (%)": "-25.0 [-50.0, 0.0]",
        "J̄": "3.000 / 2.000",
        "Δ J̄": "1.000 [0.500, 1.500]",
        "T̄ (slots)": "6.5 / 5.5",
        "Δ T̄ (slots)": "1.0 [-2.0, 4.0]",
        "n": "2 × 1",
    }
    assert table.numbers.loc[0, "reward_greedy_high"] == 4.0
    assert table.numbers.loc[0, "reward_sampled_low"] == 1.5


def test_equal_play_differs_by_nothing(results: Results) -> None:
    same = results_of(results.recipe, results.episodes, sampled=results.episodes[results.episodes["method"] == "a"])
    row = numbers_of(sampled_table(same))["a"]
    for name in ("reward", "success_percent", "makespan_slots"):
        assert interval_in(row, f"{name}_difference") == [0.0] * 3


def test_without_sampled_play_the_table_is_empty(results: Results) -> None:
    assert not section(results_of(results.recipe, results.episodes)).shown


def test_only_methods_that_learn_are_compared(recipe: Recipe, small_cells: list[Cell]) -> None:
    assert sampled_table(read_results(recipe, small_cells)).shown["Method"].tolist() == ["CTDE-MAPPO"]
