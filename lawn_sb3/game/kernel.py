"""One slot of many games as one compiled call, in the order: move, associate, share RBs, rate, payoff, retire.

Each phase loops over all games and takes its arrays out of the named tuples once: Numba counts a reference at every
such access, which inside the loops costs ten times the arithmetic.
"""

import numpy as np

from lawn_sb3.game.airspace import distance, draw_mission, min_slots, move, stop_at
from lawn_sb3.game.compiled import njit
from lawn_sb3.game.payoff import corrected_rate, ema_rate, reward_col, reward_nav, reward_rate, reward_term, utility
from lawn_sb3.game.radio import achievable_rate_mbps, rb_share
from lawn_sb3.game.state import COL, NAV, RATE, TERM, Bools, Ints, Outcome, Rules, State, bias_horizon, voxel_of


@njit
def step_games(rules: Rules, state: State, outcome: Outcome, actions: Ints, crowd: Ints) -> None:
    """Advance all games by one slot; UAVs that are done stop flying.

    :param rules: the game's constants
    :param state: the state; written
    :param outcome: the outcome; written
    :param actions: indices into the action table [G, N]; those of UAVs that are not flying are ignored
    :param crowd: room to count the UAVs in each voxel [W, L, H]; zeros, before and after
    """
    _remember_loads(state)
    _move_uavs(rules, state, outcome, actions)
    count_loads(rules, state)
    _rate_uavs(rules, state, outcome)
    _mark_collisions(rules, state, outcome, crowd)
    _judge_uavs(rules, state, outcome)
    flying, arrived, timed_out = state.flying, outcome.arrived, outcome.timed_out
    for g in range(flying.shape[0]):
        for i in range(flying.shape[1]):
            flying[g, i] = flying[g, i] and not arrived[g, i] and not timed_out[g, i]
    count_loads(rules, state)


@njit
def count_loads(rules: Rules, state: State) -> None:
    """Write the cell loads of all games: n_b = ``|{i : b_i = b}|``, above Eq. (1)."""
    cell, position, flying, cell_load = rules.cell, state.position, state.flying, state.cell_load
    cell_load[:] = 0
    for g in range(flying.shape[0]):
        for i in range(flying.shape[1]):
            if flying[g, i] or rules.arrived_stays:
                x, y, z = voxel_of(position, g, i)
                cell_load[g, cell[x, y, z]] += 1


@njit
def _remember_loads(state: State) -> None:
    """Keep the cell loads that the UAVs see before they move."""
    cell_load, past_load = state.cell_load, state.past_load
    for g in range(past_load.shape[0]):
        if not state.flying[g].any():
            continue
        for h in range(past_load.shape[1] - 1, 0, -1):
            past_load[g, h] = past_load[g, h - 1]
        past_load[g, 0] = cell_load[g]


@njit
def _move_uavs(rules: Rules, state: State, outcome: Outcome, actions: Ints) -> None:
    """Move all UAVs, Eq. (3), eq:mobility, and reward their progress."""
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
            reward_terms[g, i, NAV] = reward_nav(distance(voxel, goal), distance(target, goal), rules.nav_weight)


@njit
def _mark_collisions(rules: Rules, state: State, outcome: Outcome, crowd: Ints) -> None:
    """Find the UAVs that violate Eq. (4), eq:collision, once all have moved.

    q_i(t) != q_j(t) for all i != j
    """
    position, flying, collided = state.position, state.flying, outcome.collided
    for g in range(flying.shape[0]):
        for i in range(flying.shape[1]):
            if flying[g, i] or rules.arrived_stays:
                x, y, z = voxel_of(position, g, i)
                crowd[x, y, z] += 1
        for i in range(flying.shape[1]):
            x, y, z = voxel_of(position, g, i)
            collided[g, i] = flying[g, i] and crowd[x, y, z] > 1
        for i in range(flying.shape[1]):
            x, y, z = voxel_of(position, g, i)
            crowd[x, y, z] = 0


@njit
def _rate_uavs(rules: Rules, state: State, outcome: Outcome) -> None:
    """Associate, share RBs and rate all UAVs, once all have moved and the loads are counted."""
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
def _judge_uavs(rules: Rules, state: State, outcome: Outcome) -> None:
    """Advance clocks, EMA rates and utilities; judge arrival and deadline, Eq. (5), eq:deadline.

    T_i <= T_max
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
            reward_terms[g, i, RATE] = reward_rate(before, ema_mbps[g, i], unit)
            reward_terms[g, i, COL] = reward_col(collided[g, i], rules.collision_penalty)
            reward_terms[g, i, TERM] = reward_term(there, late, worth, unit, rules.fail_penalty)
            arrived[g, i], timed_out[g, i], utility_mbps[g, i] = there, late, worth


@njit
def start_games(rules: Rules, state: State) -> None:
    """Start the missions of all UAVs, which stand at their origins."""
    for g in range(state.flying.shape[0]):
        for i in range(state.flying.shape[1]):
            _start_mission(rules, state, g, i)
    count_loads(rules, state)


@njit
def _start_mission(rules: Rules, state: State, game: int, uav: int) -> None:
    """Set the clock, the EMA rate and T_min of a UAV that stands at its origin."""
    origin, destination = voxel_of(state.position, game, uav), voxel_of(state.destination, game, uav)
    state.min_slots[game, uav] = min_slots(origin, destination, rules.max_voxel_steps)
    state.slot[game, uav] = 0
    state.ema_rate_mbps[game, uav] = 0.0
    state.flying[game, uav] = True


@njit
def thin_games(rules: Rules, state: State, rng: np.random.Generator, fewest: int, games: Bools) -> None:
    """Let games that start anew have fewer UAVs than N: the last ones stand at their destinations, done.

    :param rules: the game's constants
    :param state: the state; written
    :param rng: draws the number of UAVs, each from ``fewest`` to N as likely as any other
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
    :param rng: draws the missions
    :param whole_games: only once all UAVs of their game are done; otherwise at once (Algorithm 1)
    """
    flying = state.flying
    for g in range(flying.shape[0]):
        if whole_games and flying[g].any():
            continue
        for i in range(flying.shape[1]):
            if not flying[g, i]:
                draw_mission(rng, rules.grid, state.position[g], state.destination[g], flying[g], i)
                _start_mission(rules, state, g, i)
    count_loads(rules, state)
