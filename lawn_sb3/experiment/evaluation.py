"""Evaluation: one player flies some joint episodes on missions fixed by a seed; one raw row per episode and UAV."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.run_directory.columns import evaluation_columns, paths_columns, slots_columns
from lawn_sb3.game.airspace import Missions, draw_missions
from lawn_sb3.game.player import Player
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.game.state import Outcome
from lawn_sb3.planning.plan import check_in_time
from lawn_sb3.scenario import Scenario


class Flights(NamedTuple):
    """What an evaluation saw; ``run_directory.files`` has the columns of all three tables."""

    rows: pd.DataFrame
    """One row per episode and UAV."""
    slots: pd.DataFrame
    """One row per slot: means over all episodes."""
    paths: pd.DataFrame
    """One row per slot and UAV of the traced episodes; slot 0 is the origin."""


def evaluate(player: Player, scenario: Scenario, episodes: int, seed: int, player_seed: int = 0) -> pd.DataFrame:
    """Let a player play some episodes: the rows that :func:`fly` gives, and its arguments."""
    return fly(player, scenario, episodes, seed, player_seed).rows


def fly(player: Player, scenario: Scenario, episodes: int, seed: int, player_seed: int = 0, traced: int = 0) -> Flights:
    """Let a player play some episodes side by side; keep how the cells filled and where the first ones' UAVs went.

    :param player: the player
    :param scenario: the game
    :param episodes: number of joint episodes E
    :param seed: picks the missions: the same seed gives every player the same ones
    :param player_seed: seed of the player's own randomness
    :param traced: the number of episodes whose paths are kept
    :return: E * N raw rows, slots and paths
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
        slots.append([len(slots) + 1, *_occupancy(outcome, flying, scenario)])
        paths.append(_positions(_by_episode(simulator.state.position, shape), outcome, flying, len(slots), traced))
    clock = _by_episode(simulator.state.slot, shape)
    episode, uav = np.indices(shape)
    makespan = np.broadcast_to(clock.max(axis=1, keepdims=True), shape)
    least = _by_episode(simulator.state.min_slots, shape)
    values = (episode, uav, reward, rate, clock, least, arrived, gained, collisions, makespan, load / clock)
    return Flights(
        _table(evaluation_columns(scenario, episodes), values),
        pd.DataFrame(slots, columns=list(slots_columns(scenario, len(slots)))),
        _table(paths_columns(scenario, traced), map(np.concatenate, zip(*paths, strict=True))),
    )


def flies_alone(player: Player) -> bool:
    """Whether a player gives every UAV a game of its own: what it earns bounds what others can, nobody can fly it."""
    return bool(getattr(player, "flies_alone", False))


def evaluation_games(scenario: Scenario, episodes: int, seed: int, alone: bool = False) -> Simulator:
    """The games of an evaluation, at their first slot.

    :param scenario: the game
    :param episodes: number of joint episodes E
    :param seed: picks the missions
    :param alone: give every UAV a game of its own: E * N games, those of an episode's UAVs in a row
    :return: the games
    """
    missions = evaluation_missions(scenario, episodes, seed)
    if alone:
        scenario = scenario.changed(num_uavs=1)
        missions = Missions(*(voxels.reshape(-1, 1, 3) for voxels in missions))
    simulator = Simulator(scenario, len(missions.origins), seed=0, continuation="episode")
    simulator.reset(missions=missions)
    return simulator


def evaluation_missions(scenario: Scenario, episodes: int, seed: int) -> Missions:
    """The missions of an evaluation's E episodes, the same for every player, in voxels [E, N, 3]."""
    return draw_missions(scenario, episodes, np.random.default_rng(seed))


def _by_episode(values: NDArray[Any], shape: tuple[int, int]) -> NDArray[Any]:
    """Values of all UAVs [G, N, ...] by episode [E, N, ...], also where every UAV had a game of its own."""
    return values.reshape(*shape, *values.shape[2:])


def _table(names: Iterable[str], values: Iterable[NDArray[Any]]) -> pd.DataFrame:
    """One column per array, all of the same shape."""
    return pd.DataFrame({name: value.ravel() for name, value in zip(names, values, strict=True)})


def _occupancy(outcome: Outcome, flying: NDArray[np.bool_], scenario: Scenario) -> list[float]:
    """UAVs in each cell, and UAVs that share their cell with 0, 1, 2... others: means over the episodes."""
    in_cell = np.bincount(outcome.cell[flying], minlength=scenario.num_gbs)
    sharing = np.bincount(outcome.cell_load[flying], minlength=scenario.num_uavs + 1)[1:]
    return [float(count) / len(flying) for count in (*in_cell, *sharing)]


def _origins(simulator: Simulator, shape: tuple[int, int], traced: int) -> list[NDArray[Any]]:
    """Columns of the paths at slot 0."""
    x, y, z = np.moveaxis(simulator.state.position, -1, 0)
    cell = simulator.rules.cell[x, y, z]
    load = np.take_along_axis(simulator.state.cell_load, cell, axis=1)
    seen = [_by_episode(values, shape)[:traced] for values in (x, y, z, cell, load)]
    index = np.indices(seen[0].shape)
    columns: list[NDArray[Any]] = [*index, np.zeros_like(index[0]), *seen, np.zeros(seen[0].shape)]
    return [column.ravel() for column in columns]


def _positions(
    position: NDArray[np.int64], outcome: Outcome, flying: NDArray[np.bool_], slot: int, traced: int
) -> list[NDArray[Any]]:
    """Columns of the paths after a slot, for the UAVs that flew in it."""
    episode, uav = np.nonzero(flying[:traced])
    x, y, z = np.moveaxis(position[episode, uav], -1, 0)
    own = (values[episode, uav] for values in (outcome.cell, outcome.cell_load, outcome.rate_mbps))
    return [episode, uav, np.full_like(episode, slot), x, y, z, *own]
