"""Speed of planning: one exact best response, and the welfare ascent of many episodes."""

import time

import numpy as np

from lawn_sb3.experiment.plan_episodes import Advance
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning import WelfarePlayer
from lawn_sb3.planning.best_response import best_response
from lawn_sb3.planning.flight import DEFAULT_SLACK
from lawn_sb3.planning.routes import routes_alone
from lawn_sb3.scenario import PRESETS, Scenario


def planning_speeds(episodes: int, advance: Advance) -> dict[str, float]:
    """Durations of best responses and of the welfare ascent of so many episodes."""
    figures = {}
    for name, game in PRESETS.items():
        mean, longest = _response_seconds(game, 25, advance)
        figures[f"best_response_{name}_ms"] = mean * 1e3
        figures[f"best_response_{name}_longest_ms"] = longest * 1e3
    figures[f"welfare_ascent_{episodes}_episodes_s"] = _ascent_seconds(PRESETS["paper"], episodes, advance)
    return figures


def _response_seconds(scenario: Scenario, num_games: int, advance: Advance) -> tuple[float, float]:
    """Mean and longest duration of one exact best response for the welfare, the others on their routes as if alone."""
    simulator = Simulator(scenario, num_games, seed=0)
    rules, state = simulator.rules, simulator.state
    durations: list[float] = []
    for game in range(num_games):
        plan = routes_alone(rules, state, game, DEFAULT_SLACK)
        if game == 0:
            best_response(rules, state, 0, plan, 0, True, DEFAULT_SLACK)  # compiles
        for uav in range(scenario.num_uavs):
            start = time.perf_counter()
            best_response(rules, state, game, plan, uav, True, DEFAULT_SLACK)
            durations.append(time.perf_counter() - start)
        advance(f"exact best responses, {scenario.name}", num_games)
    return float(np.mean(durations)), max(durations)


def _ascent_seconds(scenario: Scenario, episodes: int, advance: Advance) -> float:
    """Duration of the welfare ascent of some episodes, all starts of each."""
    player = WelfarePlayer(on_game=lambda: advance(f"welfare ascent, {episodes} episodes", episodes))
    WelfarePlayer().start(Simulator(scenario, 1, seed=0), np.random.default_rng(0))  # compiles
    simulator = Simulator(scenario, episodes, seed=0)
    start = time.perf_counter()
    player.start(simulator, np.random.default_rng(0))
    return time.perf_counter() - start
