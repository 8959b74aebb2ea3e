"""Evaluation: one player, some joint episodes on missions fixed by a seed, one raw row an episode and UAV."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.errors import UserError
from lawn_sb3.game.airspace import Missions, draw_missions
from lawn_sb3.game.payoff import welfare
from lawn_sb3.game.player import Player
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.game.state import Outcome
from lawn_sb3.planning.plan import check_in_time
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
    "mean_cell_load",
)

PATH_COLUMNS = ("episode", "uav", "slot", "x", "y", "z", "cell", "cell_load", "rate_mbps")


class Flights(NamedTuple):
    """What an evaluation saw."""

    rows: pd.DataFrame
    """One row an episode and UAV, with the columns ``COLUMNS``."""
    slots: pd.DataFrame
    """One row a slot, means over all episodes: UAVs flying in the cell of each GBS (``gbs_B``), and UAVs flying in a
    cell with K UAVs (``load_K``)."""
    paths: pd.DataFrame
    """One row a slot and UAV of the traced episodes, with the columns ``PATH_COLUMNS``; slot 0 is the origin."""


def evaluate(player: Player, scenario: Scenario, episodes: int, seed: int, player_seed: int = 0) -> pd.DataFrame:
    """Let a player play some episodes, all advanced together.

    :param player: the player
    :param scenario: the game
    :param episodes: number of joint episodes E
    :param seed: picks the missions: the same seed gives every player the same ones
    :param player_seed: seed of the player's own randomness
    :return: E * N rows: episode, UAV, accumulated reward J, corrected rate in Mbps, slots T_i, T_i^min, arrived,
        utility U_i in Mbps (0 for a failed mission), collisions, the episode's makespan in slots, and the load of the
        UAV's own cell (itself included), mean over its slots
    :raises UserError: if ``episodes`` is below 1
    """
    return fly(player, scenario, episodes, seed, player_seed).rows


def fly(player: Player, scenario: Scenario, episodes: int, seed: int, player_seed: int = 0, traced: int = 0) -> Flights:
    """Let a player play some episodes, and keep how the cells filled and where the UAVs of the first ones went.

    :param player: the player
    :param scenario: the game
    :param episodes: number of joint episodes E
    :param seed: picks the missions: the same seed gives every player the same ones
    :param player_seed: seed of the player's own randomness
    :param traced: the number of episodes whose paths are kept
    :return: raw rows as :func:`evaluate` gives them, slots and paths
    :raises UserError: if ``episodes`` is below 1, or a player that plans cannot be in time
    """
    if episodes < 1:
        raise UserError(f"episodes = {episodes}: at least 1 episode")
    simulator = evaluation_games(scenario, episodes, seed)
    if flies_alone(player):
        check_in_time(simulator.rules, simulator.state)  # here, where the indices are those of the episode's UAVs
        simulator = evaluation_games(scenario, episodes, seed, alone=True)
    player.start(simulator, np.random.default_rng([seed, player_seed]))
    shape = (episodes, scenario.num_uavs)
    reward, rate, gained, load = np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros(shape)
    collisions, arrived = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=bool)
    slots: list[list[float]] = []
    paths = [_origins(simulator, shape, traced)]
    while simulator.state.flying.any():
        flying = _by_episode(simulator.state.flying, shape).copy()
        outcome = Outcome(*(_by_episode(part, shape) for part in simulator.step(player.act(simulator))))
        done = outcome.arrived | outcome.timed_out
        reward += outcome.reward_terms.sum(axis=-1)
        collisions += outcome.collided
        rate[done] = outcome.corrected_rate_mbps[done]
        gained += outcome.utility_mbps
        arrived |= outcome.arrived
        load += outcome.cell_load
        slots.append(_occupancy(outcome, flying, scenario))
        paths.append(_positions(_by_episode(simulator.state.position, shape), outcome, flying, len(slots), traced))
    clock = _by_episode(simulator.state.slot, shape)
    episode, uav = np.indices(shape)
    makespan = np.broadcast_to(clock.max(axis=1, keepdims=True), shape)
    least = _by_episode(simulator.state.min_slots, shape)
    values = (episode, uav, reward, rate, clock, least, arrived, gained, collisions, makespan, load / clock)
    names = [*(f"gbs_{b}" for b in range(scenario.num_gbs)), *(f"load_{k + 1}" for k in range(scenario.num_uavs))]
    occupancy = pd.DataFrame(slots, columns=names)
    occupancy.insert(0, "slot", np.arange(1, len(slots) + 1))
    return Flights(
        pd.DataFrame({name: value.ravel() for name, value in zip(COLUMNS, values, strict=True)}),
        occupancy,
        pd.concat(paths, ignore_index=True),
    )


def flies_alone(player: Player) -> bool:
    """Whether a player gives every UAV a game of its own: what it earns bounds what others can, nobody can fly it.

    :param player: the player
    :return: true for a player with ``flies_alone = True``
    """
    return bool(getattr(player, "flies_alone", False))


def evaluation_games(scenario: Scenario, episodes: int, seed: int, alone: bool = False) -> Simulator:
    """The games of an evaluation, at their first slot.

    :param scenario: the game
    :param episodes: number of joint episodes E
    :param seed: picks the missions
    :param alone: give every UAV a game of its own: E * N games, those of an episode's UAVs in a row
    :return: the games
    """
    missions = draw_missions(scenario, episodes, np.random.default_rng(seed))
    if alone:
        scenario = scenario.changed(num_uavs=1)
        missions = Missions(*(voxels.reshape(-1, 1, 3) for voxels in missions))
    simulator = Simulator(scenario, len(missions.origins), seed=0, continuation="episode")
    simulator.reset(missions=missions)
    return simulator


def _by_episode(values: NDArray[Any], shape: tuple[int, int]) -> NDArray[Any]:
    """Values of all UAVs [G, N, ...] by episode [E, N, ...], also where every UAV had a game of its own."""
    return values.reshape(*shape, *values.shape[2:])


def _occupancy(outcome: Outcome, flying: NDArray[np.bool_], scenario: Scenario) -> list[float]:
    """UAVs in each cell, and UAVs that share their cell with 0, 1, 2... others: means over the episodes."""
    in_cell = np.bincount(outcome.cell[flying], minlength=scenario.num_gbs)
    sharing = np.bincount(outcome.cell_load[flying], minlength=scenario.num_uavs + 1)[1:]
    return [float(count) / len(flying) for count in (*in_cell, *sharing)]


def _origins(simulator: Simulator, shape: tuple[int, int], traced: int) -> pd.DataFrame:
    x, y, z = np.moveaxis(simulator.state.position, -1, 0)
    cell = simulator.rules.cell[x, y, z]
    load = np.take_along_axis(simulator.state.cell_load, cell, axis=1)
    seen = [_by_episode(values, shape)[:traced] for values in (x, y, z, cell, load)]
    episode, uav = np.indices((len(seen[0]), shape[1]))
    values = (episode, uav, np.zeros_like(episode), *seen, np.zeros(episode.shape))
    return pd.DataFrame({name: value.ravel() for name, value in zip(PATH_COLUMNS, values, strict=True)})


def _positions(
    position: NDArray[np.int64], outcome: Outcome, flying: NDArray[np.bool_], slot: int, traced: int
) -> pd.DataFrame:
    episode, uav = np.nonzero(flying[:traced])
    x, y, z = np.moveaxis(position[episode, uav], -1, 0)
    own = (values[episode, uav] for values in (outcome.cell, outcome.cell_load, outcome.rate_mbps))
    columns = (episode, uav, np.full_like(episode, slot), x, y, z, *own)
    return pd.DataFrame(dict(zip(PATH_COLUMNS, columns, strict=True)))


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
