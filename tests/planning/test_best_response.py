"""Best responses: exactly what trying every flight in the simulator finds, and laws of what they lead to."""

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from lawn_sb3.game import Simulator
from lawn_sb3.planning.best_response import Aim, best_response, plan_worth_mbps, respond_in_turn, settle
from lawn_sb3.planning.flight import Flight, collision_price_mbps
from lawn_sb3.planning.plan import Plan
from tests.game.random_play import SEEDS
from tests.planning.tiny import Situation, among, best_of_all, fly_plan, situations

AIMS: list[Aim] = ["utility", "welfare"]
CLOSE: dict[str, Any] = {"rel": 1e-9, "abs": 1e-12}
"""Rounding; rates are 0, where a UAV gets no RB, or far above 1e-12 Mbps."""


def respond(situation: Situation, for_welfare: bool) -> tuple[Flight, Plan]:
    """The best response, and the plan with it in place of what the UAV would have done."""
    _, plan, uav, slack = situation
    flight, path = best_response(situation.rules, situation.state, 0, plan, uav, for_welfare, slack)
    changed = copied(plan)
    changed.voxels[uav], changed.slots[uav] = path, flight.slots
    return flight, changed


def copied(plan: Plan) -> Plan:
    return Plan(plan.voxels.copy(), plan.slots.copy())


def without(situation: Situation, uav: int) -> tuple[Simulator, Plan]:
    simulator, plan, _, _ = situation
    return among(simulator, plan, [i for i in range(len(plan.slots)) if i != uav])


@pytest.mark.parametrize("aim", AIMS)
@given(data=st.data())
@settings(max_examples=80, deadline=None)
def test_no_flight_at_all_beats_the_best_response(aim: Aim, data: st.DataObject) -> None:
    situation = data.draw(situations())
    best = best_of_all(situation, aim == "welfare")
    flight, plan = respond(situation, aim == "welfare")
    assert (flight.slots == 0) == (best is None)
    if best is not None:
        flown, uav = fly_plan(situation.simulator, plan), situation.uav
        assert (flown.arrived[0, uav], flown.slots[0, uav]) == (True, flight.slots)
        worth_mbps = flown.welfare_mbps[0] if aim == "welfare" else flown.utilities_mbps[0, uav]
        assert (flown.collisions[0, uav], worth_mbps) == (best[0], pytest.approx(best[1], **CLOSE))


@pytest.mark.parametrize("aim", AIMS)
@given(situation=situations(), seed=SEEDS)
@settings(max_examples=40, deadline=None)
def test_what_the_uav_would_have_done_itself_does_not_matter(aim: Aim, situation: Situation, seed: int) -> None:
    rng = np.random.default_rng(seed)
    flight, plan = respond(situation, aim == "welfare")
    elsewhere = copied(situation.plan)
    elsewhere.voxels[situation.uav] = rng.integers(situation.rules.grid, size=elsewhere.voxels.shape[1:])
    elsewhere.slots[situation.uav] = rng.integers(elsewhere.voxels.shape[1])
    again, same = respond(situation._replace(plan=elsewhere), aim == "welfare")
    assert again == flight
    if flight.slots > 0:
        np.testing.assert_array_equal(same.voxels[situation.uav], plan.voxels[situation.uav])


@given(situation=situations())
@settings(max_examples=80, deadline=None)
def test_the_worth_for_the_utility_is_what_the_simulator_pays_less_the_price_of_collisions(
    situation: Situation,
) -> None:
    flight, plan = respond(situation, False)
    assume(flight.slots > 0)
    flown, uav = fly_plan(situation.simulator, plan), situation.uav
    price_mbps = collision_price_mbps(situation.rules, len(plan.slots)) * flown.collisions[0, uav]
    assert flight.worth_mbps == pytest.approx(flown.utilities_mbps[0, uav] - price_mbps, **CLOSE)


@given(situation=situations())
@settings(max_examples=80, deadline=None)
def test_the_worth_for_the_welfare_is_the_welfare_with_the_uav_less_that_without_it(situation: Situation) -> None:
    flight, plan = respond(situation, True)
    assume(flight.slots > 0)
    flown, uav = fly_plan(situation.simulator, plan), situation.uav
    gained_mbps = flown.welfare_mbps[0] - fly_plan(*without(situation, uav)).welfare_mbps[0]
    price_mbps = collision_price_mbps(situation.rules, len(plan.slots)) * flown.collisions[0, uav]
    assert flight.worth_mbps == pytest.approx(gained_mbps - price_mbps, rel=1e-9, abs=1e-9)


@given(situation=situations())
@settings(max_examples=80, deadline=None)
def test_a_best_response_is_worth_no_less_with_one_uav_fewer(situation: Situation) -> None:
    flight, _ = respond(situation, False)
    for other in set(range(len(situation.plan.slots))) - {situation.uav}:
        simulator, plan = without(situation, other)
        fewer = Situation(simulator, plan, situation.uav - (other < situation.uav), situation.slack)
        assert respond(fewer, False)[0].worth_mbps >= flight.worth_mbps * (1 - 1e-12)


@pytest.mark.parametrize("aim", AIMS)
@given(situation=situations())
@settings(max_examples=80, deadline=None)
def test_a_plan_s_worth_is_what_the_simulator_makes_of_it(aim: Aim, situation: Situation) -> None:
    _, plan, uav, _ = situation
    flown = fly_plan(situation.simulator, plan)
    mbps = flown.welfare_mbps[0] if aim == "welfare" else flown.utilities_mbps[0, uav]
    count = flown.collisions.sum() / 2 if aim == "welfare" else flown.collisions[0, uav]
    worth_mbps = plan_worth_mbps(situation.rules, situation.state, 0, plan, uav, aim == "welfare")
    assert worth_mbps == pytest.approx(
        mbps - collision_price_mbps(situation.rules, len(plan.slots)) * count, rel=1e-9, abs=1e-9
    )


@given(situation=situations())
@settings(max_examples=80, deadline=None)
def test_responding_for_the_welfare_never_lowers_it_nor_adds_collisions(situation: Situation) -> None:
    simulator, old, _, slack = situation
    plan = copied(old)
    changed = respond_in_turn(situation.rules, situation.state, 0, plan, True, slack)
    assert changed == (plan.voxels != old.voxels).any(axis=(1, 2)).sum()
    before, after = fly_plan(simulator, old), fly_plan(simulator, plan)
    fewer = before.collisions.sum() - after.collisions.sum()
    assert fewer >= 0
    if fewer == 0 and changed > 0:
        assert after.welfare_mbps[0] > before.welfare_mbps[0]


@given(situation=situations())
@settings(max_examples=40, deadline=None)
def test_who_cannot_arrive_any_more_keeps_its_trajectory(situation: Situation) -> None:
    old, state = situation.plan, situation.state
    plan = copied(old)
    respond_in_turn(situation.rules, state, 0, plan, False, situation.slack)
    steps = np.abs(state.destination[0] - state.position[0]).sum(axis=-1)
    out_of_reach = steps > situation.rules.max_voxel_steps * (situation.rules.max_slots - state.slot[0])
    np.testing.assert_array_equal(plan.voxels[out_of_reach], old.voxels[out_of_reach])
    np.testing.assert_array_equal(plan.slots[out_of_reach], old.slots[out_of_reach])


@given(situation=situations())
@settings(max_examples=80, deadline=None)
def test_the_welfare_always_settles(situation: Situation) -> None:
    assert settle(situation.rules, situation.state, 0, copied(situation.plan), "welfare", situation.slack).is_fixed
