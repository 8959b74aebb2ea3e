"""What a UAV can have whatever the others do to the loads: a bound on how bad an equilibrium can be."""

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.compiled import njit
from lawn_sb3.game.state import Rules, State
from lawn_sb3.planning.flight import best_flight, longest_flight
from lawn_sb3.planning.plan import nobody


@njit
def guaranteed_utilities_mbps(rules: Rules, state: State, slack: int) -> NDArray[np.float64]:
    """The utility of every UAV's best flight if all others were always in its own cell.

    Rates never rise with the load, so the same flight gives no less whatever the others do. In an equilibrium everybody
    flies a best response, so nobody has less, unless others are in its way: a best response avoids collisions first.

    :return: utilities in Mbps [G, N]; 0 for a UAV that is not flying or has too little time
    """
    num_games, num_uavs = state.flying.shape
    utilities = np.zeros((num_games, num_uavs))
    for g in range(num_games):
        for i in range(num_uavs):
            if state.flying[g, i]:
                around = nobody(longest_flight(rules, state, g, i, slack), len(rules.num_rbs))
                around.loads[:] = num_uavs - 1
                path = np.empty((around.loads.shape[0], 3), dtype=np.int64)
                flight = best_flight(rules, state, g, i, around, slack, path)
                if flight.slots > 0:
                    utilities[g, i] = flight.worth_mbps
    return utilities
