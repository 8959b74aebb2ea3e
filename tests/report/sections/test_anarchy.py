"""The price of anarchy: brackets worked out by hand, and what makes a mission count."""

import warnings
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.paper.checks import read_checks
from lawn_sb3.report.sections.optimum import anarchy
from lawn_sb3.results.equilibria import certified_welfares
from lawn_sb3.results.results import Results, read_results
from tests.handmade import flown, player, recipe_with, responded, results_of

METHODS = ("welfare", "equilibrium", "worst-equilibrium", "bound")
RECIPE = recipe_with({key: player(key) for key in METHODS}, seeds=[0], evaluation={"episodes": 2}, regret=True)


def guaranteed(mbps: float) -> dict[str, pd.DataFrame | str]:
    """What every UAV is guaranteed."""
    return {"guaranteed": pd.DataFrame({"episode": [0, 0, 1, 1], "uav": [0, 1, 0, 1], "guaranteed_mbps": mbps})}


@pytest.fixture
def results() -> Results:
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
    return results_of(RECIPE, best, worst, ascent, bound, regrets=responses, checks=guaranteed(10.0))


def test_brackets_by_hand(results: Results) -> None:
    # Best known 90 and 50, best equilibria 80 and 50, worst ones 60 and 50: means 70, 65 and 55; of the bound 80.
    table = anarchy(results)
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


def test_with_nothing_guaranteed_there_is_no_upper_side(results: Results) -> None:
    results.checks = guaranteed(0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        table = anarchy(results)
    assert table is not None
    assert table.shown.iloc[0].tolist()[1:] == ["1.273 or more", "1.500 or more", "2"]


def test_missions_without_a_certified_equilibrium_are_left_out_and_counted(results: Results) -> None:
    # The other search of the second mission ends in a collision, so that nothing certifies it.
    collided = (results.episodes["method"] == "equilibrium") & (results.episodes["episode"] == 1)
    results.episodes.loc[collided, "collisions"] = 1
    table = anarchy(results)
    assert table is not None
    assert table.numbers["missions"].tolist() == [1] * 4
    assert table.numbers.loc[0, "at_least"] == pytest.approx(90 / 60)
    assert "certify 2 of the 4 results" in table.caption
    assert "1 of 2 missions have none" in table.caption


def test_without_a_bound_a_guarantee_or_equilibria_there_is_no_bracket(results: Results) -> None:
    assert anarchy(replace(results, checks={})) is None
    assert anarchy(results.without_bound()) is None
    results.regrets = results.regrets.assign(best_mbps=1_000.0)
    assert anarchy(results) is None
    results.regrets = results.regrets[results.regrets["method"] == "welfare"]
    assert anarchy(results) is None


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
