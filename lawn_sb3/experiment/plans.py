"""What a planner makes of some games: its evaluation, its share of the bound, its regret and its fairness."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.evaluation import evaluate, flies_alone, fly, summarize
from lawn_sb3.experiment.registry import PLANNERS
from lawn_sb3.experiment.regret import regrets, summarize_regrets
from lawn_sb3.game.fairness import gini, jain_index, nash_welfare
from lawn_sb3.game.player import Player
from lawn_sb3.planning import BoundPlayer
from lawn_sb3.planning.equilibrium import SearchPlayer
from lawn_sb3.scenario import Scenario

Advance = Callable[[str, int], None]
"""Called after each game with what is being done, and the number of games that it is done for."""


def make_planner(name: str, **settings: Any) -> Player:
    """Build a planner with settings of its own.

    :param name: its name, such as ``equilibrium``
    :param settings: what to change: ``slack``, ``starts``; ``on_game`` is left out where a planner does not take it
    :return: the player
    :raises UserError: if there is none of that name, or it has no such setting
    """
    if name not in PLANNERS:
        raise unknown_name("planner", name, PLANNERS)
    known = inspect.signature(PLANNERS[name]).parameters
    for key in settings.keys() - known.keys() - {"on_game"}:
        raise UserError(f"planner {name!r} has no {key}: it takes {', '.join(known.keys() - {'on_game'}) or 'none'}")
    return PLANNERS[name](**{key: value for key, value in settings.items() if key in known})


def plan_figures(
    name: str, scenario: Scenario, episodes: int, seed: int, advance: Advance, with_regret: bool = True, **settings: Any
) -> dict[str, Any]:
    """Let a planner plan and fly some episodes.

    :param name: its name, such as ``equilibrium``
    :param scenario: the game
    :param episodes: number of joint episodes E
    :param seed: picks the missions, and the starts of a search
    :param advance: called after each game
    :param with_regret: also work out what each UAV could gain by deviating alone
    :param settings: what to change: ``slack``, ``starts``
    :return: figures by name, the unit in the name
    :raises UserError: if there is no such planner or setting, or a mission cannot be flown in time
    """
    player = make_planner(name, on_game=lambda: advance("planning", episodes), **settings)
    alone = flies_alone(player)
    flights = fly(player, scenario, episodes, seed, traced=episodes if with_regret and not alone else 0)
    figures: dict[str, Any] = {"method": name, "scenario": scenario.title, "episodes": episodes, "seed": seed}
    figures |= summarize(flights.rows)
    if alone:
        return figures
    bound = BoundPlayer(on_game=lambda: advance("the bound", episodes * scenario.num_uavs))
    figures["bound_mbps"] = summarize(evaluate(bound, scenario, episodes, seed))["utility_mbps"]
    figures["share_of_bound_percent"] = 100.0 * figures["utility_mbps"] / figures["bound_mbps"]
    utilities = flights.rows["utility_mbps"].to_numpy().reshape(episodes, -1)
    figures["jain_index"] = float(jain_index(utilities).mean())
    figures["gini"] = float(gini(utilities).mean())
    figures["nash_welfare_mbps"] = float(nash_welfare(utilities).mean())
    figures["worst_uav_mbps"] = float(utilities.min(axis=1).mean())
    if with_regret:
        rows = regrets(flights, scenario, seed, lambda: advance("regrets", episodes))
        figures |= summarize_regrets(rows, flights.rows)
    if isinstance(player, SearchPlayer):
        figures |= {"searches": player.searches, "cycles": player.cycles, "cut_searches": player.cut}
        figures["unsettled_episodes"] = player.unsettled
    return figures
