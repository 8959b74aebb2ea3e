"""One slot of many games as one compiled call, in the order: move, associate, share RBs, rate, payoff, retire.

Each phase loops over all games and takes its arrays out of the named tuples once: Numba counts a reference at every
such access, which inside the loops costs ten times the arithmetic.
"""

from __future__ import annotations

from typing import Literal, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.airspace import Voxel, action_table, distance, draw_mission, min_slots, move, stop_at
from lawn_sb3.game.compiled import njit
from lawn_sb3.game.payoff import corrected_rate, ema_rate, reward_col, reward_nav, reward_rate, reward_term, utility
from lawn_sb3.game.radio import achievable_rate_mbps, radio_map, rate_unit_mbps, rb_share
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

RewardTerm = Literal["rate", "nav", "col", "term"]
REWARD_TERMS: tuple[RewardTerm, ...] = get_args(RewardTerm)

MEMORY_SLOTS = 4
"""Slots whose cell loads a game remembers."""


class Rules(NamedTuple):
    """A scenario in the form the compiled step reads."""

    grid: tuple[int, int, int]
    actions: Ints  # [A, 3]
    max_voxel_steps: int
    max_slots: int
    cell: Ints  # [W, L, H]
    rb_rate_mbps: Floats  # [W, L, H]
    num_rbs: Ints  # [M]
    ema_beta: float
    nav_weight: float
    collision_penalty: float
    fail_penalty: float
    rate_unit_mbps: float
    clip_moves: bool
    arrived_stays: bool
    fly_through: bool
    correct_to_deadline: bool


class State(NamedTuple):
    """Everything a game remembers from slot to slot."""

    position: Ints  # [G, N, 3] voxels
    destination: Ints  # [G, N, 3] voxels
    min_slots: Ints  # [G, N]
    slot: Ints  # [G, N] slots flown in this mission
    ema_rate_mbps: Floats  # [G, N]
    flying: Bools  # [G, N]
    cell_load: Ints  # [G, M]
    past_load: Ints  # [G, MEMORY_SLOTS, M] cell loads seen in the slots before, newest first


class Outcome(NamedTuple):
    """What one slot gave each UAV; zero or false for a UAV that was not flying."""

    reward_terms: Floats  # [G, N, 4], in the order of REWARD_TERMS
    rate_mbps: Floats  # [G, N]
    cell: Ints  # [G, N]
    cell_load: Ints  # [G, N] UAVs in this UAV's cell
    num_rbs: Ints  # [G, N]
    corrected_rate_mbps: Floats  # [G, N]
    utility_mbps: Floats  # [G, N] nonzero only on arrival
    collided: Bools  # [G, N]
    arrived: Bools  # [G, N]
    timed_out: Bools  # [G, N]


def build_rules(scenario: Scenario) -> Rules:
    """Work out what the compiled step needs from a scenario.

    :param scenario: the scenario
    :return: its tables and constants
    """
    link = radio_map(scenario)
    return Rules(
        grid=scenario.grid,
        actions=action_table(scenario.max_voxel_steps),
        max_voxel_steps=scenario.max_voxel_steps,
        max_slots=scenario.max_slots,
        cell=link.cell,
        rb_rate_mbps=link.rb_rate_mbps,
        num_rbs=scenario.num_rbs,
        ema_beta=scenario.ema_beta,
        nav_weight=scenario.nav_weight,
        collision_penalty=scenario.collision_penalty,
        fail_penalty=scenario.fail_penalty,
        rate_unit_mbps=rate_unit_mbps(scenario),
        clip_moves=scenario.out_of_bounds == "clip",
        arrived_stays=scenario.arrived_uav == "stays",
        fly_through=scenario.arrival == "fly-through",
        correct_to_deadline=scenario.bias_horizon == "deadline",
    )


def empty_state(num_games: int, num_uavs: int, num_gbs: int) -> State:
    """Arrays for the state of some games, all zero.

    :param num_games: G
    :param num_uavs: N
    :param num_gbs: M
    :return: the state
    """
    shape = (num_games, num_uavs)
    return State(
        position=np.zeros((*shape, 3), dtype=np.int64),
        destination=np.zeros((*shape, 3), dtype=np.int64),
        min_slots=np.zeros(shape, dtype=np.int64),
        slot=np.zeros(shape, dtype=np.int64),
        ema_rate_mbps=np.zeros(shape),
        flying=np.zeros(shape, dtype=np.bool_),
        cell_load=np.zeros((num_games, num_gbs), dtype=np.int64),
        past_load=np.zeros((num_games, MEMORY_SLOTS, num_gbs), dtype=np.int64),
    )


def empty_outcome(num_games: int, num_uavs: int) -> Outcome:
    """Arrays for the outcome of a slot, all zero.

    :param num_games: G
    :param num_uavs: N
    :return: the outcome
    """
    shape = (num_games, num_uavs)
    floats, ints, bools = np.dtype(np.float64), np.dtype(np.int64), np.dtype(np.bool_)
    return Outcome(
        reward_terms=np.zeros((*shape, len(REWARD_TERMS))),
        rate_mbps=np.zeros(shape, floats),
        cell=np.zeros(shape, ints),
        cell_load=np.zeros(shape, ints),
        num_rbs=np.zeros(shape, ints),
        corrected_rate_mbps=np.zeros(shape, floats),
        utility_mbps=np.zeros(shape, floats),
        collided=np.zeros(shape, bools),
        arrived=np.zeros(shape, bools),
        timed_out=np.zeros(shape, bools),
    )


@njit
def voxel_of(voxels: Ints, game: int, uav: int) -> Voxel:
    """One voxel out of an array; three numbers cost less in compiled code than a view of the array.

    :param voxels: voxels of all UAVs [G, N, 3]
    :param game: index of the game
    :param uav: index of the UAV
    :return: the voxel
    """
    return voxels[game, uav, 0], voxels[game, uav, 1], voxels[game, uav, 2]


@njit
def bias_horizon(rules: Rules, slots: int) -> int:
    """Slots T-bar that the bias of the EMA rate is corrected for (reading ``bias_horizon``).

    :param rules: the game's constants
    :param slots: slots flown
    :return: these, or T_max
    """
    return rules.max_slots if rules.correct_to_deadline else slots


@njit
def count_loads(rules: Rules, state: State) -> None:
    """Cell loads n_b = |U_b| of all games.

    :param rules: the game's constants
    :param state: the state; ``cell_load`` is written
    """
    cell, position, flying, cell_load = rules.cell, state.position, state.flying, state.cell_load
    cell_load[:] = 0
    for g in range(flying.shape[0]):
        for i in range(flying.shape[1]):
            if flying[g, i] or rules.arrived_stays:
                x, y, z = voxel_of(position, g, i)
                cell_load[g, cell[x, y, z]] += 1


@njit
def remember_loads(state: State) -> None:
    """Keep the cell loads that the UAVs see before they move.

    :param state: the state; ``past_load`` is written
    """
    cell_load, past_load = state.cell_load, state.past_load
    for g in range(past_load.shape[0]):
        if not state.flying[g].any():
            continue
        for h in range(past_load.shape[1] - 1, 0, -1):
            past_load[g, h] = past_load[g, h - 1]
        past_load[g, 0] = cell_load[g]


@njit
def move_uavs(rules: Rules, state: State, outcome: Outcome, actions: Ints) -> None:
    """Move all UAVs (eq:mobility) and reward their progress.

    :param rules: the game's constants
    :param state: the state; ``position`` is written
    :param outcome: the outcome; the navigation reward is written
    :param actions: indices into the action table [G, N]
    """
    table, grid = rules.actions, rules.grid
    position, destination, flying = state.position, state.destination, state.flying
    reward_terms = outcome.reward_terms
    for g in range(flying.shape[0]):
        for i in range(flying.shape[1]):
            if not flying[g, i]:
                continue
            voxel, goal = voxel_of(position, g, i), voxel_of(destination, g, i)
            a = actions[g, i]
            target = move(voxel, (table[a, 0], table[a, 1], table[a, 2]), grid, rules.clip_moves)
            if rules.fly_through:
                target = stop_at(voxel, target, goal)
            for k in range(3):
                position[g, i, k] = target[k]
            reward_terms[g, i, 1] = reward_nav(distance(voxel, goal), distance(target, goal), rules.nav_weight)


@njit
def mark_collisions(rules: Rules, state: State, outcome: Outcome) -> None:
    """Find the UAVs that violate eq:collision, all UAVs moved.

    :param rules: the game's constants
    :param state: the state
    :param outcome: the outcome; ``collided`` is written
    """
    position, flying, collided = state.position, state.flying, outcome.collided
    collided[:] = False
    num_games, num_uavs = flying.shape
    for g in range(num_games):
        for i in range(num_uavs):
            for j in range(i):
                both = (flying[g, i] and flying[g, j]) or (rules.arrived_stays and (flying[g, i] or flying[g, j]))
                if both and voxel_of(position, g, i) == voxel_of(position, g, j):
                    collided[g, i] = collided[g, i] or flying[g, i]
                    collided[g, j] = collided[g, j] or flying[g, j]


@njit
def rate_uavs(rules: Rules, state: State, outcome: Outcome) -> None:
    """Associate, share RBs and rate all UAVs, all UAVs moved and loads counted.

    :param rules: the game's constants
    :param state: the state
    :param outcome: the outcome; cell, load, RBs and rate are written
    """
    cells, rb_rate_mbps, gbs_rbs = rules.cell, rules.rb_rate_mbps, rules.num_rbs
    position, flying, loads = state.position, state.flying, state.cell_load
    cell, cell_load, num_rbs, rate_mbps = outcome.cell, outcome.cell_load, outcome.num_rbs, outcome.rate_mbps
    for g in range(flying.shape[0]):
        for i in range(flying.shape[1]):
            if not flying[g, i]:
                cell[g, i] = cell_load[g, i] = num_rbs[g, i] = 0
                rate_mbps[g, i] = 0.0
                continue
            x, y, z = voxel_of(position, g, i)
            b = cells[x, y, z]
            cell[g, i] = b
            cell_load[g, i] = loads[g, b]
            num_rbs[g, i] = rb_share(gbs_rbs[b], loads[g, b])
            rate_mbps[g, i] = achievable_rate_mbps(num_rbs[g, i], rb_rate_mbps[x, y, z])


@njit
def judge_uavs(rules: Rules, state: State, outcome: Outcome) -> None:
    """Advance clocks, EMA rates and utilities; judge arrival and deadline.

    :param rules: the game's constants
    :param state: the state; ``slot`` and ``ema_rate_mbps`` are written
    :param outcome: the outcome; all but rates and collisions is written
    """
    beta, unit, max_slots = rules.ema_beta, rules.rate_unit_mbps, rules.max_slots
    position, destination, flying, least = state.position, state.destination, state.flying, state.min_slots
    slot, ema_mbps = state.slot, state.ema_rate_mbps
    rate_mbps, collided, reward_terms = outcome.rate_mbps, outcome.collided, outcome.reward_terms
    corrected_mbps, utility_mbps = outcome.corrected_rate_mbps, outcome.utility_mbps
    arrived, timed_out = outcome.arrived, outcome.timed_out
    for g in range(flying.shape[0]):
        for i in range(flying.shape[1]):
            if not flying[g, i]:
                reward_terms[g, i, :] = 0.0
                corrected_mbps[g, i] = utility_mbps[g, i] = 0.0
                arrived[g, i] = timed_out[g, i] = False
                continue
            before = ema_mbps[g, i]
            slot[g, i] += 1
            ema_mbps[g, i] = ema_rate(before, rate_mbps[g, i], beta)
            corrected_mbps[g, i] = corrected_rate(ema_mbps[g, i], beta, bias_horizon(rules, slot[g, i]))
            there = voxel_of(position, g, i) == voxel_of(destination, g, i)
            late = slot[g, i] >= max_slots and not there
            worth = utility(corrected_mbps[g, i], least[g, i], slot[g, i]) if there else 0.0
            reward_terms[g, i, 0] = reward_rate(before, ema_mbps[g, i], unit)
            reward_terms[g, i, 2] = reward_col(collided[g, i], rules.collision_penalty)
            reward_terms[g, i, 3] = reward_term(there, late, worth, unit, rules.fail_penalty)
            arrived[g, i], timed_out[g, i], utility_mbps[g, i] = there, late, worth


@njit
def step_games(rules: Rules, state: State, outcome: Outcome, actions: Ints) -> None:
    """Advance all games by one slot; UAVs that are done stop flying.

    :param rules: the game's constants
    :param state: the state; written
    :param outcome: the outcome; written
    :param actions: indices into the action table [G, N]; those of UAVs that are not flying are ignored
    """
    remember_loads(state)
    move_uavs(rules, state, outcome, actions)
    count_loads(rules, state)
    rate_uavs(rules, state, outcome)
    mark_collisions(rules, state, outcome)
    judge_uavs(rules, state, outcome)
    flying, arrived, timed_out = state.flying, outcome.arrived, outcome.timed_out
    for g in range(flying.shape[0]):
        for i in range(flying.shape[1]):
            flying[g, i] = flying[g, i] and not arrived[g, i] and not timed_out[g, i]
    count_loads(rules, state)


@njit
def start_mission(rules: Rules, state: State, game: int, uav: int) -> None:
    """Set the clock, the EMA rate and T_min of a UAV that stands at its origin.

    :param rules: the game's constants
    :param state: the state
    :param game: index of the game
    :param uav: index of the UAV
    """
    origin, destination = voxel_of(state.position, game, uav), voxel_of(state.destination, game, uav)
    state.min_slots[game, uav] = min_slots(origin, destination, rules.max_voxel_steps)
    state.slot[game, uav] = 0
    state.ema_rate_mbps[game, uav] = 0.0
    state.flying[game, uav] = True


@njit
def start_games(rules: Rules, state: State) -> None:
    """Start the missions of all UAVs, which stand at their origins.

    :param rules: the game's constants
    :param state: the state; written
    """
    for g in range(state.flying.shape[0]):
        for i in range(state.flying.shape[1]):
            start_mission(rules, state, g, i)
    count_loads(rules, state)


@njit
def thin_games(rules: Rules, state: State, rng: np.random.Generator, fewest: int, games: NDArray[np.bool_]) -> None:
    """Let games that start anew have fewer UAVs than N: the last of them are where they headed for.

    :param rules: the game's constants
    :param state: the state; written
    :param rng: source of the numbers of UAVs, each from ``fewest`` to N as likely as any other
    :param fewest: the smallest number of UAVs, 1 or more
    :param games: which games [G]
    """
    num_uavs = state.flying.shape[1]
    for g in range(len(games)):
        if games[g]:
            for i in range(rng.integers(fewest, num_uavs + 1), num_uavs):
                state.flying[g, i] = False
                state.position[g, i] = state.destination[g, i]
                state.min_slots[g, i] = 0
    count_loads(rules, state)


@njit
def renew_missions(rules: Rules, state: State, rng: np.random.Generator, whole_games: bool) -> None:
    """Give UAVs that are done a new mission.

    :param rules: the game's constants
    :param state: the state; written
    :param rng: source of the missions
    :param whole_games: only once all UAVs of their game are done; otherwise at once (Algorithm 1)
    """
    flying = state.flying
    for g in range(flying.shape[0]):
        if whole_games and flying[g].any():
            continue
        for i in range(flying.shape[1]):
            if not flying[g, i]:
                draw_mission(rng, rules.grid, state.position[g], state.destination[g], flying[g], i)
                start_mission(rules, state, g, i)
    count_loads(rules, state)
