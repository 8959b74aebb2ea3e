"""What a UAV takes from the others in its cell: the cost to the welfare that its own utility does not show.

It is the welfare without the UAV's share of the RBs less the welfare with it, slot by slot. A UAV whose reward is
reduced by it is rewarded with what it changes in the welfare: what is good for it is then good for all.
"""

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.airspace import min_slots
from lawn_sb3.game.compiled import njit
from lawn_sb3.game.payoff import slot_weight
from lawn_sb3.game.radio import achievable_rate_mbps, rb_share
from lawn_sb3.game.state import Outcome, Rules, State, bias_horizon, voxel_of


@njit
def losses_to_others(rules: Rules, state: State, outcome: Outcome) -> NDArray[np.float64]:
    """What each UAV's presence in its cell, in the slot that has just ended, costs the utilities of the others there.

    L_i(t) = sum over j != i with b_j = b_i of  w_j(t) (floor(K_b / (n_b - 1)) - floor(K_b / n_b)) r_jb

    The weights w_j(t) are those of :func:`slot_weight`, and r_jb is the rate over one RB. The flight times T_j are not
    known yet; all are assumed to fly straight from here on.

    :param rules: the game's constants
    :param state: the state after the slot
    :param outcome: what the slot gave
    :return: loss in Mbps, 0 or more [G, N]; 0 for a UAV that did not fly
    """
    position, destination, slot, least = state.position, state.destination, state.slot, state.min_slots
    cell, cell_load, rb_rate_mbps = outcome.cell, outcome.cell_load, rules.rb_rate_mbps
    num_games, num_uavs = slot.shape
    losses = np.zeros((num_games, num_uavs))
    lost = np.zeros(num_uavs)
    for g in range(num_games):
        for j in range(num_uavs):
            lost[j] = 0.0
            load = cell_load[g, j]
            if load < 2:  # on the ground, or alone
                continue
            here, goal = voxel_of(position, g, j), voxel_of(destination, g, j)
            left = min_slots(here, goal, rules.max_voxel_steps)
            flown = slot[g, j] + left
            weight = slot_weight(rules.ema_beta, left, least[g, j], flown, bias_horizon(rules, flown))
            rbs = rules.num_rbs[cell[g, j]]
            lost[j] = weight * achievable_rate_mbps(rb_share(rbs, load - 1) - rb_share(rbs, load), rb_rate_mbps[here])
        for i in range(num_uavs):
            if cell_load[g, i] < 2:
                continue
            for j in range(num_uavs):
                if j != i and cell_load[g, j] > 0 and cell[g, j] == cell[g, i]:
                    losses[g, i] += lost[j]
    return losses
