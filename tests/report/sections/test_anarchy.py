"""The price of anarchy: brackets worked out by hand, and what makes a mission count."""

from __future__ import annotations

import warnings

import numpy as np
import pandas as pd
import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.planning import BoundPlayer
from lawn_sb3.report.sections import anarchy as module
from lawn_sb3.report.sections.anarchy import anarchy, certified_welfares, guaranteed_welfares_mbps
from lawn_sb3.results.results import Results, read_results
from tests.handmade import flown, player, recipe_of, recipe_with, responded, results_of

METHODS = ("welfare", "equilibrium", "worst-equilibrium", "bound")
RECIPE = recipe_with({key: player(key) for key in METHODS}, seeds=[0], evaluation={"episodes": 2}, regret=True)


@pytest.fixture
def results(monkeypatch: pytest.MonkeyPatch) -> Results:
    """Two missions of two UAVs: welfare of the bound 100 and 60, of the ascent 90 and 50, of equilibria 80 and 50, and
    60 and 40, of which the last is none."""
    monkeypatch.setattr(module, "guaranteed_welfares_mbps", lambda results: np.array([20.0, 20.0]))
    best = flown("equilibrium", 0, 2, utility_mbps=[40.0, 40.0, 25.0, 25.0])
    worst = flown("worst-equilibrium", 0, 2, utility_mbps=[30.0, 30.0, 20.0, 20.0])
    ascent = flown("welfare", 0, 2, utility_mbps=[45.0, 45.0, 30.0, 20.0])
    regrets = [
        responded("welfare", 0, ascent, [50.0, 45.0, 30.0, 20.0]),
        responded("equilibrium", 0, best, [40.0, 40.0, 25.0, 25.0]),
        responded("worst-equilibrium", 0, worst, [30.0, 30.0, 20.0, 21.0]),
    ]
    bound = flown("bound", 0, 2, utility_mbps=[50.0, 50.0, 30.0, 30.0])
    return results_of(RECIPE, best, worst, ascent, bound, regrets=pd.concat(regrets, ignore_index=True))


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


def test_with_nothing_guaranteed_there_is_no_upper_side(results: Results, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "guaranteed_welfares_mbps", lambda results: np.zeros(2))
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


def test_without_a_bound_or_equilibria_there_is_no_bracket(results: Results) -> None:
    assert anarchy(results.without_bound()) is None
    results.regrets = results.regrets.assign(best_mbps=1_000.0)
    assert anarchy(results) is None
    results.regrets = results.regrets[results.regrets["method"] == "welfare"]
    assert anarchy(results) is None


WAITING = (
    "width_voxels=11", "length_voxels=1", "max_altitude_m=10", "max_voxel_steps=1", "ema_beta=0.05",
    "gbs_positions_m=[[100, 5, 0]]", "path_loss_exponent=10", "tx_power_dbm=-60",
)  # fmt: skip
"""A corridor that is served at its end alone, where it pays to wait."""


@pytest.mark.parametrize("game", [(), WAITING])
def test_a_guarantee_is_the_share_of_the_rbs_that_is_left_of_the_best_flight_alone(game: tuple[str, ...]) -> None:
    # 12 RBs among 3 UAVs leave each 4, a third: every rate is a third of that alone, and so is every utility.
    recipe = recipe_of(3, ("a",), episodes=5).model_copy(update={"set": ("num_uavs=3", "rbs_per_gbs=12", *game)})
    alone = evaluate(BoundPlayer(), recipe.game(), 5, recipe.evaluation.seed)
    assert ((alone["slots"] > alone["min_slots"] + 5).any()) == bool(game)
    expected = alone.groupby("episode")["utility_mbps"].sum() / 3
    assert guaranteed_welfares_mbps(Results(recipe)) == pytest.approx(expected.to_numpy())


def test_real_equilibria_lie_inside_their_limits(planned: Recipe, planned_cells: list[Cell]) -> None:
    found = certified_welfares(read_results(planned, planned_cells))
    assert found is not None
    bound, best, best_found, worst_found, guaranteed = found.welfares
    assert (found.missions, found.searches, found.certified) == (6, 12, 12)
    rounding = 1e-6
    assert (guaranteed <= worst_found + rounding).all()
    assert (worst_found <= best_found).all()
    assert (best_found <= best + rounding).all()
    assert (best <= bound + rounding).all()
