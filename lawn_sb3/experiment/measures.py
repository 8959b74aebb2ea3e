"""What an evaluation's rows come to: mean figures, and what each UAV could have gained by deviating alone."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.experiment.evaluation import Flights, evaluation_games
from lawn_sb3.game.payoff import welfare
from lawn_sb3.planning.best_response import best_responses
from lawn_sb3.planning.plan import Plan
from lawn_sb3.scenario import Scenario

EQUILIBRIUM_MBPS = 1e-6
"""Regret up to which a UAV counts as having nothing to gain; files keep nine digits."""


def summarize(rows: pd.DataFrame) -> dict[str, float]:
    """Mean figures of one evaluation.

    :param rows: what :func:`lawn_sb3.experiment.evaluation.evaluate` returned
    :return: means over UAVs (reward J, rate, completion, success, utility, collisions) and over episodes (makespan,
        welfare); ``run_directory.columns.scaling_columns`` gives each name its unit
    """
    games = rows.groupby("episode")
    utilities = rows["utility_mbps"].to_numpy().reshape(games.ngroups, -1)
    return {
        "reward": float(rows["reward"].mean()),
        "rate_mbps": float(rows["rate_mbps"].mean()),
        "makespan_slots": float(games["makespan_slots"].first().mean()),
        "completion_slots": float(rows["slots"].mean()),
        "success_percent": float(100.0 * rows["arrived"].mean()),
        "utility_mbps": float(rows["utility_mbps"].mean()),
        "welfare_mbps": float(welfare(utilities).mean()),
        "collisions": float(rows["collisions"].mean()),
    }


def standard_errors(rows: pd.DataFrame) -> dict[str, float]:
    """How far the means of :func:`summarize` may be off, by the spread of the episodes.

    The UAVs of an episode share cells, so that the unit is the episode: the figures of each, and the standard error of
    their mean. It says nothing of other seeds of a training.

    :param rows: what :func:`lawn_sb3.experiment.evaluation.evaluate` returned
    :return: standard errors, by the names of :func:`summarize`; NaN for a single episode
    """
    games = rows.assign(completion_slots=rows["slots"], success_percent=100.0 * rows["arrived"]).groupby("episode")
    each = games.mean().assign(welfare_mbps=games["utility_mbps"].sum())
    errors: pd.Series[float] = each.sem()
    return {name: float(errors[name]) for name in summarize(rows)}


def regrets(flights: Flights, scenario: Scenario, seed: int, on_game: Callable[[], None] | None = None) -> pd.DataFrame:
    """What each UAV could have had by deviating alone, the others keeping the trajectories that they flew.

    :param flights: an evaluation with all of its episodes traced
    :param scenario: the game
    :param seed: the seed of the evaluation
    :param on_game: called after each episode
    :return: one row per episode and UAV: the utility that it had, that of its best response, and the slots that the
        best response takes
    """
    rows = flights.rows
    shape = (rows["episode"].nunique(), scenario.num_uavs)
    simulator = evaluation_games(scenario, shape[0], seed)
    slots = np.array(rows["slots"], dtype=np.int64).reshape(shape)
    voxels = trajectories(flights, scenario)
    best_mbps, best_slots = np.zeros(shape), np.zeros(shape, dtype=np.int64)
    for game in range(shape[0]):
        plan = Plan(voxels[game], slots[game])
        best_mbps[game], best_slots[game] = best_responses(simulator.rules, simulator.state, game, plan)
        if on_game is not None:
            on_game()
    return rows[["episode", "uav", "utility_mbps"]].assign(best_mbps=best_mbps.ravel(), best_slots=best_slots.ravel())


def trajectories(flights: Flights, scenario: Scenario) -> NDArray[np.int64]:
    """Where all UAVs were in every slot.

    :param flights: an evaluation with all of its episodes traced
    :param scenario: the game
    :return: voxels from slot to slot [E, N, T_max + 1, 3]; who is done stays in the last one
    """
    paths = flights.paths
    num_games = flights.rows["episode"].nunique()
    voxels = np.zeros((num_games, scenario.num_uavs, scenario.max_slots + 1, 3), dtype=np.int64)
    last = np.zeros(voxels.shape[:3], dtype=np.int64)
    at = tuple(paths[name].to_numpy() for name in ("episode", "uav", "slot"))
    voxels[at] = paths[["x", "y", "z"]].to_numpy()
    last[at] = at[2]
    last = np.maximum.accumulate(last, axis=2)
    return np.take_along_axis(voxels, last[..., None], axis=2)


def summarize_regrets(rows: pd.DataFrame, flown: pd.DataFrame) -> dict[str, float]:
    """Mean figures of the regrets of one evaluation.

    :param rows: what :func:`regrets` returned
    :param flown: the evaluation's rows
    :return: mean regret of a UAV, and the Nash gap: the largest regret of an episode's UAVs, mean and maximum over
        the episodes, all in Mbps; and the share of the episodes that are an equilibrium, in which nobody collides
    """
    regret = (rows["best_mbps"] - rows["utility_mbps"]).clip(lower=0.0)
    largest = regret.groupby(rows["episode"]).max()
    collisions = flown.groupby("episode")["collisions"].sum()
    return {
        "regret_mbps": float(regret.mean()),
        "nash_gap_mbps": float(largest.mean()),
        "largest_regret_mbps": float(largest.max()),
        "equilibria_percent": float(100.0 * ((largest <= EQUILIBRIUM_MBPS) & (collisions == 0)).mean()),
    }
