"""A joint plan: where all UAVs of one game will be in every slot from now on, and what that is worth to each."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.errors import UserError
from lawn_sb3.game.airspace import min_slots
from lawn_sb3.game.compiled import njit
from lawn_sb3.game.payoff import corrected_rate, ema_rate, slot_weight, utility
from lawn_sb3.game.radio import achievable_rate_mbps, rb_share
from lawn_sb3.game.state import Rules, State, bias_horizon, voxel_of
from lawn_sb3.planning.flight import Surroundings, longest_flight

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Plan(NamedTuple):
    """The trajectories of all UAVs of one game, counted in slots from now."""

    voxels: Ints
    """Where each UAV is [N, S + 1, 3]: now, and after each of S slots; a UAV that is done stays in its last voxel."""
    slots: Ints
    """Slots until each UAV is done [N]; 0 for one that is not flying."""


def empty_plan(rules: Rules, state: State, game: int, slack: int) -> Plan:
    """A plan in which nobody flies yet, with room for every flight up to the slack.

    :raises UserError: naming the UAV that cannot be at its destination in time
    """
    num_uavs = state.flying.shape[1]
    room = 0
    for i in np.flatnonzero(state.flying[game]):
        here, goal = state.position[game, i], state.destination[game, i]
        needed = min_slots(tuple(here), tuple(goal), rules.max_voxel_steps)
        left = rules.max_slots - int(state.slot[game, i])
        if needed > left:
            raise UserError(
                f"UAV {i} of game {game} cannot fly its mission: from {here.tolist()} to {goal.tolist()} takes at "
                f"least {needed} slots, and {left} are left of T_max = {rules.max_slots}"
            )
        room = max(room, longest_flight(rules, state, game, int(i), slack))
    voxels = np.repeat(state.position[game][:, None], room + 1, axis=1)
    return Plan(voxels, np.zeros(num_uavs, dtype=np.int64))


def check_in_time(rules: Rules, state: State) -> None:
    """Refuse missions that cannot be flown, before hours of planning.

    :raises UserError: naming the first UAV that cannot be at its destination in time
    """
    for game in range(len(state.flying)):
        empty_plan(rules, state, game, 0)


@njit
def is_there(rules: Rules, plan: Plan, uav: int, s: int) -> bool:
    """Whether a UAV takes RBs and room in slot s, 1 or more: it flies, or stays where its mission ended."""
    return bool(s <= plan.slots[uav] or rules.arrived_stays)


@njit
def planned_loads(rules: Rules, plan: Plan, without: int) -> Ints:
    """Cell loads n_b of every slot.

    :param without: a UAV that does not count; -1 to count all
    :return: loads [S + 1, M]; those of slot 0 stay 0
    """
    num_uavs, num_slots, _ = plan.voxels.shape
    loads = np.zeros((num_slots, len(rules.num_rbs)), dtype=np.int64)
    for s in range(1, num_slots):
        for j in range(num_uavs):
            if j != without and is_there(rules, plan, j, s):
                loads[s, rules.cell[voxel_of(plan.voxels, j, s)]] += 1
    return loads


@njit
def arrives(state: State, game: int, plan: Plan, uav: int) -> bool:
    """Whether a UAV flies and ends at its destination."""
    slots = plan.slots[uav]
    return bool(slots > 0 and voxel_of(plan.voxels, uav, slots) == voxel_of(state.destination, game, uav))


@njit
def planned_weight(rules: Rules, state: State, game: int, plan: Plan, uav: int, s: int) -> float:
    """How much a UAV's rate in slot s counts in its utility, as :func:`slot_weight`; 0 if it does not arrive."""
    if not arrives(state, game, plan, uav):
        return 0.0
    slots = plan.slots[uav]
    flown = state.slot[game, uav] + slots
    return slot_weight(rules.ema_beta, slots - s, state.min_slots[game, uav], flown, bias_horizon(rules, flown))


@njit
def planned_utilities_mbps(rules: Rules, state: State, game: int, plan: Plan) -> Floats:
    """Utility U_i of every UAV in Mbps if all fly as planned [N]; 0 for one that is not flying or does not arrive."""
    loads = planned_loads(rules, plan, -1)
    utilities = np.zeros(len(plan.slots))
    for i in range(len(plan.slots)):
        if not arrives(state, game, plan, i):
            continue
        slots = plan.slots[i]
        ema_mbps = state.ema_rate_mbps[game, i]
        for s in range(1, slots + 1):
            voxel = voxel_of(plan.voxels, i, s)
            b = rules.cell[voxel]
            rate_mbps = achievable_rate_mbps(rb_share(rules.num_rbs[b], loads[s, b]), rules.rb_rate_mbps[voxel])
            ema_mbps = ema_rate(ema_mbps, rate_mbps, rules.ema_beta)
        flown = state.slot[game, i] + slots
        corrected_mbps = corrected_rate(ema_mbps, rules.ema_beta, bias_horizon(rules, flown))
        utilities[i] = utility(corrected_mbps, state.min_slots[game, i], flown)
    return utilities


@njit
def planned_collisions(rules: Rules, plan: Plan) -> Ints:
    """How often each UAV violates Eq. (4), eq:collision, counted by slot and pair [N]; each counts for both UAVs."""
    num_uavs, num_slots, _ = plan.voxels.shape
    collisions = np.zeros(num_uavs, dtype=np.int64)
    for s in range(1, num_slots):
        for i in range(num_uavs):
            for j in range(i):
                one_flies = s <= plan.slots[i] or s <= plan.slots[j]
                both_there = is_there(rules, plan, i, s) and is_there(rules, plan, j, s)
                if one_flies and both_there and voxel_of(plan.voxels, i, s) == voxel_of(plan.voxels, j, s):
                    collisions[i] += 1
                    collisions[j] += 1
    return collisions


@njit
def others_in(rules: Rules, state: State, game: int, plan: Plan, uav: int, count_effects: bool) -> Surroundings:
    """What one UAV meets if all others fly as planned.

    :param count_effects: whether to work out what its presence in a cell costs the others; otherwise it is 0
    """
    num_uavs, num_slots, _ = plan.voxels.shape
    loads = planned_loads(rules, plan, uav)
    effects_mbps = np.zeros(loads.shape)
    voxels = np.empty((num_uavs - 1, num_slots, 3), dtype=np.int64)
    slots = np.empty(num_uavs - 1, dtype=np.int64)
    for k in range(num_uavs - 1):
        j = k if k < uav else k + 1
        voxels[k], slots[k] = plan.voxels[j], plan.slots[j]
        if not count_effects:
            continue
        for s in range(1, slots[k] + 1):
            voxel = voxel_of(plan.voxels, j, s)
            b = rules.cell[voxel]
            with_uav, without_uav = rb_share(rules.num_rbs[b], loads[s, b] + 1), rb_share(rules.num_rbs[b], loads[s, b])
            lost_mbps = achievable_rate_mbps(with_uav - without_uav, rules.rb_rate_mbps[voxel])
            effects_mbps[s, b] += planned_weight(rules, state, game, plan, j, s) * lost_mbps
    return Surroundings(loads, effects_mbps, voxels, slots)


@njit
def nobody(num_slots: int, num_gbs: int) -> Surroundings:
    """What a UAV meets that is alone in the network, for ``num_slots`` slots ahead."""
    shape = (num_slots + 1, num_gbs)
    none = np.zeros((0, num_slots + 1, 3), dtype=np.int64)
    return Surroundings(np.zeros(shape, dtype=np.int64), np.zeros(shape), none, np.zeros(0, dtype=np.int64))
