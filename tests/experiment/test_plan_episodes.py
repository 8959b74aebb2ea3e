"""Planners asked for by name: their figures hang together, and what they do not take is refused."""

from collections import Counter
from typing import Any

import numpy as np
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.experiment.plan_episodes import plan_episodes
from lawn_sb3.experiment.registry import PLANNERS, find_player, make_planner
from lawn_sb3.game.airspace import draw_missions
from lawn_sb3.planning import WelfarePlayer
from lawn_sb3.scenario import PRESETS

PAPER = PRESETS["paper"]


def figures_of(player: str, **settings: Any) -> dict[str, Any]:
    return plan_episodes(player, PAPER, 10, 3, lambda what, total: None, **settings).figures


@pytest.mark.parametrize("player", PLANNERS)
def test_the_figures_are_those_of_the_evaluation(player: str) -> None:
    figures = figures_of(player, with_regret=False)
    for name, value in summarize(evaluate(find_player(player), PAPER, 10, 3)).items():
        assert figures[name] == value
    assert figures["method"] == player
    assert "regret_mbps" not in figures


def test_the_more_a_planner_knows_the_nearer_it_comes_to_the_bound() -> None:
    best_route, equilibrium, welfare = (figures_of(player) for player in ("best-route", "equilibrium", "welfare"))
    shares = [figures["share_of_bound_percent"] for figures in (best_route, equilibrium, welfare)]
    assert shares == sorted(shares)
    assert shares[-1] < 100.0
    assert welfare["bound_mbps"] == figures_of("bound")["utility_mbps"]
    assert equilibrium["nash_gap_mbps"] < 1e-9 < best_route["nash_gap_mbps"]
    assert equilibrium["worst_uav_mbps"] <= equilibrium["nash_welfare_mbps"] <= equilibrium["utility_mbps"]


def test_how_searches_ended_is_counted() -> None:
    figures = figures_of("equilibrium", starts=3)
    assert figures["searches"] == 30
    assert (figures["cycles"], figures["cut_searches"], figures["unsettled_episodes"]) == (0, 0, 0)
    assert 2 <= figures["longest_search_rounds"] <= 10


def test_progress_is_told_game_by_game() -> None:
    told: Counter[tuple[str, int]] = Counter()
    plan_episodes("welfare", PAPER, 5, 3, lambda what, total: told.update([(what, total)]), starts=1)
    assert told == {("planning", 5): 5, ("the bound", 20): 20, ("regrets", 5): 5}


def test_slack_and_starts_reach_the_planner() -> None:
    figures = figures_of("welfare", slack=0, starts=2)
    direct = summarize(evaluate(WelfarePlayer(slack=0, starts=2), PAPER, 10, 3))
    assert figures["utility_mbps"] == direct["utility_mbps"]
    assert figures["utility_mbps"] < figures_of("welfare")["utility_mbps"]


def test_rows_have_the_best_responses_and_paths_every_slot() -> None:
    _, flights = plan_episodes("forecast", PAPER, 10, 3, lambda what, total: None)
    assert (flights.rows["best_mbps"] >= flights.rows["utility_mbps"] - 1e-9).all()  # nobody collides here
    assert flights.rows["collisions"].sum() == 0
    assert len(flights.paths) == (flights.rows["slots"] + 1).sum()


@pytest.mark.parametrize("player", PLANNERS)
def test_a_mission_that_cannot_be_flown_is_named_by_its_uav_whoever_plans(player: str) -> None:
    with pytest.raises(UserError, match="cannot fly its mission") as error:
        plan_episodes(player, PAPER.changed(max_slots=3), 50, 20_000, lambda what, total: None)
    missions = draw_missions(PAPER, 50, np.random.default_rng(20_000))
    steps = np.abs(missions.origins - missions.destinations).sum(axis=-1)
    game, uav = np.argwhere(steps > 9)[0]  # three slots of three steps
    assert str(error.value).startswith(f"UAV {uav} of game {game} ")


def test_what_a_planner_does_not_take_is_refused() -> None:
    with pytest.raises(UserError, match="planner 'forecast' has no starts: it takes slack"):
        make_planner("forecast", starts=4)
    with pytest.raises(UserError, match=r"unknown planner 'welfar'.*did you mean 'welfare'"):
        make_planner("welfar")
