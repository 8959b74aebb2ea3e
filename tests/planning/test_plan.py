"""Joint plans: worth what the simulator pays when they are flown, and refused where a mission cannot be flown."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from lawn_sb3.errors import UserError
from lawn_sb3.game import Missions, Simulator
from lawn_sb3.planning.plan import Plan, empty_plan, planned_collisions, planned_utilities_mbps
from lawn_sb3.planning.routes import routes_alone, straight_routes
from lawn_sb3.scenario import PRESETS
from tests.game.random_play import SEEDS, scenarios
from tests.planning.tiny import (
    Situation,
    all_can_arrive,
    among,
    begun_games,
    best_of_all,
    fly_plan,
    random_flights,
    situations,
)

PAPER = PRESETS["paper"]
GAMES = begun_games(scenarios(max_slots=12))
SLACKS = st.integers(0, 12)


def lone_game(origin: tuple[int, int, int], destination: tuple[int, int, int], max_voxel_steps: int) -> Simulator:
    simulator = Simulator(PAPER.changed(num_uavs=1, max_voxel_steps=max_voxel_steps))
    simulator.reset(missions=Missions(np.array([origin]), np.array([destination])))
    return simulator


def assert_flown_as_planned(simulator: Simulator, plan: Plan) -> None:
    flown = fly_plan(simulator, plan)
    np.testing.assert_array_equal(flown.voxels[:, 0].swapaxes(0, 1), plan.voxels)
    np.testing.assert_array_equal(flown.slots[0], plan.slots)
    utilities_mbps = planned_utilities_mbps(simulator.rules, simulator.state, 0, plan)
    np.testing.assert_allclose(utilities_mbps, flown.utilities_mbps[0], rtol=1e-9)
    np.testing.assert_array_equal(planned_collisions(simulator.rules, plan), flown.collisions[0])


@given(simulator=GAMES, seed=SEEDS)
@settings(max_examples=60, deadline=None)
def test_random_flights_are_worth_what_the_simulator_pays(simulator: Simulator, seed: int) -> None:
    assert_flown_as_planned(simulator, random_flights(simulator, np.random.default_rng(seed)))


@given(simulator=GAMES, seed=SEEDS, slack=SLACKS)
@settings(max_examples=60, deadline=None)
def test_straight_routes_take_the_least_time_and_are_flown_as_planned(
    simulator: Simulator, seed: int, slack: int
) -> None:
    assume(all_can_arrive(simulator))
    state, rules = simulator.state, simulator.rules
    plan = straight_routes(rules, state, 0, slack, np.random.default_rng(seed))
    assert_flown_as_planned(simulator, plan)
    steps = np.abs(state.destination[0] - state.position[0]).sum(axis=-1)
    np.testing.assert_array_equal(plan.slots, np.where(state.flying[0], np.ceil(steps / rules.max_voxel_steps), 0))
    np.testing.assert_array_equal(fly_plan(simulator, plan).arrived, state.flying)


@given(simulator=GAMES, slack=SLACKS)
@settings(max_examples=60, deadline=None)
def test_routes_as_if_alone_are_flown_as_planned(simulator: Simulator, slack: int) -> None:
    assume(all_can_arrive(simulator))
    plan = routes_alone(simulator.rules, simulator.state, 0, slack)
    assert_flown_as_planned(simulator, plan)
    np.testing.assert_array_equal(fly_plan(simulator, plan).arrived, simulator.state.flying)


@given(situation=situations())
@settings(max_examples=60, deadline=None)
def test_no_flight_at_all_beats_the_route_as_if_alone_where_nobody_else_is(situation: Situation) -> None:
    simulator, _, uav, slack = situation
    assume(all_can_arrive(simulator))
    alone, route = among(simulator, routes_alone(simulator.rules, simulator.state, 0, slack), [uav])
    best = best_of_all(Situation(alone, route, 0, slack), for_welfare=False)
    assert best is not None
    assert best[0] == 0
    assert best[1] == pytest.approx(fly_plan(alone, route).utilities_mbps[0, 0], rel=1e-9)


@given(situation=situations(num_uavs=2))
@settings(max_examples=60, deadline=None)
def test_two_uavs_collide_in_the_slots_that_the_simulator_marks(situation: Situation) -> None:
    # With two UAVs there is one pair. The simulator marks those in the air alone: the one that flies longer has all.
    marked = fly_plan(situation.simulator, situation.plan).marked[0].max()
    assert planned_collisions(situation.rules, situation.plan).tolist() == [marked, marked]


def test_all_moves_that_keep_the_least_time_are_equally_likely() -> None:
    # Four steps along x with v_max = 3: two slots, so the first must leave 3 steps or fewer. Of the moves that do, five
    # stay inside the airspace: (1, 0, 0), (2, 0, 0), (3, 0, 0), (2, 1, 0) and (2, 0, 1).
    simulator, draws, rng = lone_game((0, 0, 0), (4, 0, 0), 3), 4_000, np.random.default_rng(0)
    plans = [straight_routes(simulator.rules, simulator.state, 0, 0, rng) for _ in range(draws)]
    counts = Counter(tuple(plan.voxels[0, 1].tolist()) for plan in plans)
    assert set(counts) == {(1, 0, 0), (2, 0, 0), (3, 0, 0), (2, 1, 0), (2, 0, 1)}
    # A count has mean 800 and standard deviation sqrt(4,000 * 0.2 * 0.8) = 25.
    assert max(abs(count - draws / 5) for count in counts.values()) < 5 * 25


def test_all_ways_round_a_cube_are_equally_likely() -> None:
    # One step a slot from corner to opposite corner: 3 first moves, then 2, then 1, so 6 routes.
    simulator, draws, rng = lone_game((0, 0, 0), (1, 1, 1), 1), 3_000, np.random.default_rng(0)
    counts = Counter(
        straight_routes(simulator.rules, simulator.state, 0, 0, rng).voxels.tobytes() for _ in range(draws)
    )
    assert len(counts) == 6
    # A count has mean 500 and standard deviation sqrt(3,000 * 1/6 * 5/6) = 20.
    assert max(abs(count - draws / 6) for count in counts.values()) < 5 * 20


@pytest.mark.parametrize(("slack", "max_slots", "room"), [(0, 100, 3), (5, 100, 8), (5, 6, 6)])
def test_an_empty_plan_has_room_for_the_longest_flight(slack: int, max_slots: int, room: int) -> None:
    # Missions of 1 and of ceil(9 / 3) = 3 slots at least: the longer one, and the slack, but no more than T_max.
    simulator = Simulator(PAPER.changed(num_uavs=2, max_slots=max_slots))
    simulator.reset(missions=Missions(np.array([[0, 0, 0], [0, 1, 0]]), np.array([[1, 0, 0], [9, 1, 0]])))
    plan = empty_plan(simulator.rules, simulator.state, 0, slack)
    assert plan.voxels.shape == (2, room + 1, 3)
    assert plan.slots.tolist() == [0, 0]


def test_a_mission_that_cannot_be_flown_in_time_is_refused_naming_the_uav() -> None:
    simulator = Simulator(PAPER.changed(num_uavs=2, max_slots=3), num_games=2)
    origins, destinations = np.array([[0, 0, 0], [9, 1, 0]]), np.array([[1, 0, 0], [0, 1, 0]])
    simulator.reset(missions=Missions(origins, destinations))
    assert empty_plan(simulator.rules, simulator.state, 1, 5).voxels.shape[1] == 4
    simulator.step(np.zeros((2, 2), dtype=np.int64))  # all hover
    expected = (
        "UAV 1 of game 1 cannot fly its mission: from [9, 1, 0] to [0, 1, 0] takes at least 3 slots, "
        "and 2 are left of T_max = 3"
    )
    for plan in (empty_plan, routes_alone):
        with pytest.raises(UserError) as refusal:
            plan(simulator.rules, simulator.state, 1, 5)
        assert str(refusal.value) == expected


@given(simulator=begun_games(scenarios()), slack=SLACKS)
@settings(max_examples=60, deadline=None)
def test_a_plan_is_refused_exactly_where_somebody_cannot_arrive(simulator: Simulator, slack: int) -> None:
    if all_can_arrive(simulator):
        empty_plan(simulator.rules, simulator.state, 0, slack)
    else:
        with pytest.raises(UserError):
            empty_plan(simulator.rules, simulator.state, 0, slack)
