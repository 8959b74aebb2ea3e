"""How fast the kit is on this machine: simulator, environment, planning, training; one core, one torch thread."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch as th
from stable_baselines3.common.vec_env import VecEnv

from lawn_sb3.envs import make_vec_env
from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Evaluation, Method
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning import WelfarePlayer
from lawn_sb3.planning.best_response import best_response
from lawn_sb3.planning.flight import DEFAULT_SLACK
from lawn_sb3.planning.routes import routes_alone
from lawn_sb3.scenario import PRESETS, Scenario

Advance = Callable[[str, int], None]
"""Called after each part of a measurement with what is being measured, and the number of its parts."""
PARTS = 20
"""Of a measurement that has none by itself."""


def benchmark(method: Method, advance: Advance) -> dict[str, float]:
    """Measure all speeds.

    :param method: the training to time, for a tenth of its budget
    :param advance: called after each part of what is being measured
    :return: figures by name, the unit in the name
    """
    th.set_num_threads(1)
    scenario = PRESETS["paper"]
    figures = {"simulator_agent_steps_per_s": _simulator_speed(scenario, 1024, advance)}
    many, single = make_vec_env(scenario, 64, seed=0), make_vec_env(scenario, 1, copies=64, seed=0)
    together, apart = _paired_step_seconds(many, single, advance)
    figures["vec_step_one_64_game_env_ms"] = together * 1e3
    figures["vec_step_64_one_game_envs_ms"] = apart * 1e3
    figures["vec_step_ratio"] = apart / together
    for name, game in PRESETS.items():
        mean, longest = _response_seconds(game, 25, advance)
        figures[f"best_response_{name}_ms"] = mean * 1e3
        figures[f"best_response_{name}_longest_ms"] = longest * 1e3
    figures["welfare_ascent_200_episodes_s"] = _ascent_seconds(scenario, 200, advance)
    seconds = _training_seconds(scenario, method, method.env_steps // 10, advance)
    figures["training_env_steps_per_s"] = method.env_steps / 10 / seconds
    figures["training_seconds_for_whole_budget"] = 10 * seconds
    return figures


def _simulator_speed(scenario: Scenario, num_games: int, advance: Advance, seconds: float = 2.0) -> float:
    """Agent steps per second of the bare simulator under random play, measured for some seconds."""
    simulator = Simulator(scenario, num_games, seed=0)
    actions = np.random.default_rng(0).integers(0, simulator.num_actions, (64, num_games, scenario.num_uavs))
    simulator.step(actions[0])
    simulator.go_on()
    steps, start = 0, time.perf_counter()
    for part in range(PARTS):
        while time.perf_counter() - start < (part + 1) * seconds / PARTS:
            simulator.step(actions[steps % len(actions)])
            simulator.go_on()
            steps += 1
        advance(f"simulator, {num_games:,} games of {scenario.num_uavs} UAVs", PARTS)
    return steps * num_games * scenario.num_uavs / (time.perf_counter() - start)


def _paired_step_seconds(
    first: VecEnv, second: VecEnv, advance: Advance, rounds: int = 30, steps: int = 5
) -> tuple[float, float]:
    """Median seconds that a vector step takes of two environments of as many slots, measured in turn."""
    rng = np.random.default_rng(0)
    num_actions = int(first.action_space.n)  # type: ignore[attr-defined]
    durations: list[list[float]] = [[], []]
    for env in (first, second):
        env.reset()
    for _ in range(rounds):
        actions = rng.integers(0, num_actions, first.num_envs)
        for env, own in zip((first, second), durations, strict=True):
            start = time.perf_counter()
            for _ in range(steps):
                env.step(actions)
            own.append((time.perf_counter() - start) / steps)
        advance("vector environment, 64 games in one against 64 environments of one", rounds)
    return float(np.median(durations[0])), float(np.median(durations[1]))


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


def _training_seconds(scenario: Scenario, method: Method, env_steps: int, advance: Advance) -> float:
    """Duration of a short training, without evaluation and logging."""
    model = build_model(Cell("bench", method, 0, scenario, Evaluation(), Path()))
    done = 0

    def tell(local: dict[str, Any], _: object) -> bool:
        nonlocal done
        reached = PARTS * local["self"].num_timesteps // (env_steps * scenario.num_uavs)
        for _part in range(done, min(reached, PARTS)):
            advance(f"training, {env_steps:,} env steps", PARTS)
        done = max(done, reached)
        return True

    start = time.perf_counter()
    model.learn(env_steps * scenario.num_uavs, callback=tell)
    return time.perf_counter() - start
