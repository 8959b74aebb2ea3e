"""How the tables of the mean-field planner are fitted: the planner is flown by its own tables, round after round.

In every slot of every flight it is noted what the UAV saw, and what each cell was like in each slot that it then flew
on: the RB share it would have had there, and what its being there would have cost the others. The tables that come of
it make the UAVs fly otherwise, which changes the tables. Where neither changes any more, everybody's expectations come
true: a fixed point. There may be several, and none is proven to be the best that can be done with what a UAV knows.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.airspace import min_slots
from lawn_sb3.game.compiled import njit
from lawn_sb3.game.payoff import slot_weight
from lawn_sb3.game.radio import achievable_rate_mbps, rb_share
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.game.state import Rules, State, bias_horizon
from lawn_sb3.planning.flight import peak_rate_mbps
from lawn_sb3.planning.mean_field_flight import expected_flight
from lawn_sb3.planning.mean_field_sight import Senses, bucket, images, keys_of, look
from lawn_sb3.planning.mean_field_tables import (
    Tables,
    add_row,
    cell_row,
    empty_tables,
    fade,
    find_finest,
    settle,
)
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
OnRound = Callable[[int, int], None]
"""Called after each round with the rounds done and all rounds."""

KEPT = 0.8
"""The part of what was seen in earlier rounds that counts on in the next."""
MOST_EPISODES = 6_000
MOST_WORK = 1e6
"""Slots of all flights of a round, squared: flights are long where the airspace is large, and each slot costs more."""


class Fit(NamedTuple):
    """How tables are fitted."""

    senses: Senses
    slack: int
    seed: int
    rounds: int
    episodes: int | None
    """Episodes a round; without a number, as many as a scenario allows in reasonable time."""


class _Slot(NamedTuple):
    """What came of one slot of all games."""

    cell: Ints  # [G, N] where each UAV took RBs; -1 for none
    voxel_mbps: Floats  # [G, N] rate over one RB there; 0 for a UAV that does not fly


def fit_tables(scenario: Scenario, fit: Fit, on_round: OnRound | None = None) -> Tables:
    """Fly the planner by its own tables, until they agree with what comes of it.

    :param scenario: the game
    :param fit: how
    :param on_round: called after each round
    :return: the tables
    """
    seed = np.random.SeedSequence([fit.seed, scenario.num_uavs, scenario.num_voxels])
    longest = longest_mission(scenario)
    episodes = fit.episodes or int(np.clip(MOST_WORK / (scenario.num_uavs * longest**2), 50, MOST_EPISODES))
    simulator = Simulator(scenario, episodes, seed, continuation="episode")
    rules = simulator.rules
    tables = empty_tables(rules, scenario.num_uavs, fit.senses, min(longest + fit.slack, scenario.max_slots))
    same = images(rules)
    for done in range(fit.rounds):
        if done:
            simulator.reset()
            fade(tables, KEPT)
        _play_round(simulator, tables, fit, same)
        settle(rules, tables)
        if on_round is not None:
            on_round(done + 1, fit.rounds)
    return tables


def longest_mission(scenario: Scenario) -> int:
    """The least flight time between opposite corners of the airspace.

    :param scenario: the game
    :return: slots
    """
    width, length, layers = scenario.grid
    return max(min_slots((0, 0, 0), (width - 1, length - 1, layers - 1), scenario.max_voxel_steps), 1)


def _play_round(simulator: Simulator, tables: Tables, fit: Fit, same: Ints) -> None:
    rules = simulator.rules
    seen: list[State] = []
    came: list[_Slot] = []
    arrived = np.zeros_like(simulator.state.flying)
    while simulator.state.flying.any():
        seen.append(copy.deepcopy(simulator.state))
        actions = first_moves(rules, simulator.state, tables, fit.senses, fit.slack)
        arrived |= simulator.step(actions).arrived
        x, y, z = np.moveaxis(simulator.state.position, -1, 0)
        flew = seen[-1].flying
        cell = np.where(flew | rules.arrived_stays, rules.cell[x, y, z], -1)
        came.append(_Slot(cell, np.where(flew, rules.rb_rate_mbps[x, y, z], 0.0)))
    cells, voxel_mbps = (np.array(parts) for parts in zip(*came, strict=True))  # [T, G, N]
    gains = voxel_mbps * _weights(rules, simulator.state, arrived, len(came))
    for t, state in enumerate(seen):
        _note_slot(rules, state, simulator.state.slot, t, cells, gains, tables, fit.senses, same)


@njit
def _weights(rules: Rules, state: State, arrived: NDArray[np.bool_], num_slots: int) -> Floats:
    """What the rate of every slot counts in the utility of each UAV, now that all are done [T, G, N]."""
    num_games, num_uavs = arrived.shape
    weights = np.zeros((num_slots, num_games, num_uavs))
    for g in range(num_games):
        for i in range(num_uavs):
            if arrived[g, i]:
                flown, least = state.slot[g, i], state.min_slots[g, i]
                horizon = bias_horizon(rules, flown)
                for t in range(flown):
                    weights[t, g, i] = slot_weight(rules.ema_beta, flown - t - 1, least, flown, horizon)
    return weights


@njit
def _note_slot(
    rules: Rules,
    state: State,
    flown: Ints,
    t: int,
    cells: Ints,
    gains: Floats,
    tables: Tables,
    senses: Senses,
    same: Ints,
) -> None:
    """Note for every UAV that flies what it saw, and what each cell was like in the slots that it flew on.

    :param rules: the game's constants
    :param state: the state of all games after t slots
    :param flown: slots that each UAV flew in all [G, N]
    :param t: slots flown so far
    :param cells: where each UAV took RBs in each slot; -1 for none [T, G, N]
    :param gains: utility that each UAV had of each RB in each slot in Mbps [T, G, N]
    :param tables: the tables; written
    :param senses: what a UAV knows
    :param same: how cells may change places [P, M]
    """
    num_gbs = len(rules.num_rbs)
    sight = np.zeros((1 + senses.destinations + senses.memory, num_gbs), dtype=np.int64)
    outcome = np.zeros((cells.shape[0] + 1, num_gbs, 2))
    rows = np.zeros(3, dtype=np.int64)
    alone = np.zeros(num_gbs, dtype=np.int64)
    for g in range(state.flying.shape[0]):
        for i in range(state.flying.shape[1]):
            if not state.flying[g, i]:
                continue
            own = look(rules, state, g, i, senses, sight)
            total = sight[0].sum()
            left = flown[g, i] - t
            for s in range(1, left + 1):
                _join_each(rules, cells[t + s - 1, g], gains[t + s - 1, g], i, outcome[s])
            for image in same:
                keys = keys_of(own, sight, t, image)
                rows[0] = add_row(tables, keys.loads, -1)
                rows[1] = add_row(tables, keys.rows, rows[0])
                rows[2] = add_row(tables, keys.clock, rows[1])
                for b in range(num_gbs):
                    alone[b] = cell_row(b, own, sight, image[b], total, tables.told_apart)
                    if rows[0] >= 0:
                        tables.parent_cells[rows[0], b] = alone[b]
                for s in range(1, left + 1):
                    k = bucket(s)
                    for b in range(num_gbs):
                        share, loss_mbps = outcome[s, image[b], 0], outcome[s, image[b], 1]
                        for level in range(len(rows)):
                            row = int(rows[level])
                            if row >= 0:
                                _note(tables.rows.sums, tables.rows.counts, int(row), k, b, share, loss_mbps)
                        _note(tables.cells.sums, tables.cells.counts, int(alone[b]), k, 0, share, loss_mbps)
                        _note(tables.anyhow.sums, tables.anyhow.counts, 0, k, b, share, loss_mbps)


@njit
def _join_each(rules: Rules, cell: Ints, gain_mbps: Floats, uav: int, outcome: Floats) -> None:
    """What one UAV would have had in each cell in one slot, and what that would have cost the others.

    :param rules: the game's constants
    :param cell: where each UAV takes RBs; -1 for none [N]
    :param gain_mbps: utility that each has of each RB [N]
    :param uav: the UAV, which does not count
    :param outcome: RB share, and loss in Mbps [M, 2]; written
    """
    for b in range(len(outcome)):
        others, per_rb_mbps = 0, 0.0
        for j in range(len(cell)):
            if j != uav and cell[j] == b:
                others += 1
                per_rb_mbps += gain_mbps[j]
        share = rb_share(rules.num_rbs[b], others + 1)
        outcome[b, 0], outcome[b, 1] = share, 0.0
        if others:
            outcome[b, 1] = achievable_rate_mbps(rb_share(rules.num_rbs[b], others) - share, per_rb_mbps)


@njit
def _note(sums: Floats, counts: Floats, row: int, k: int, b: int, share: float, loss_mbps: float) -> None:
    sums[row, k, b, 0] += share
    sums[row, k, b, 1] += loss_mbps
    counts[row, k, b] += 1.0


@njit
def first_moves(rules: Rules, state: State, tables: Tables, senses: Senses, slack: int) -> Ints:
    """Let every UAV plan by what it sees and the tables say, and take the first moves.

    :param rules: the game's constants
    :param state: the state of all games
    :param tables: what to expect
    :param senses: what a UAV knows
    :param slack: slots beyond T_i^min that a flight may take
    :return: indices into the action table [G, N]
    """
    num_games, num_uavs = state.flying.shape
    num_gbs = len(rules.num_rbs)
    actions = np.zeros((num_games, num_uavs), dtype=np.int64)
    sight = np.zeros((1 + senses.destinations + senses.memory, num_gbs), dtype=np.int64)
    image = np.arange(num_gbs)
    peak_mbps = peak_rate_mbps(rules)
    room = np.empty(2 * rules.grid[0] * rules.grid[1] * rules.grid[2])
    strange = np.empty(tables.anyhow.means.shape[1:])  # [K, M, 2]
    for g in range(num_games):
        for i in range(num_uavs):
            if not state.flying[g, i]:
                continue
            own = look(rules, state, g, i, senses, sight)
            row = find_finest(tables, keys_of(own, sight, state.slot[g, i], image))
            if row >= 0:
                outlook = tables.rows.means[row]
            else:
                for b in range(num_gbs):
                    alone = cell_row(b, own, sight, b, sight[0].sum(), tables.told_apart)
                    strange[:, b] = tables.cells.means[alone, :, 0]
                outlook = strange
            actions[g, i] = expected_flight(rules, state, g, i, outlook, slack, peak_mbps, room).action
    return actions
