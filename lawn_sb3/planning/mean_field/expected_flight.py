"""The best flight of one UAV against what it expects of the cells, instead of what the others are known to do.

It is the recursion of ``flight.best_flight`` with two differences. The RB share that the UAV expects in a cell need not
be a whole number: Eq. (2), eq:rate, is linear in the share, so the expected rate is that of the expected share. And
nobody's position is known, so no collision can be avoided. Only the first move is used, since everything is planned
anew in the next slot; the recursion keeps no others, and skips voxels outside the box that the flight can be in.
"""

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.airspace import Voxel, min_slots
from lawn_sb3.game.compiled import njit
from lawn_sb3.game.payoff import corrected_rate, slot_weight, utility
from lawn_sb3.game.state import Rules, State, bias_horizon, voxel_of
from lawn_sb3.planning.flight import Flight, best_move, longest_flight, value_slot
from lawn_sb3.planning.mean_field.sight import bucket

Floats = NDArray[np.float64]


@njit
def expected_flight(
    rules: Rules, state: State, game: int, uav: int, outlook: Floats, slack: int, peak_mbps: float, room: Floats
) -> Flight:
    """The best way of one UAV from where it is to its destination, within the deadline, by what it expects.

    :param outlook: by bucket of slots ahead and cell: the RB share that it would get there, and what that would cost
        the others in Mbps of their utilities [K, M, 2]; times beyond the last bucket count as the last
    :param peak_mbps: the highest rate anywhere
    :param room: two numbers for each voxel of the airspace, to work with; written
    :return: the flight
    """
    position, goal = voxel_of(state.position, game, uav), voxel_of(state.destination, game, uav)
    least, flown = state.min_slots[game, uav], state.slot[game, uav]
    beta, ema_mbps = rules.ema_beta, state.ema_rate_mbps[game, uav]
    shortest = min_slots(position, goal, rules.max_voxel_steps)
    best = Flight(0, -np.inf, 0)
    for slots in range(shortest, longest_flight(rules, state, game, uav, slack) + 1):
        total = flown + slots
        horizon = bias_horizon(rules, total)
        ceiling = 1.0 - (1.0 - beta) ** total  # as in best_flight: no longer flight can be better
        if utility(corrected_rate(peak_mbps * ceiling, beta, horizon), least, total) <= best.worth_mbps:
            break
        low, size, values = flight_values(rules, position, goal, least, flown, slots, outlook, room)
        here, there = from_corner(low, position), from_corner(low, goal)
        worth = utility(corrected_rate(ema_mbps * (1.0 - beta) ** slots, beta, horizon), least, total)
        action, value = best_move(rules.actions, size, rules.fly_through, here, there, values)
        if worth + value > best.worth_mbps:
            best = Flight(slots, worth + value, action)
    return best


@njit
def flight_values(
    rules: Rules, position: Voxel, goal: Voxel, least: int, flown: int, slots: int, outlook: Floats, room: Floats
) -> tuple[Voxel, Voxel, Floats]:
    """What a flight of so many slots is worth from each voxel that its first move can lead to.

    :param least: T_i^min of the mission
    :param flown: slots of it that have been flown
    :param slots: that the flight takes, from now to its arrival
    :param outlook: as for :func:`expected_flight`, as is ``room``
    :return: the corner and size of the part of the airspace that the flight can be in, and the worth in Mbps of what is
        gained in its voxels from there on [size]; minus infinity where the flight cannot be after its first slot
    """
    beta, total = rules.ema_beta, flown + slots
    horizon = bias_horizon(rules, total)
    low, size = _box(position, goal, slots * rules.max_voxel_steps, rules.grid)
    volume = size[0] * size[1] * size[2]
    values = room[: 2 * volume].reshape((2, size[0], size[1], size[2]))
    here, there = from_corner(low, position), from_corner(low, goal)
    for s in range(slots, 0, -1):
        weight = slot_weight(beta, slots - s, least, total, horizon)
        ahead = outlook[min(bucket(s), len(outlook) - 1)]
        now, later, gains_mbps = values[s % 2], values[(s + 1) % 2], -ahead[:, 1]
        value_slot(rules, low, size, here, there, ahead[:, 0], gains_mbps, s, slots, weight, now, later, None)
    return low, size, values[1]


@njit
def _box(position: Voxel, goal: Voxel, steps: int, grid: Voxel) -> tuple[Voxel, Voxel]:
    """The corner and size of the smallest box that holds every way of at most ``steps`` steps."""
    straight = abs(position[0] - goal[0]) + abs(position[1] - goal[1]) + abs(position[2] - goal[2])
    aside = (steps - straight) // 2
    low_x, high_x = _side(position[0], goal[0], aside, grid[0])
    low_y, high_y = _side(position[1], goal[1], aside, grid[1])
    low_z, high_z = _side(position[2], goal[2], aside, grid[2])
    return (low_x, low_y, low_z), (high_x - low_x, high_y - low_y, high_z - low_z)


@njit
def _side(first: int, second: int, aside: int, size: int) -> tuple[int, int]:
    return max(min(first, second) - aside, 0), min(max(first, second) + aside, size - 1) + 1


@njit
def from_corner(low: Voxel, voxel: Voxel) -> Voxel:
    """A voxel, counted from a corner."""
    return voxel[0] - low[0], voxel[1] - low[1], voxel[2] - low[2]
