"""How stable an outcome is: regrets and Nash gaps worked out on paper, and what real equilibria have."""

import numpy as np
import pandas as pd
import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.report.sections.optimum import section, shown_mbps
from lawn_sb3.results.equilibria import is_equilibrium, regrets_mbps
from lawn_sb3.results.results import Results, read_results
from tests.handmade import flown, player, recipe_with, responded, results_of
from tests.report.reading import numbers_of, picture_in, table_in

RECIPE = recipe_with({key: player(key) for key in ("random", "equilibrium")}, evaluation={"episodes": 2})


@pytest.fixture
def results() -> Results:
    """Two missions of two UAVs; with seed 0 the regrets of random are 0, 4 and 0, 1/2, with seed 1 all are 0."""
    first = flown("random", 0, 2, utility_mbps=[10.0, 20.0, 30.0, 5.0], collisions=[0, 0, 1, 1])
    second = flown("random", 1, 2, utility_mbps=[10.0, 20.0, 30.0, 5.0], collisions=[0, 0, 1, 1])
    regrets = [
        # 5e-7 is rounding; the third UAV collided and had more than its best response.
        responded("random", 0, first, [10.0000005, 24.0, 28.0, 5.5]),
        responded("random", 1, second, [10.0, 20.0, 28.0, 5.0]),
    ]
    return results_of(RECIPE, first, second, regrets=pd.concat(regrets, ignore_index=True))


def test_regrets_are_never_negative_and_rounding_is_none(results: Results) -> None:
    assert regrets_mbps(results)["regret_mbps"].tolist() == [0.0, 4.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0]


def test_the_table_by_hand(results: Results) -> None:
    table = table_in(section(results), "regret")
    numbers = table.numbers.iloc[0]
    # Seed 0: mean 4.5 / 4, gap (4 + 0.5) / 2, one UAV of four gains more than 1 Mbps. Seed 1: nothing.
    # Bootstrap means of two seeds reach from the one to the other.
    assert numbers[["regret_mbps", "regret_mbps_low", "regret_mbps_high"]].tolist() == [0.5625, 0.0, 1.125]
    assert numbers[["nash_gap_mbps", "nash_gap_mbps_high"]].tolist() == [1.125, 2.25]
    assert numbers["largest_mbps"] == 4.0
    assert numbers["gaining_percent"] == 12.5
    # Of the four episodes only the first of seed 1 has neither regret nor collisions.
    assert numbers["equilibria_percent"] == 25.0
    assert is_equilibrium(results, "random").tolist() == [[False, False], [True, False]]
    shown = table.shown.iloc[0]
    assert shown["Nash gap (Mbps)"] == "1.12 [0.00, 2.25]"
    assert shown["Largest regret (Mbps)"] == "4.0"
    assert shown["n"] == "2 × 2"
    assert table.shown["Method"].tolist() == ["Random"]  # the other one has no regrets


def test_a_run_without_regrets_does_not_count(results: Results) -> None:
    results.regrets = results.regrets[results.regrets["seed"] == 1]
    assert is_equilibrium(results, "random").tolist() == [[True, False]]
    row = numbers_of(table_in(section(results), "regret"))["random"]
    assert (row["seeds"], row["regret_mbps"]) == (1, 0.0)


def test_the_figure_begins_at_the_share_that_has_nothing_to_gain(results: Results) -> None:
    picture = picture_in(section(results), "regret_cdf")
    (ax,) = picture.figure.axes
    (line,) = ax.lines
    x, share = (np.asarray(values) for values in line.get_data())
    assert share[0] == 6 / 8
    assert share[np.searchsorted(x, 0.6)] == 7 / 8
    assert "begins at the left" in picture.caption


def test_the_axis_shows_nearly_all_uavs_of_every_method_but_random(results: Results) -> None:
    rows = regrets_mbps(results)
    assert shown_mbps(results, rows) == pytest.approx(rows["regret_mbps"].quantile(0.995))  # random is alone
    many = pd.DataFrame({"method": "equilibrium", "seed": 0, "regret_mbps": [2.0] * 999 + [50.0]})
    assert shown_mbps(results, pd.concat([rows, many])) == 2.0
    assert shown_mbps(results, many.assign(regret_mbps=0.0)) == 1.0  # an axis must have a length


def test_equilibria_of_real_runs_are_certified_and_random_play_is_none(
    planned: Recipe, planned_cells: list[Cell]
) -> None:
    results = read_results(planned, planned_cells)
    assert is_equilibrium(results, "equilibrium").all()
    assert not is_equilibrium(results, "random").any()
    numbers = numbers_of(table_in(section(results), "regret"))
    assert numbers["equilibrium"]["largest_mbps"] == 0.0
    assert numbers["random"]["regret_mbps"] > 1.0
    assert "bound" not in numbers
