"""What a planner makes of some games: its evaluation, its share of the bound, its regret and its fairness."""

from collections.abc import Callable
from typing import Any, NamedTuple

from lawn_sb3.experiment.evaluation import Flights, evaluate, evaluation_games, flies_alone, fly
from lawn_sb3.experiment.measures import regrets, summarize, summarize_regrets
from lawn_sb3.experiment.registry import make_planner
from lawn_sb3.game.fairness import gini, jain_index, nash_welfare
from lawn_sb3.planning import BoundPlayer
from lawn_sb3.planning.equilibrium import SearchPlayer
from lawn_sb3.planning.plan import check_in_time
from lawn_sb3.scenario import Scenario

Advance = Callable[[str, int], None]
"""Called after each game with what is being done, and the number of games that it is done for."""


class Planned(NamedTuple):
    """What a planner did."""

    figures: dict[str, Any]
    """Means by name, the unit in the name."""
    flights: Flights
    """All of its episodes, paths included."""


def plan_episodes(
    name: str, scenario: Scenario, episodes: int, seed: int, advance: Advance, with_regret: bool = True, **settings: Any
) -> Planned:
    """Let a planner plan and fly some episodes.

    :param name: its name, such as ``equilibrium``
    :param scenario: the game
    :param episodes: number of joint episodes E
    :param seed: picks the missions, and the starts of a search
    :param advance: called after each game
    :param with_regret: also work out what each UAV could gain by deviating alone
    :param settings: what to change: ``slack``, ``starts``
    :return: figures and flights; with regrets, the rows have the columns ``best_mbps`` and ``best_slots`` too
    :raises UserError: if there is no such planner or setting, or a mission cannot be flown in time
    """
    player = make_planner(name, on_game=lambda: advance("planning", episodes), **settings)
    games = evaluation_games(scenario, episodes, seed)
    check_in_time(games.rules, games.state)
    flights = fly(player, scenario, episodes, seed, traced=episodes)
    figures: dict[str, Any] = {"method": name, "scenario": scenario.title, "episodes": episodes, "seed": seed}
    figures |= summarize(flights.rows)
    if flies_alone(player):
        return Planned(figures, flights)
    bound = BoundPlayer(on_game=lambda: advance("the bound", episodes * scenario.num_uavs))
    figures["bound_mbps"] = summarize(evaluate(bound, scenario, episodes, seed))["utility_mbps"]
    figures["share_of_bound_percent"] = 100.0 * figures["utility_mbps"] / figures["bound_mbps"]
    utilities = flights.rows["utility_mbps"].to_numpy().reshape(episodes, -1)
    figures["jain_index"] = float(jain_index(utilities).mean())
    figures["gini"] = float(gini(utilities).mean())
    figures["nash_welfare_mbps"] = float(nash_welfare(utilities).mean())
    figures["worst_uav_mbps"] = float(utilities.min(axis=1).mean())
    if with_regret:
        found = regrets(flights, scenario, seed, lambda: advance("regrets", episodes))
        figures |= summarize_regrets(found, flights.rows)
        flights = flights._replace(rows=flights.rows.assign(**found[["best_mbps", "best_slots"]]))
    if isinstance(player, SearchPlayer):
        figures |= {"searches": player.searches, "longest_search_rounds": player.longest_rounds}
        figures |= {"cycles": player.cycles, "cut_searches": player.cut, "unsettled_episodes": player.unsettled}
    return Planned(figures, flights)
