"""Evaluation: one player, some joint episodes on missions fixed by a seed, one raw row an episode and UAV."""

from __future__ import annotations

import numpy as np
import pandas as pd

from lawn_sb3.errors import UserError
from lawn_sb3.game.airspace import draw_missions
from lawn_sb3.game.payoff import welfare
from lawn_sb3.game.player import Player
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.scenario import Scenario

COLUMNS = (
    "episode",
    "uav",
    "reward",
    "rate_mbps",
    "slots",
    "min_slots",
    "arrived",
    "utility_mbps",
    "collisions",
    "makespan_slots",
)


def evaluate(player: Player, scenario: Scenario, episodes: int, seed: int, player_seed: int = 0) -> pd.DataFrame:
    """Let a player play some episodes, all advanced together.

    :param player: the player
    :param scenario: the game
    :param episodes: number of joint episodes E
    :param seed: picks the missions: the same seed gives every player the same ones
    :param player_seed: seed of the player's own randomness
    :return: E * N rows: episode, UAV, accumulated reward J, corrected rate in Mbps, slots T_i, T_i^min, arrived,
        utility U_i in Mbps (0 for a failed mission), collisions, and the episode's makespan in slots
    :raises UserError: if ``episodes`` is below 1
    """
    if episodes < 1:
        raise UserError(f"episodes = {episodes}: at least 1 episode")
    missions = draw_missions(scenario, episodes, np.random.default_rng(seed))
    simulator = Simulator(scenario, episodes, seed=0, continuation="episode")
    simulator.reset(missions=missions)
    player.start(simulator, np.random.default_rng([seed, player_seed]))
    shape = (episodes, scenario.num_uavs)
    reward, rate, gained = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    collisions, arrived = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=bool)
    while simulator.state.flying.any():
        outcome = simulator.step(player.act(simulator))
        done = outcome.arrived | outcome.timed_out
        reward += outcome.reward_terms.sum(axis=-1)
        collisions += outcome.collided
        rate[done] = outcome.corrected_rate_mbps[done]
        gained += outcome.utility_mbps
        arrived |= outcome.arrived
    slots = simulator.state.slot
    episode, uav = np.indices(shape)
    makespan = np.broadcast_to(slots.max(axis=1, keepdims=True), shape)
    values = (episode, uav, reward, rate, slots, simulator.state.min_slots, arrived, gained, collisions, makespan)
    return pd.DataFrame({name: value.ravel() for name, value in zip(COLUMNS, values, strict=True)})


def summarize(rows: pd.DataFrame) -> dict[str, float]:
    """Mean figures of one evaluation.

    :param rows: what :func:`evaluate` returned
    :return: reward J, corrected rate and utility a UAV, completion (slots a UAV), makespan and welfare an episode,
        success in percent, collisions a UAV
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
