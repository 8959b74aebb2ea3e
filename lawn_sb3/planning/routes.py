"""Joint plans without regard to the others: every UAV's best route as if alone, or a random shortest path."""

import numpy as np

from lawn_sb3.game.airspace import is_inside, min_slots
from lawn_sb3.game.compiled import njit
from lawn_sb3.game.state import Rules, State, voxel_of
from lawn_sb3.planning.flight import best_flight
from lawn_sb3.planning.plan import Plan, empty_plan, nobody


def routes_alone(rules: Rules, state: State, game: int, slack: int) -> Plan:
    """Every UAV on the route that would be best if it were alone in the network.

    :raises UserError: naming the UAV that cannot be at its destination in time
    """
    plan = empty_plan(rules, state, game, slack)
    around = nobody(plan.voxels.shape[1] - 1, len(rules.num_rbs))
    for i in np.flatnonzero(state.flying[game]):
        plan.slots[i] = best_flight(rules, state, game, int(i), around, slack, plan.voxels[i]).slots
    return plan


def straight_routes(rules: Rules, state: State, game: int, slack: int, rng: np.random.Generator) -> Plan:
    """Every UAV on a shortest path, each move drawn uniformly from those that keep the least flight time.

    :raises UserError: naming the UAV that cannot be at its destination in time
    """
    plan = empty_plan(rules, state, game, slack)
    for i in np.flatnonzero(state.flying[game]):
        _draw_route(rules, state, game, int(i), rng, plan)
    return plan


@njit
def _draw_route(rules: Rules, state: State, game: int, uav: int, rng: np.random.Generator, plan: Plan) -> None:
    voxel, goal = voxel_of(state.position, game, uav), voxel_of(state.destination, game, uav)
    slots = min_slots(voxel, goal, rules.max_voxel_steps)
    plan.slots[uav] = slots
    for s in range(1, plan.voxels.shape[1]):
        chosen, found = voxel, 0
        for a in range(len(rules.actions)):
            end = voxel[0] + rules.actions[a, 0], voxel[1] + rules.actions[a, 1], voxel[2] + rules.actions[a, 2]
            if is_inside(end, rules.grid) and min_slots(end, goal, rules.max_voxel_steps) <= max(slots - s, 0):
                found += 1
                if rng.integers(0, found) == 0:  # each of those seen so far is equally likely
                    chosen = end
        voxel = chosen
        for k in range(3):
            plan.voxels[uav, s, k] = voxel[k]
