"""Speed of the game: simulator against plain Python, how it grows, and one game as a PettingZoo environment."""

import importlib
import math
import sys
import time
from collections.abc import Callable

import numpy as np
import pandas as pd

from lawn_sb3.envs import LawnEnv
from lawn_sb3.experiment.benchmark.clock import calls_per_second, exponent
from lawn_sb3.experiment.plan_episodes import Advance
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.scenario import PRESETS, Scenario

PLAIN_GAME = REPOSITORY / "tests" / "game" / "plain_env.py"
"""The same game as a PettingZoo environment in plain Python; there is none beside an installed wheel."""
GROWN = {
    "UAVs and GBSs": [(4, 4), (16, 16), (64, 64), (256, 256), (1024, 1024), (4096, 4096)],
    "UAVs": [(4, 256), (16, 256), (64, 256), (256, 256), (1024, 256)],
    "GBSs": [(64, 4), (64, 16), (64, 64), (64, 256), (64, 1024)],
}
"""What grows: numbers of UAVs N and of GBSs M, on 25 voxel columns for each GBS, three levels high."""
SLOTS_AT_ONCE = 4096
"""UAVs of all games together: the larger a game, the fewer are played side by side."""


def crowded(num_uavs: int, num_gbs: int) -> Scenario:
    """The game ``paper`` with other numbers of UAVs and of GBSs (a square number), 25 voxel columns for each GBS."""
    side = math.isqrt(num_gbs)
    return PRESETS["paper"].changed(
        num_uavs=num_uavs, gbs_grid=(side, side), width_voxels=5 * side, length_voxels=5 * side
    )


def against_plain(num_games: int, seconds: float, advance: Advance) -> dict[str, float]:
    """Agent steps a second of the simulator, and of the plain environment where there is one, measured in turn."""
    scenario = PRESETS["paper"]
    jobs = [_random_play(scenario, num_games)]
    sizes = [num_games * scenario.num_uavs]
    if PLAIN_GAME.exists():
        jobs.append(_plain_play(scenario))
        sizes.append(scenario.num_uavs)
    speeds = [
        rate * size
        for rate, size in zip(calls_per_second(jobs, seconds, advance, "simulator, plain Python"), sizes, strict=True)
    ]
    figures = {"simulator_agent_steps_per_s": speeds[0]}
    if len(speeds) > 1:
        figures |= {"plain_pettingzoo_agent_steps_per_s": speeds[1], "simulator_ratio": speeds[0] / speeds[1]}
    return figures


def growth(largest: int, seconds: float, advance: Advance) -> pd.DataFrame:
    """How the simulator's cost grows.

    :param largest: the most UAVs or GBSs to try
    :param seconds: for each size
    :return: one row for each size: ``grows, num_uavs, num_gbs, num_games, build_s, bytes_per_voxel, agent_steps_per_s,
        exponent``, the last of the seconds that a slot of one game takes, as a power of what grows
    """
    rows = []
    for grows, all_sizes in GROWN.items():
        sizes = [size for size in all_sizes if max(size) <= largest]
        for num_uavs, num_gbs in sizes:
            num_games = max(1, SLOTS_AT_ONCE // num_uavs)
            rows.append((grows, num_uavs, num_gbs, num_games, *_speed(crowded(num_uavs, num_gbs), num_games, seconds)))
            advance("simulator as games grow", sum(max(size) <= largest for one in GROWN.values() for size in one))
    games = [1, 4, 16, 64, 256, 1024]
    for num_games in games:
        rows.append(("games", 4, 4, num_games, *_speed(PRESETS["paper"], num_games, seconds)))
        advance("simulator with more games", len(games))
    names = ["grows", "num_uavs", "num_gbs", "num_games", "build_s", "bytes_per_voxel", "agent_steps_per_s"]
    table = pd.DataFrame(rows, columns=names)
    table["exponent"] = np.nan
    for grows in table["grows"].unique():
        own = table[table["grows"] == grows]
        size = own["num_gbs"] if grows == "GBSs" else own["num_games"] if grows == "games" else own["num_uavs"]
        of_one = own["num_uavs"] / own["agent_steps_per_s"] * (own["num_games"] if grows == "games" else 1)
        table.loc[own.index, "exponent"] = exponent(size.tolist(), of_one.tolist())
    return table


def env_step_ms(num_uavs: int, seconds: float, advance: Advance) -> float:
    """Milliseconds of one step of ``LawnEnv`` among so many UAVs and as many GBSs, at most 256."""
    env = LawnEnv(crowded(num_uavs, min(num_uavs, 256)))
    rng = np.random.default_rng(0)

    def step() -> None:
        if not env.agents:
            env.reset(seed=0)
        env.step(dict(zip(env.agents, rng.integers(0, len(env.action_table), len(env.agents)).tolist(), strict=True)))

    (rate,) = calls_per_second([step], seconds, advance, f"LawnEnv.step, {num_uavs:,} UAVs")
    return 1e3 / rate


def large_game() -> None:
    """A slot of one game of 1,024 UAVs and as many GBSs, for its memory."""
    _random_play(crowded(1024, 1024), 1)()


def table_bytes(simulator: Simulator) -> int:
    """What the tables of the airspace take, which all games share; without the games themselves."""
    return sum(table.nbytes for table in simulator.rules if isinstance(table, np.ndarray))


def _speed(scenario: Scenario, num_games: int, seconds: float) -> tuple[float, float, float]:
    """Seconds to build the games, bytes of their tables for each voxel, and agent steps a second."""
    began = time.perf_counter()
    simulator = Simulator(scenario, num_games, seed=0)
    build = time.perf_counter() - began
    (rate,) = calls_per_second([_random_slots(simulator)], seconds, lambda what, parts: None, "")
    return build, table_bytes(simulator) / scenario.num_voxels, rate * num_games * scenario.num_uavs


def _random_play(scenario: Scenario, num_games: int) -> Callable[[], None]:
    """One slot of all games, at random."""
    return _random_slots(Simulator(scenario, num_games, seed=0))


def _random_slots(simulator: Simulator) -> Callable[[], None]:
    shape = 16, simulator.num_games, simulator.scenario.num_uavs
    actions = np.random.default_rng(0).integers(0, simulator.num_actions, shape)
    slots = iter(range(sys.maxsize))

    def play() -> None:
        simulator.step(actions[next(slots) % len(actions)])
        simulator.go_on()

    return play


def _plain_play(scenario: Scenario) -> Callable[[], None]:
    """One slot of one game of the plain environment, at random."""
    sys.path.append(str(REPOSITORY))  # where the tests are
    env = importlib.import_module("tests.game.plain_env").PlainLawnEnv(scenario)
    rng = np.random.default_rng(0)

    def play() -> None:
        if not env.agents:
            env.reset(seed=0)
        env.step({agent: int(rng.integers(len(env.moves))) for agent in env.agents})

    return play
