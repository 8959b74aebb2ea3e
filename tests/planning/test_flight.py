"""The best flight of one UAV: worked out by hand in a corridor, and laws of the recursion.

In the corridor (tests/envs/corridor.py) voxels 0 and 1 are one cell, voxels 2 and 3 the other. A UAV alone in its cell
has 10 Mbps, each of two has 4. A UAV flies one voxel a slot; beta is 1/2. The one looked at flies from voxel 0 to
voxel 2, so T_min = 2. With rates R_1, R_2, ... its utility is

- after 2 slots (R_1/4 + R_2/2) / (1 - 1/4) * 2/2 = (R_1 + 2 R_2) / 3,
- after 3 slots (R_1/8 + R_2/4 + R_3/2) / (1 - 1/8) * 2/3 = (R_1 + 2 R_2 + 4 R_3) * 2/21,
- after 4 slots (R_1/16 + R_2/8 + R_3/4 + R_4/2) / (1 - 1/16) * 2/4 = (R_1 + 2 R_2 + 4 R_3 + 8 R_4) / 30.
"""

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from lawn_sb3.game import Missions, Simulator
from lawn_sb3.game.airspace import is_inside, stop_at
from lawn_sb3.game.payoff import slot_weight
from lawn_sb3.planning.flight import (
    Flight,
    Surroundings,
    best_flight,
    collision_price_mbps,
    longest_flight,
    peak_rate_mbps,
)
from lawn_sb3.planning.plan import Plan, nobody, others_in
from tests.envs.corridor import CORRIDOR
from tests.game.random_play import SEEDS, scenarios
from tests.planning.tiny import begun_games, random_flights

GAMES = begun_games(scenarios(max_slots=12))
PRICE_MBPS = 1.0 + 2 * 10.0
"""Of a collision in the corridor: two UAVs, 10 Mbps at best."""


def corridor_game(goal_x: int = 2, **changes: Any) -> Simulator:
    """UAV 0 is to fly from voxel 0 to its goal, UAV 1 from voxel 3 to 0."""
    simulator = Simulator(CORRIDOR.changed(**changes))
    simulator.reset(missions=Missions(np.array([[0, 0, 0], [3, 0, 0]]), np.array([[goal_x, 0, 0], [0, 0, 0]])))
    return simulator


def best_among(
    *other_x: int, max_slots: int = 3, slack: int = 9, effect_mbps: float = 0.0, **changes: Any
) -> tuple[int, Any, list[int]]:
    """Slots, worth and path of the best flight, the other UAV being at these x in slots 1, 2, ... until it is done.

    :param effect_mbps: what being in the cell of voxel 2 in slot 2 changes for others
    """
    simulator = corridor_game(max_slots=max_slots, **changes)
    voxels = np.zeros((2, max_slots + 1, 3), dtype=np.int64)
    voxels[1, :, 0] = [3, *other_x, *[other_x[-1]] * (max_slots - len(other_x))]
    plan = Plan(voxels, np.array([0, len(other_x)]))
    around = others_in(simulator.rules, simulator.state, 0, plan, 0, False)
    around.effects_mbps[2, 1] = effect_mbps
    path = np.empty_like(voxels[0])
    flight = best_flight(simulator.rules, simulator.state, 0, 0, around, slack, path)
    return flight.slots, flight.worth_mbps, path[:, 0].tolist()


def test_it_flies_straight_where_the_other_cell_is_free() -> None:
    # The other is at 3 in slot 1, then gone. Rates 10 and 10, so (10 + 20) / 3 = 10.
    assert best_among(3) == (2, pytest.approx(10.0), [0, 1, 2, 2])


def test_it_waits_for_a_cell_to_empty_where_that_pays() -> None:
    # The other is at 3 in slots 1 and 2. At once: rates 10 and 4, so (10 + 8) / 3 = 6. A slot later it is gone: rates
    # 10, 10, 10, so 70 * 2/21 = 20/3.
    slots, worth_mbps, path = best_among(3, 3)
    assert (slots, worth_mbps, path[2:]) == (3, pytest.approx(20 / 3), [1, 2])
    assert best_among(3, 3, slack=0) == (2, pytest.approx(6.0), [0, 1, 2, 2])


def test_waiting_does_not_pay_where_the_other_stays() -> None:
    # It keeps its RBs after slot 2. A slot later: rates 10, 10, 4, so (10 + 20 + 16) * 2/21 = 92/21 = 4.4, less than 6.
    assert best_among(3, 3, arrived_uav="stays")[:2] == (2, pytest.approx(6.0))


def test_a_bias_correction_over_the_deadline_divides_short_flights_by_too_much() -> None:
    # All flight times divide by 1 - 1/8. Two slots: (10/4 + 10/2) / (7/8) = 60/7 = 8.6. Three: the 20/3 of above.
    assert best_among(3, bias_horizon="deadline")[:2] == (2, pytest.approx(60 / 7))
    # With rates 10 and 4: (10/4 + 4/2) / (7/8) = 36/7 = 5.1.
    assert best_among(3, 3, bias_horizon="deadline", slack=0)[:2] == (2, pytest.approx(36 / 7))
    assert best_among(3, 3, bias_horizon="deadline")[:2] == (3, pytest.approx(20 / 3))


def test_it_waits_where_arriving_would_cost_others_more() -> None:
    # The other is at 3 all the time: 6 at once, 92/21 = 4.4 a slot later. If being in its cell in slot 2 costs others
    # 2 Mbps, at once is worth 4.
    assert best_among(3, 3, 3)[:2] == (2, pytest.approx(6.0))
    assert best_among(3, 3, 3, effect_mbps=-2.0)[:2] == (3, pytest.approx(92 / 21))


def test_avoiding_a_collision_comes_before_the_utility() -> None:
    # The other is at 1 in slot 1 and at 0 in slot 2. Through it: rates 4 and 10, so (4 + 20) / 3 = 8, but a collision.
    # Behind it: 4, 4 and 10, so (4 + 8 + 40) * 2/21 = 104/21 = 5.0.
    assert best_among(1, 0) == (3, pytest.approx(104 / 21), [0, 0, 1, 2])
    assert best_among(1, 0, slack=0) == (2, pytest.approx(8.0 - PRICE_MBPS), [0, 1, 2, 2])


def test_it_stays_out_of_the_way_where_it_will_stay() -> None:
    # The other is at 3, but at 2 in slot 3. A UAV that leaves on arrival is gone by then: 6. One that stays must come
    # later: slot 4, with rates 10, 10, 10, 4, so (10 + 20 + 40 + 32) / 30 = 3.4.
    assert best_among(3, 3, 2, 3, max_slots=4)[:2] == (2, pytest.approx(6.0))
    assert best_among(3, 3, 2, 3, max_slots=4, arrived_uav="stays")[:2] == (4, pytest.approx(3.4))


@pytest.mark.parametrize(
    ("slack", "hovered", "max_slots", "longest"),
    [
        (0, 0, 9, 2),  # T_min
        (3, 0, 9, 5),
        (3, 1, 9, 4),  # five in all, one of which is over
        (0, 1, 9, 2),  # nothing left of T_min + 0 but one slot: the shortest from here
        (9, 1, 5, 4),  # the deadline
        (0, 4, 5, 1),  # the deadline, one slot short
    ],
)
def test_the_longest_flight_has_the_slack_but_not_more_than_the_deadline(
    slack: int, hovered: int, max_slots: int, longest: int
) -> None:
    simulator = corridor_game(max_slots=max_slots)
    for _ in range(hovered):
        simulator.step(np.zeros((1, 2), dtype=np.int64))
    assert longest_flight(simulator.rules, simulator.state, 0, 0, slack) == longest


def test_a_deadline_out_of_reach_gives_a_flight_of_no_slots() -> None:
    simulator = corridor_game()
    path = np.empty((4, 3), dtype=np.int64)
    for left, slots in [(3, 2), (2, 2), (1, 0)]:
        around = nobody(left, 2)
        assert best_flight(simulator.rules, simulator.state, 0, 0, around, 9, path[: left + 1]).slots == slots
        simulator.step(np.zeros((1, 2), dtype=np.int64))


def test_moves_are_told_apart_in_the_largest_action_set() -> None:
    # v_max = 30 has 37,881 actions; three slots of 30 voxels each are the only way to be in time.
    simulator = corridor_game(goal_x=90, width_voxels=91, max_voxel_steps=30)
    path = np.empty((4, 3), dtype=np.int64)
    assert best_flight(simulator.rules, simulator.state, 0, 0, nobody(3, 2), 0, path).slots == 3
    assert path[:, 0].tolist() == [0, 30, 60, 90]


@given(
    beta=st.floats(0.01, 0.99),
    least=st.integers(1, 30),
    more=st.integers(0, 30),
    spare=st.integers(0, 30),
    rate_mbps=st.floats(0.1, 100.0),
)
def test_weights_of_a_constant_rate_sum_to_its_utility(
    beta: float, least: int, more: int, spare: int, rate_mbps: float
) -> None:
    flown = least + more
    weights = [
        [slot_weight(beta, left, least, flown, horizon) for left in range(flown)] for horizon in (flown, flown + spare)
    ]
    to_completion, to_deadline = rate_mbps * np.sum(weights, axis=1)
    # The EMA of a constant rate r is r (1 - (1 - beta)^T), which the correction over T_i makes r again.
    assert to_completion == pytest.approx(rate_mbps * least / flown)
    short = (1 - (1 - beta) ** flown) / (1 - (1 - beta) ** (flown + spare))
    assert to_deadline == pytest.approx(rate_mbps * short * least / flown)


def flight_in(simulator: Simulator, around: Surroundings, slack: int) -> tuple[Flight, np.ndarray]:
    path = np.empty((len(around.loads), 3), dtype=np.int64)
    return best_flight(simulator.rules, simulator.state, 0, first_flying(simulator), around, slack, path), path


def first_flying(simulator: Simulator) -> int:
    return int(simulator.state.flying[0].argmax())


def random_surroundings(simulator: Simulator, seed: int) -> Surroundings:
    """Random flights of the others, and anything for what being in a cell changes for them."""
    rng, rules = np.random.default_rng(seed), simulator.rules
    around = others_in(rules, simulator.state, 0, random_flights(simulator, rng), first_flying(simulator), False)
    effects_mbps = -peak_rate_mbps(rules) * rng.random(around.effects_mbps.shape)
    return around._replace(effects_mbps=effects_mbps * rng.integers(2))


@given(simulator=GAMES, seed=SEEDS, slack=st.integers(0, 12))
@settings(max_examples=80, deadline=None)
def test_a_flight_keeps_to_the_rules_and_ends_at_the_destination(simulator: Simulator, seed: int, slack: int) -> None:
    flight, path = flight_in(simulator, random_surroundings(simulator, seed), slack)
    assume(flight.slots > 0)
    rules, state, uav = simulator.rules, simulator.state, first_flying(simulator)
    goal = tuple(state.destination[0, uav].tolist())
    way = [tuple(voxel) for voxel in path.tolist()]
    assert way[0] == tuple(state.position[0, uav].tolist())
    assert set(way[flight.slots :]) == {goal}
    assert goal not in way[: flight.slots]
    for voxel, following in itertools.pairwise(way[: flight.slots + 1]):
        assert np.abs(np.subtract(following, voxel)).sum() <= rules.max_voxel_steps
        assert is_inside(following, rules.grid)
        if rules.fly_through:
            assert stop_at(voxel, following, goal) == following
    simulator.step(np.full((1, len(state.flying[0])), flight.action))
    assert simulator.state.position[0, uav].tolist() == list(way[1])


@given(simulator=GAMES, seed=SEEDS)
@settings(max_examples=80, deadline=None)
def test_more_slack_is_never_worth_less(simulator: Simulator, seed: int) -> None:
    around = random_surroundings(simulator, seed)
    worths_mbps = [flight_in(simulator, around, slack)[0].worth_mbps for slack in range(simulator.rules.max_slots + 1)]
    assert worths_mbps == sorted(worths_mbps)


@given(simulator=begun_games(scenarios(max_slots=12, arrived_uav="stays")), seed=SEEDS)
@settings(max_examples=80, deadline=None)
def test_nothing_is_lost_where_the_scan_of_flight_times_ends_early(simulator: Simulator, seed: int) -> None:
    # A UAV that stays on arrival is in some cell in every slot, whatever it does. A toll on all cells alike changes no
    # flight's rank, only the worth of all of them; so high that all are below zero, it never lets the scan end early.
    around = random_surroundings(simulator, seed)
    toll_mbps = 2.0 * collision_price_mbps(simulator.rules, len(simulator.state.flying[0]))
    tolled = around._replace(effects_mbps=around.effects_mbps - toll_mbps)
    early, _ = flight_in(simulator, around, simulator.rules.max_slots)
    late, _ = flight_in(simulator, tolled, simulator.rules.max_slots)
    assume(early.slots > 0)
    paid_mbps = toll_mbps * (len(around.loads) - 1)
    assert late.worth_mbps + paid_mbps == pytest.approx(early.worth_mbps, abs=1e-12 * paid_mbps)
