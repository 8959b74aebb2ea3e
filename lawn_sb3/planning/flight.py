"""The best flight of one UAV, exactly: backward recursion over (slot, voxel), while all others' trajectories are fixed.

With the flight time T fixed, the utility, Eq. (9), eq:utility, is a weighted sum of the rates of all slots, so the best
way to go on from a voxel does not depend on how the UAV got there:

V_s(v) = w(s) R(v, n_b(s) + 1) + e_b(s) + max_a V_{s+1}(v + a)

with the weights w of :func:`slot_weight`, the others' loads n_b and the effect e_b on the others' utilities. The
recursion is repeated for every T worth trying.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.airspace import Voxel, is_inside, min_slots, stop_at
from lawn_sb3.game.compiled import njit
from lawn_sb3.game.payoff import corrected_rate, slot_weight, utility
from lawn_sb3.game.radio import achievable_rate_mbps, rb_share
from lawn_sb3.game.state import Rules, State, bias_horizon, voxel_of
from lawn_sb3.scenario import MOST_SLOTS

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

DEFAULT_SLACK = 5
"""Slots beyond T_i^min that a flight may take."""
ANY_SLACK = MOST_SLOTS
"""A slack that leaves no flight out: the most slots that a scenario's deadline may have."""


class Surroundings(NamedTuple):
    """What one UAV meets in each slot from now on, while the others' trajectories are fixed."""

    loads: Ints  # [S + 1, M] other UAVs in each cell
    effects_mbps: Floats  # [S + 1, M] change of the others' utilities if the UAV is in the cell, 0 or less
    voxels: Ints  # [J, S + 1, 3] where the others are
    slots: Ints  # [J] slots until each of them is done; 0 if it is not flying


class Flight(NamedTuple):
    """A best flight."""

    slots: int  # from now until arrival; 0 if the deadline cannot be met
    worth_mbps: float  # the own utility and what it changes for others, less the price of collisions
    action: int  # the first move, as an index into the action table


@njit
def collision_price_mbps(rules: Rules, num_uavs: int) -> float:
    """A price in Mbps above all that utilities can gain, so that fewest collisions come first and the worth second."""
    return 1.0 + num_uavs * peak_rate_mbps(rules)


@njit
def peak_rate_mbps(rules: Rules) -> float:
    """The highest rate anywhere in Mbps: that of a lone UAV in the best voxel."""
    cell, rb_rate_mbps, num_rbs = rules.cell, rules.rb_rate_mbps, rules.num_rbs
    best = 0.0
    for x in range(rules.grid[0]):
        for y in range(rules.grid[1]):
            for z in range(rules.grid[2]):
                best = max(best, achievable_rate_mbps(num_rbs[cell[x, y, z]], rb_rate_mbps[x, y, z]))
    return best


@njit
def longest_flight(rules: Rules, state: State, game: int, uav: int, slack: int) -> int:
    """The longest flight that is tried: T_i^min and the slack, or the shortest from here, but never past the deadline.

    :return: slots from now; fewer than the shortest flight takes if the deadline cannot be met
    """
    here, goal = voxel_of(state.position, game, uav), voxel_of(state.destination, game, uav)
    flown = state.slot[game, uav]
    wanted = max(state.min_slots[game, uav] + slack - flown, min_slots(here, goal, rules.max_voxel_steps))
    return int(min(wanted, rules.max_slots - flown))


@njit
def best_flight(
    rules: Rules, state: State, game: int, uav: int, around: Surroundings, slack: int, path: Ints
) -> Flight:
    """The best way of one UAV from where it is to its destination, within the deadline.

    Collisions count first: a way without any is taken if there is one. Flight times are tried from the shortest up,
    until no longer flight can be better.

    :param around: what it meets; at least as many slots as can be flown
    :param path: voxels from slot to slot, the present one first [S + 1, 3]; written, and filled up with the
        destination, unless the deadline cannot be met
    :return: the flight
    """
    position, goal = voxel_of(state.position, game, uav), voxel_of(state.destination, game, uav)
    least, flown = state.min_slots[game, uav], state.slot[game, uav]
    beta, ema_mbps = rules.ema_beta, state.ema_rate_mbps[game, uav]
    peak_mbps = peak_rate_mbps(rules)
    price_mbps = collision_price_mbps(rules, state.flying.shape[1])
    values, shares = np.empty((2, *rules.grid)), np.empty(len(rules.num_rbs))
    shortest = min_slots(position, goal, rules.max_voxel_steps)
    longest = longest_flight(rules, state, game, uav, slack)
    moves = np.empty((max(longest, 1), *rules.grid), dtype=np.int32)
    best = Flight(0, -np.inf, 0)
    for slots in range(shortest, longest + 1):
        total = flown + slots
        horizon = bias_horizon(rules, total)
        # No EMA rate exceeds that of the peak rate in all slots, and no other UAV gains by this one's presence.
        ceiling = 1.0 - (1.0 - beta) ** total
        if utility(corrected_rate(peak_mbps * ceiling, beta, horizon), least, total) <= best.worth_mbps:
            break
        carried = utility(corrected_rate(ema_mbps * (1.0 - beta) ** slots, beta, horizon), least, total)
        worth = carried + _after_arrival(rules, goal, around, slots, price_mbps)
        for s in range(slots, 0, -1):
            weight = slot_weight(beta, slots - s, least, total, horizon)
            here, later, effects_mbps = values[s % 2], values[(s + 1) % 2], around.effects_mbps[s]
            for b in range(len(shares)):
                shares[b] = rb_share(rules.num_rbs[b], around.loads[s, b] + 1)
            value_slot(
                rules, (0, 0, 0), rules.grid, position, goal, shares, effects_mbps, s, slots, weight, here, later, moves
            )
            for j in range(len(around.slots)):
                if s <= around.slots[j] or rules.arrived_stays:
                    here[voxel_of(around.voxels, j, s)] -= price_mbps
        action, value = best_move(rules.actions, rules.grid, rules.fly_through, position, goal, values[1])
        if worth + value > best.worth_mbps:
            best = Flight(slots, worth + value, action)
            _trace(rules, position, goal, slots, action, moves, path)
    return best


@njit
def _after_arrival(rules: Rules, goal: Voxel, around: Surroundings, slots: int, price_mbps: float) -> float:
    """What a UAV that stays at its destination changes for those still flying; 0 if it leaves."""
    worth = 0.0
    if rules.arrived_stays:
        cell = rules.cell[goal]
        for s in range(slots + 1, around.loads.shape[0]):
            worth += around.effects_mbps[s, cell]
            for j in range(len(around.slots)):
                if s <= around.slots[j] and voxel_of(around.voxels, j, s) == goal:
                    worth -= price_mbps
    return worth


@njit
def value_slot(
    rules: Rules,
    low: Voxel,
    size: Voxel,
    position: Voxel,
    goal: Voxel,
    shares: Floats,
    effects_mbps: Floats,
    s: int,
    slots: int,
    weight: float,
    values: Floats,
    later: Floats,
    moves: NDArray[np.int32] | None,
) -> None:
    """V_s of every voxel of a box of the airspace, and the move that follows.

    Only voxels that can be reached from the position, and from which the destination can be reached, count; the others
    are worth minus infinity. The destination ends the flight, so it is out of bounds before the last slot.

    :param low: corner of the box, from which position, destination and all voxels here are counted
    :param size: of the box
    :param shares: RBs that the UAV gets in each cell [M]
    :param effects_mbps: change of the others' utilities if it is there [M]
    :param values: V_s; written
    :param later: V_{s+1}
    :param moves: of every slot [S, W, L, H]; that of this slot is written, unless it is the last
    """
    cell, rb_rate_mbps, actions, fly_through = rules.cell, rules.rb_rate_mbps, rules.actions, rules.fly_through
    values[:] = -np.inf
    reach, left = rules.max_voxel_steps * s, rules.max_voxel_steps * (slots - s)
    low_x, high_x = overlap(position[0], reach, goal[0], left, size[0])
    for x in range(low_x, high_x):
        reach_y, left_y = reach - abs(x - position[0]), left - abs(x - goal[0])
        low_y, high_y = overlap(position[1], reach_y, goal[1], left_y, size[1])
        for y in range(low_y, high_y):
            reach_z, left_z = reach_y - abs(y - position[1]), left_y - abs(y - goal[1])
            low_z, high_z = overlap(position[2], reach_z, goal[2], left_z, size[2])
            for z in range(low_z, high_z):
                following = 0.0
                if s < slots:
                    if (x, y, z) == goal:
                        continue
                    move, following = best_move(actions, size, fly_through, (x, y, z), goal, later)
                    if moves is not None:
                        moves[s, x, y, z] = move
                voxel = low[0] + x, low[1] + y, low[2] + z
                b = cell[voxel]
                values[x, y, z] = weight * (shares[b] * rb_rate_mbps[voxel]) + effects_mbps[b] + following


@njit
def overlap(first: int, reach: int, second: int, other_reach: int, size: int) -> tuple[int, int]:
    """Coordinates along one axis within ``reach`` of one end and ``other_reach`` of the other: a half-open range."""
    return max(first - reach, second - other_reach, 0), min(first + reach, second + other_reach, size - 1) + 1


@njit
def best_move(
    actions: Ints, grid: Voxel, fly_through: bool, voxel: Voxel, goal: Voxel, later: Floats
) -> tuple[int, float]:
    """The move after which the worth is highest, and that worth; of equal ones the first in the action table.

    Moves out of the airspace are left out: clipped or refused, they end where another move ends too.

    :param grid: size of the airspace, or of the part of it that the voxels are counted in
    :param later: V_{s+1}, minus infinity where the UAV must not be [W, L, H]
    :return: index into the action table, and the worth
    """
    best, highest = 0, -np.inf
    for a in range(len(actions)):
        end = voxel[0] + actions[a, 0], voxel[1] + actions[a, 1], voxel[2] + actions[a, 2]
        if is_inside(end, grid):
            if fly_through:
                end = stop_at(voxel, end, goal)
            if later[end] > highest:
                best, highest = a, later[end]
    return best, highest


@njit
def _trace(
    rules: Rules, position: Voxel, goal: Voxel, slots: int, action: int, moves: NDArray[np.int32], path: Ints
) -> None:
    """Write the voxels of a flight: the first move, then those that the recursion chose."""
    voxel = position
    for s in range(path.shape[0]):
        for k in range(3):
            path[s, k] = voxel[k]
        if s >= slots - 1:
            voxel = goal
            continue
        a = action if s == 0 else moves[s][voxel]
        voxel = voxel[0] + rules.actions[a, 0], voxel[1] + rules.actions[a, 1], voxel[2] + rules.actions[a, 2]
