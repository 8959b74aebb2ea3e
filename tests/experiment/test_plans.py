"""Planners asked for by name: their figures hang together, and what they do not take is refused."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.evaluation import evaluate, summarize
from lawn_sb3.experiment.plans import make_planner, plan_figures
from lawn_sb3.experiment.registry import PLANNERS, find_player
from lawn_sb3.scenario import PRESETS

PAPER = PRESETS["paper"]


def figures_of(player: str, **settings: Any) -> dict[str, Any]:
    """Figures of ten episodes."""
    return plan_figures(player, PAPER, 10, 3, lambda what, total: None, **settings)


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
    assert 0 <= figures["unsettled_episodes"] <= figures["cycles"] <= 30


def test_progress_is_told_game_by_game() -> None:
    told: Counter[tuple[str, int]] = Counter()
    plan_figures("welfare", PAPER, 5, 3, lambda what, total: told.update([(what, total)]), starts=1)
    assert told == {("planning", 5): 5, ("the bound", 20): 20, ("regrets", 5): 5}


def test_slack_and_starts_reach_the_planner() -> None:
    assert figures_of("welfare", slack=0)["makespan_slots"] <= figures_of("welfare")["makespan_slots"]
    assert figures_of("welfare", starts=1)["utility_mbps"] <= figures_of("welfare", starts=8)["utility_mbps"]


def test_what_a_planner_does_not_take_is_refused() -> None:
    with pytest.raises(UserError, match="planner 'forecast' has no starts: it takes slack"):
        make_planner("forecast", starts=4)
    with pytest.raises(UserError, match=r"unknown planner 'welfar'.*did you mean 'welfare'"):
        make_planner("welfar")
