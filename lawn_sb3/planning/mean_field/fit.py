"""How the tables of the mean-field planner are fitted: the planner flies by its own tables, round after round.

In every slot of every flight we record what the UAV saw, and what each cell was like in each later slot of the flight:
the RB share it would have had there, and what its presence there would have cost the others. The new tables make the
UAVs fly differently, which changes the tables again. When neither changes any more, everybody's expectations come true:
a fixed point. There may be several, and none is proven to be the best that can be done with what a UAV knows.
"""

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
from lawn_sb3.planning.mean_field.expected_flight import expected_flight
from lawn_sb3.planning.mean_field.sight import Senses, bucket, images, keys_of, look
from lawn_sb3.planning.mean_field.tables import (
    Tables,
    add_row,
    average,
    cell_row,
    empty_tables,
    fade,
    find_finest,
)
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
OnRound = Callable[[int, int], None]
"""Called after each round with the rounds done and all rounds."""

KEPT = 0.8
"""How much of what was seen in earlier rounds still counts in the next."""
MOST_EPISODES = 6_000
MOST_WORK = 1e6
"""UAVs times episodes times squared flight time of a round: flights in a large airspace are long, and each slot costs
more."""


class Fit(NamedTuple):
    """How tables are fitted."""

    senses: Senses
    slack: int
    seed: int
    rounds: int
    episodes: int | None
    """Episodes per round; by default as many as a scenario allows in reasonable time."""


class _Slot(NamedTuple):
    """What one slot of all games gave."""

    cell: Ints  # [G, N] where each UAV took RBs; -1 for nowhere
    voxel_mbps: Floats  # [G, N] rate over one RB there; 0 for a UAV that does not fly


def fit_tables(scenario: Scenario, fit: Fit, on_round: OnRound | None = None) -> Tables:
    """Fly the planner by its own tables, round after round.

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
        average(rules, tables)
        if on_round is not None:
            on_round(done + 1, fit.rounds)
    return tables


def longest_mission(scenario: Scenario) -> int:
    """The least flight time between opposite corners of the airspace, in slots."""
    width, length, layers = scenario.grid
    return max(min_slots((0, 0, 0), (width - 1, length - 1, layers - 1), scenario.max_voxel_steps), 1)


def _play_round(simulator: Simulator, tables: Tables, fit: Fit, same: Ints) -> None:
    rules = simulator.rules
    seen: list[State] = []
    gave: list[_Slot] = []
    arrived = np.zeros_like(simulator.state.flying)
    while simulator.state.flying.any():
        seen.append(copy.deepcopy(simulator.state))
        actions = first_moves(rules, simulator.state, tables, fit.senses, fit.slack)
        arrived |= simulator.step(actions).arrived
        x, y, z = np.moveaxis(simulator.state.position, -1, 0)
        flew = seen[-1].flying
        cell = np.where(flew | rules.arrived_stays, rules.cell[x, y, z], -1)
        gave.append(_Slot(cell, np.where(flew, rules.rb_rate_mbps[x, y, z], 0.0)))
    cells, voxel_mbps = (np.array(parts) for parts in zip(*gave, strict=True))  # [T, G, N]
    gains = voxel_mbps * _weights(rules, simulator.state, arrived, len(gave))
    for t, state in enumerate(seen):
        _record_slot(rules, state, simulator.state.slot, t, cells, gains, tables, fit.senses, same)


@njit
def _weights(rules: Rules, state: State, arrived: NDArray[np.bool_], num_slots: int) -> Floats:
    """How much the rate of every slot counts in the utility of each UAV, now that all are done [T, G, N]."""
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
def _record_slot(
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
    """Record what every flying UAV saw, and what each cell was like in the later slots of its flight.

    :param state: the state of all games after t slots
    :param flown: slots that each UAV flew in all [G, N]
    :param t: slots flown so far
    :param cells: where each UAV took RBs in each slot; -1 for nowhere [T, G, N]
    :param gains: utility that each UAV had from each RB in each slot in Mbps [T, G, N]
    :param tables: the tables; written
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
                                _add(tables.rows.sums, tables.rows.counts, int(row), k, b, share, loss_mbps)
                        _add(tables.cells.sums, tables.cells.counts, int(alone[b]), k, 0, share, loss_mbps)
                        _add(tables.overall.sums, tables.overall.counts, 0, k, b, share, loss_mbps)


@njit
def _join_each(rules: Rules, cell: Ints, gain_mbps: Floats, uav: int, outcome: Floats) -> None:
    """What one UAV would have had in each cell in one slot, and what that would have cost the others.

    :param cell: where each UAV takes RBs; -1 for nowhere [N]
    :param gain_mbps: utility that each has from each RB [N]
    :param uav: the UAV; it does not count itself
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
def _add(sums: Floats, counts: Floats, row: int, k: int, b: int, share: float, loss_mbps: float) -> None:
    sums[row, k, b, 0] += share
    sums[row, k, b, 1] += loss_mbps
    counts[row, k, b] += 1.0


@njit
def first_moves(rules: Rules, state: State, tables: Tables, senses: Senses, slack: int) -> Ints:
    """The first moves if every UAV plans by what it sees and what the tables expect then [G, N]."""
    num_games, num_uavs = state.flying.shape
    num_gbs = len(rules.num_rbs)
    actions = np.zeros((num_games, num_uavs), dtype=np.int64)
    sight = np.zeros((1 + senses.destinations + senses.memory, num_gbs), dtype=np.int64)
    image = np.arange(num_gbs)
    peak_mbps = peak_rate_mbps(rules)
    room = np.empty(2 * rules.grid[0] * rules.grid[1] * rules.grid[2])
    strange = np.empty(tables.overall.means.shape[1:])  # [K, M, 2]
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
