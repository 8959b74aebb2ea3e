"""Best responses to the others' trajectories, for a UAV's own utility or for the welfare, and where they lead."""

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.compiled import njit
from lawn_sb3.game.state import Rules, State
from lawn_sb3.planning.flight import Flight, best_flight, collision_price_mbps
from lawn_sb3.planning.plan import Plan, others_in, planned_collisions, planned_utilities_mbps

Aim = Literal["utility", "welfare"]

GAIN = 1e-9
"""Gains below this share of the peak rate count as rounding: nobody changes its trajectory for them."""

MOST_ROUNDS = 200
"""Rounds of responses after which a search gives up; four UAVs take two or three."""


class Settled(NamedTuple):
    """Where letting the UAVs respond in turn has led."""

    rounds: int
    """Rounds played."""
    is_fixed: bool
    """Whether nobody changed its trajectory in the last round."""
    period: int = 0
    """Rounds after which the joint plans repeat, where an earlier one came back."""


class Responses(NamedTuple):
    """The best response of every UAV of a game to the others' trajectories."""

    utilities_mbps: NDArray[np.float64]  # [N] utility that it would have given
    slots: NDArray[np.int64]  # [N] slots it takes; 0 if the destination is out of reach


@njit
def best_response(
    rules: Rules, state: State, game: int, plan: Plan, uav: int, for_welfare: bool, slack: int
) -> tuple[Flight, NDArray[np.int64]]:
    """The best flight of one UAV against the trajectories of all others, exactly.

    :param plan: the others' trajectories; the UAV's own is ignored
    :param for_welfare: add what each of its moves changes in the others' utilities
    :param slack: slots beyond T_i^min that the flight may take; the plan has room for them
    :return: the flight, and its voxels [S + 1, 3]; these mean nothing if the flight takes 0 slots
    """
    path = np.empty(plan.voxels.shape[1:], dtype=np.int64)
    around = others_in(rules, state, game, plan, uav, for_welfare)
    return best_flight(rules, state, game, uav, around, slack, path), path


@njit
def best_responses(rules: Rules, state: State, game: int, plan: Plan) -> Responses:
    """What every UAV could have by changing its own trajectory alone, exactly, over all flight times up to T_max.

    Regret is this less what it had.

    :param state: the state of all games, at their first slot
    :param plan: the trajectories flown, with room for T_max slots; left as it is
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


@njit
def plan_worth_mbps(rules: Rules, state: State, game: int, plan: Plan, uav: int, for_welfare: bool) -> float:
    """What a joint plan is worth to one UAV in Mbps, or to all: utilities less a price on collisions.

    U_i - p c_i, or W - p (collisions of all pairs); the price p is more than anybody can gain by a collision
    """
    utilities = planned_utilities_mbps(rules, state, game, plan)
    price_mbps = collision_price_mbps(rules, len(utilities))
    collisions = planned_collisions(rules, plan)
    if for_welfare:
        return float(utilities.sum() - price_mbps * collisions.sum() / 2.0)
    return float(utilities[uav] - price_mbps * collisions[uav])


@njit
def respond_in_turn(rules: Rules, state: State, game: int, plan: Plan, for_welfare: bool, slack: int) -> int:
    """Let every UAV change to its best response if that gains anything, one after the other.

    A UAV that cannot be at its destination in time keeps its trajectory.

    :param plan: the joint plan; written
    :param for_welfare: respond for the welfare instead of one's own utility
    :return: how many UAVs have changed their trajectories
    """
    least_gain_mbps = GAIN * collision_price_mbps(rules, 1)
    changed = 0
    for i in range(len(plan.slots)):
        if not state.flying[game, i]:
            continue
        before_mbps = plan_worth_mbps(rules, state, game, plan, i, for_welfare)
        flight, path = best_response(rules, state, game, plan, i, for_welfare, slack)
        if flight.slots == 0:
            continue
        old_voxels, old_slots = plan.voxels[i].copy(), plan.slots[i]
        plan.voxels[i], plan.slots[i] = path, flight.slots
        if plan_worth_mbps(rules, state, game, plan, i, for_welfare) > before_mbps + least_gain_mbps:
            changed += 1
        else:
            plan.voxels[i], plan.slots[i] = old_voxels, old_slots
    return changed


def settle(
    rules: Rules, state: State, game: int, plan: Plan, aim: Aim, slack: int, most_rounds: int = MOST_ROUNDS
) -> Settled:
    """Let the UAVs respond in turn until nobody changes, until a joint plan comes back, or for ``most_rounds``.

    For the welfare, every change raises the sum that all aim at, so there is always an end; for one's own utility there
    need not be one. There are finitely many joint plans, so without a fixed point one of them must come back.

    :param plan: the joint plan to begin with; written
    :param aim: what every UAV responds for
    :param most_rounds: when to give up
    :return: how it ended
    """
    seen: dict[bytes, int] = {}
    for rounds in range(most_rounds):
        key = plan.voxels.tobytes() + plan.slots.tobytes()
        if key in seen:
            return Settled(rounds, False, rounds - seen[key])
        seen[key] = rounds
        if respond_in_turn(rules, state, game, plan, aim == "welfare", slack) == 0:
            return Settled(rounds + 1, True)
    return Settled(most_rounds, False)
