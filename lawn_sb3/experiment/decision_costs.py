"""What a decision costs among ever more UAVs: time, and memory; each game is flown in a process of its own."""

import multiprocessing
import time

import numpy as np
import pandas as pd
import torch as th

from lawn_sb3.experiment.benchmark.clock import peak_of_this_process_mb
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluation_games
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.recipe import Scaling


def decision_costs(cell: Cell, scaling: Scaling) -> pd.DataFrame:
    """Fly one game with each number of UAVs, and measure what the player takes for it.

    :param cell: the cell of a finished run
    :param scaling: what to fly
    :return: one row per N: milliseconds that the player takes for one move of one UAV, all that it plans before the
        first one included, but not what it learns or fits once; and the peak memory of the process in MB
    """
    rows = []
    for num_uavs in scaling.flown_by(cell.key):
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            milliseconds, memory_mb = pool.apply(_fly_one, (cell, scaling, num_uavs))
        rows.append({"num_uavs": num_uavs, "decision_ms": milliseconds, "memory_mb": memory_mb})
    return pd.DataFrame(rows)


def _fly_one(cell: Cell, scaling: Scaling, num_uavs: int) -> tuple[float, float]:
    th.set_num_threads(1)
    game = scaling.game(cell.scenario, num_uavs)
    player = load_player(cell, cell.evaluation.deterministic, game)
    rng = np.random.default_rng(cell.seed)
    warm_up = evaluation_games(game, 1, cell.evaluation.seed)
    player.start(warm_up, rng)  # compiles, and fits once what is fitted
    player.act(warm_up)
    games, decisions = evaluation_games(game, 1, cell.evaluation.seed), 0
    began = time.perf_counter()
    player.start(games, rng)
    seconds = time.perf_counter() - began
    while games.state.flying.any():
        decisions += int(games.state.flying.sum())
        began = time.perf_counter()
        actions = player.act(games)
        seconds += time.perf_counter() - began
        games.step(actions)
    return 1e3 * seconds / decisions, peak_of_this_process_mb()
