"""The forecast: every UAV plans anew in every slot, as if the loads it sees now never changed."""

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.compiled import njit
from lawn_sb3.game.radio import rb_share
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.game.state import Rules, State, voxel_of
from lawn_sb3.planning.flight import peak_rate_mbps
from lawn_sb3.planning.mean_field.expected_flight import expected_flight
from lawn_sb3.planning.plan import check_in_time


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
    num_gbs = len(rules.num_rbs)
    actions = np.zeros(state.flying.shape, dtype=np.int64)
    peak_mbps = peak_rate_mbps(rules)
    room = np.empty(2 * rules.grid[0] * rules.grid[1] * rules.grid[2])
    outlook = np.zeros((1, num_gbs, 2))  # of all times ahead: the RB share on joining each cell, and no loss to others
    for g in range(state.flying.shape[0]):
        for b in range(num_gbs):
            outlook[0, b, 0] = rb_share(rules.num_rbs[b], state.cell_load[g, b] + 1)
        for i in range(state.flying.shape[1]):
            if not state.flying[g, i]:
                continue
            own = rules.cell[voxel_of(state.position, g, i)]
            outlook[0, own, 0] = rb_share(rules.num_rbs[own], state.cell_load[g, own])  # the UAV itself is one of them
            actions[g, i] = expected_flight(rules, state, g, i, outlook, slack, peak_mbps, room).action
            outlook[0, own, 0] = rb_share(rules.num_rbs[own], state.cell_load[g, own] + 1)
    return actions
