"""What each first move is worth to a UAV, by the forecast: as if the loads it sees now never changed."""

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.airspace import Voxel, is_inside, min_slots, stop_at
from lawn_sb3.game.compiled import njit
from lawn_sb3.game.payoff import slot_weight
from lawn_sb3.game.radio import rb_share
from lawn_sb3.game.state import Rules, bias_horizon
from lawn_sb3.planning.mean_field.expected_flight import flight_values, from_corner

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@njit
def first_move_losses(
    rules: Rules, positions: Ints, goals: Ints, least: Ints, flown: Ints, other_loads: Ints
) -> NDArray[np.float32]:
    """What each first move loses against the best one, of UAVs that know nothing but what they see.

    All flights are without slack: they take what is left of T_i^min, or the shortest time from where the UAV is.

    :param rules: the game
    :param positions: where the UAVs are [B, 3] voxels
    :param goals: their destinations [B, 3]
    :param least: T_i^min of their missions [B]
    :param flown: slots that they have flown [B]
    :param other_loads: UAVs in each cell, the own one left out [B, M]
    :return: the loss in Mbps of the rate in the next slot: that of the utility, Eq. (9), eq:utility, divided by what a
        rate in the next slot weighs in it; infinite for a move after which the flight takes longer [B, A]
    """
    losses = np.empty((len(positions), len(rules.actions)), dtype=np.float32)
    worths = np.empty(len(rules.actions))
    room = np.empty(2 * rules.grid[0] * rules.grid[1] * rules.grid[2])
    outlook = np.zeros((1, len(rules.num_rbs), 2))
    for row in range(len(positions)):
        here, goal = _voxel(positions, row), _voxel(goals, row)
        for b in range(len(rules.num_rbs)):
            outlook[0, b, 0] = rb_share(rules.num_rbs[b], other_loads[row, b] + 1)
        slots = max(least[row] - flown[row], min_slots(here, goal, rules.max_voxel_steps), 1)
        low, size, values = flight_values(rules, here, goal, least[row], flown[row], slots, outlook, room)
        total = flown[row] + slots
        weight = slot_weight(rules.ema_beta, slots - 1, least[row], total, bias_horizon(rules, total))
        start, stop = from_corner(low, here), from_corner(low, goal)
        for a in range(len(rules.actions)):
            end = (
                start[0] + rules.actions[a, 0],
                start[1] + rules.actions[a, 1],
                start[2] + rules.actions[a, 2],
            )
            worths[a] = -np.inf
            if is_inside(end, size):
                worths[a] = values[stop_at(start, end, stop) if rules.fly_through else end]
        losses[row] = (worths.max() - worths) / weight
    return losses


@njit
def _voxel(voxels: Ints, row: int) -> Voxel:
    return voxels[row, 0], voxels[row, 1], voxels[row, 2]
