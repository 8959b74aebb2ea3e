"""Regret: what each UAV could have had by deviating alone from the trajectories that were flown."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.compiled import njit
from lawn_sb3.game.state import Rules, State
from lawn_sb3.planning.best_response import best_response
from lawn_sb3.planning.plan import Plan, planned_utilities_mbps


class Responses(NamedTuple):
    """The best response of every UAV of a game to the others' trajectories."""

    utilities_mbps: NDArray[np.float64]  # [N] utility that it would have given
    slots: NDArray[np.int64]  # [N] slots it takes; 0 if the destination is out of reach


@njit
def best_responses(rules: Rules, state: State, game: int, plan: Plan) -> Responses:
    """What every UAV could have by changing its own trajectory alone, exactly, over all flight times up to T_max.

    :param rules: the game's constants
    :param state: the state of all games, at their first slot
    :param game: index of the game
    :param plan: the trajectories flown, with room for T_max slots; the same afterwards
    :return: the best responses; collisions come first, so one may be worth less than a flight that collided
    """
    num_uavs = len(plan.slots)
    utilities, slots = np.zeros(num_uavs), np.zeros(num_uavs, dtype=np.int64)
    for i in range(num_uavs):
        flight, path = best_response(rules, state, game, plan, i, False, rules.max_slots)
        if flight.slots > 0:
            flown_voxels, flown_slots = plan.voxels[i].copy(), plan.slots[i]
            plan.voxels[i], plan.slots[i] = path, flight.slots
            utilities[i], slots[i] = planned_utilities_mbps(rules, state, game, plan)[i], flight.slots
            plan.voxels[i], plan.slots[i] = flown_voxels, flown_slots
    return Responses(utilities, slots)
