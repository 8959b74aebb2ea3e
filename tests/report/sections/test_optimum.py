"""How stable outcomes are, and what that costs: regrets, Nash gaps and brackets worked out on paper."""

import warnings
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.paper.checks import read_checks
from lawn_sb3.report.sections.optimum import anarchy, section, shown_mbps
from lawn_sb3.results.equilibria import certified_welfares, is_equilibrium, regrets_mbps
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


METHODS = ("welfare", "equilibrium", "worst-equilibrium", "bound")
PLANNERS = recipe_with({key: player(key) for key in METHODS}, seeds=[0], evaluation={"episodes": 2}, regret=True)


def guaranteed(mbps: float) -> dict[str, pd.DataFrame | str]:
    return {"guaranteed": pd.DataFrame({"episode": [0, 0, 1, 1], "uav": [0, 1, 0, 1], "guaranteed_mbps": mbps})}


@pytest.fixture
def searched() -> Results:
    """Two missions of two UAVs: welfare of the bound 100 and 60, of the ascent 90 and 50, of equilibria 80 and 50, and
    60 and 40, of which the last is none; 20 are guaranteed."""
    best = flown("equilibrium", 0, 2, utility_mbps=[40.0, 40.0, 25.0, 25.0])
    worst = flown("worst-equilibrium", 0, 2, utility_mbps=[30.0, 30.0, 20.0, 20.0])
    ascent = flown("welfare", 0, 2, utility_mbps=[45.0, 45.0, 30.0, 20.0])
    regrets = [
        responded("welfare", 0, ascent, [50.0, 45.0, 30.0, 20.0]),
        responded("equilibrium", 0, best, [40.0, 40.0, 25.0, 25.0]),
        responded("worst-equilibrium", 0, worst, [30.0, 30.0, 20.0, 21.0]),
    ]
    bound = flown("bound", 0, 2, utility_mbps=[50.0, 50.0, 30.0, 30.0])
    responses = pd.concat(regrets, ignore_index=True)
    return results_of(PLANNERS, best, worst, ascent, bound, regrets=responses, checks=guaranteed(10.0))


def test_brackets_by_hand(searched: Results) -> None:
    # Best known 90 and 50, best equilibria 80 and 50, worst ones 60 and 50: means 70, 65 and 55; of the bound 80.
    table = anarchy(searched)
    assert table is not None
    sides = ["at_least", "at_most", "at_least_one_mission", "at_most_one_mission"]
    assert table.numbers[sides].to_numpy() == pytest.approx(
        np.array(
            [
                [70 / 55, 80 / 20, 90 / 60, 100 / 20],  # the worst there is: at most the bound over the guarantee
                [70 / 55, 80 / 55, 90 / 60, 100 / 60],  # the worst found
                [70 / 65, 80 / 65, 90 / 80, 100 / 80],  # the best found
                [1.0, 80 / 65, 1.0, 100 / 80],  # the best there is
            ]
        )
    )
    assert table.shown.iloc[0].tolist()[1:] == ["1.273 to 4.000", "1.500 to 5.000", "2"]
    assert "certify 3 of the 4 results" in table.caption
    assert "0 of 2 missions have none" in table.caption


def test_with_nothing_guaranteed_there_is_no_upper_side(searched: Results) -> None:
    searched.checks = guaranteed(0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        table = anarchy(searched)
    assert table is not None
    assert table.shown.iloc[0].tolist()[1:] == ["1.273 or more", "1.500 or more", "2"]


def test_missions_without_a_certified_equilibrium_are_left_out_and_counted(searched: Results) -> None:
    # The other search of the second mission ends in a collision, so that nothing certifies it.
    collided = (searched.episodes["method"] == "equilibrium") & (searched.episodes["episode"] == 1)
    searched.episodes.loc[collided, "collisions"] = 1
    table = anarchy(searched)
    assert table is not None
    assert table.numbers["missions"].tolist() == [1] * 4
    assert table.numbers.loc[0, "at_least"] == pytest.approx(90 / 60)
    assert "certify 2 of the 4 results" in table.caption
    assert "1 of 2 missions have none" in table.caption


def test_without_a_bound_a_guarantee_or_equilibria_there_is_no_bracket(searched: Results) -> None:
    assert anarchy(replace(searched, checks={})) is None
    assert anarchy(searched.without_bound()) is None
    searched.regrets = searched.regrets.assign(best_mbps=1_000.0)
    assert anarchy(searched) is None
    searched.regrets = searched.regrets[searched.regrets["method"] == "welfare"]
    assert anarchy(searched) is None


def test_real_equilibria_lie_inside_their_limits(planned: Recipe, planned_cells: list[Cell]) -> None:
    results = read_results(planned, planned_cells)
    results.checks = read_checks(planned, planned_cells, results.problems)
    found = certified_welfares(results)
    assert found is not None
    bound, best, best_found, worst_found, guaranteed = found.welfares
    assert (found.missions, found.searches, found.certified) == (6, 12, 12)
    rounding = 1e-6
    assert (guaranteed <= worst_found + rounding).all()
    assert (worst_found <= best_found).all()
    assert (best_found <= best + rounding).all()
    assert (best <= bound + rounding).all()
