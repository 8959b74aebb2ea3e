"""The forecast: every UAV plans anew in every slot, as if the loads it sees now never changed."""

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.compiled import njit
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.game.state import Rules, State, voxel_of
from lawn_sb3.planning.flight import best_flight, longest_flight
from lawn_sb3.planning.plan import check_in_time, nobody


class ForecastPlayer:
    """Every UAV flies the first move of its best flight through cells whose loads, itself aside, never change.

    It is decentralised: a UAV knows its own o_i, Eq. (12), eq:obs, and how many slots it has flown, nothing else. It
    therefore cannot avoid collisions. Without slack it never takes longer than the least flight time: loads do change,
    and waiting for better ones costs more than it gains.

    :param slack: slots beyond T_i^min that a flight may take
    """

    name = "forecast"

    def __init__(self, slack: int = 0) -> None:
        self.slack = slack

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Check that all missions can be flown in time."""
        check_in_time(simulator.rules, simulator.state)

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Plan anew, and take the first moves [G, N]."""
        return _first_moves(simulator.rules, simulator.state, self.slack)


@njit
def _first_moves(rules: Rules, state: State, slack: int) -> NDArray[np.int64]:
    actions = np.zeros(state.flying.shape, dtype=np.int64)
    for g in range(state.flying.shape[0]):
        for i in range(state.flying.shape[1]):
            if not state.flying[g, i]:
                continue
            around = nobody(longest_flight(rules, state, g, i, slack), len(rules.num_rbs))
            around.loads[:] = state.cell_load[g]
            around.loads[:, rules.cell[voxel_of(state.position, g, i)]] -= 1  # the UAV itself
            path = np.empty((around.loads.shape[0], 3), dtype=np.int64)
            actions[g, i] = best_flight(rules, state, g, i, around, slack, path).action
    return actions
