"""Searches by iterated best response: what they find cannot be improved by one UAV alone, and where there is no end."""

import itertools
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import assume, given, settings
from numpy.typing import NDArray

from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.game import Missions, draw_missions
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning import EquilibriumPlayer, WelfarePlayer, WorstEquilibriumPlayer, equilibrium
from lawn_sb3.planning.best_response import GAIN, Settled, best_response, plan_worth_mbps, settle
from lawn_sb3.planning.equilibrium import SearchPlayer
from lawn_sb3.planning.flight import DEFAULT_SLACK, best_flight, collision_price_mbps
from lawn_sb3.planning.guarantee import guaranteed_utilities_mbps
from lawn_sb3.planning.plan import Plan, nobody, others_in, planned_utilities_mbps
from lawn_sb3.planning.routes import routes_alone, straight_routes
from lawn_sb3.scenario import PRESETS, Scenario
from tests.envs.corridor import CORRIDOR, DESTINATIONS, ORIGINS
from tests.game.random_play import SEEDS
from tests.planning.tiny import (
    ANY_SLACK,
    Situation,
    actions_of,
    all_can_arrive,
    best_of_all,
    every_flight,
    fly,
    fly_plan,
    situations,
    tiny_scenarios,
)

PAPER = PRESETS["paper"]

# Two UAVs cross a corridor of two cells, from voxels 0 and 1 in cell 0 to voxels 2 and 3 in cell 1, two voxels a slot:
# T_min is 1 and T_max is 3. An RB carries 2 Mbps everywhere. Cell 0 has 15 RBs, so a UAV has 30 Mbps alone and 7 RBs,
# 14 Mbps, beside the other; cell 1 has 2 RBs, 4 or 2 Mbps. What a UAV chooses is how long to wait in cell 0.
WAITING = CORRIDOR.changed(max_voxel_steps=2, rbs_per_gbs=(15, 2))


def waiting_game() -> Simulator:
    simulator = Simulator(WAITING)
    simulator.reset(missions=Missions(ORIGINS, DESTINATIONS))
    return simulator


def played(player: SearchPlayer, simulator: Simulator, seed: int) -> Plan:
    """Where a player has the UAVs fly, from the first slot of a game until all are done."""
    games = Simulator(simulator.scenario, 1, seed=0, continuation="episode")
    games.restore(simulator.snapshot())
    player.start(games, np.random.default_rng(seed))
    voxels, slots = [games.state.position[0].copy()], np.zeros(simulator.scenario.num_uavs, dtype=np.int64)
    while games.state.flying.any():
        slots += games.state.flying[0]
        games.step(player.act(games))
        voxels.append(games.state.position[0].copy())
    return Plan(np.ascontiguousarray(np.array(voxels).swapaxes(0, 1)), slots)


# What the searches find


@pytest.mark.parametrize("player_type", [EquilibriumPlayer, WorstEquilibriumPlayer, WelfarePlayer])
@given(scenario=tiny_scenarios(), seed=SEEDS)
@settings(max_examples=30)
def test_no_uav_gains_by_any_other_flight(player_type: type[SearchPlayer], scenario: Scenario, seed: int) -> None:
    # Every sequence of actions of every UAV, played against the flights of all others: none that arrives has fewer
    # collisions, nor as few and more utility, or more welfare where that is what the UAVs aim at.
    simulator, player = Simulator(scenario, seed=seed), player_type(starts=3)
    assume(all_can_arrive(simulator))
    plan = played(player, simulator, seed)
    assume(not player.unsettled)
    flown, for_welfare = fly_plan(simulator, plan), player.aim == "welfare"
    rounding_mbps = 2 * GAIN * collision_price_mbps(simulator.rules, 1)
    for i in range(scenario.num_uavs):
        best = best_of_all(Situation(simulator, plan, i, ANY_SLACK), for_welfare)
        assert best is not None
        assert flown.collisions[0, i] == best[0]
        had_mbps = flown.welfare_mbps[0] if for_welfare else flown.utilities_mbps[0, i]
        assert had_mbps >= best[1] - rounding_mbps


def worth_mbps(player: SearchPlayer, simulator: Simulator, seed: int) -> float:
    """Welfare of the joint plan that a player flies, less the price of its collisions."""
    return plan_worth_mbps(simulator.rules, simulator.state, 0, played(player, simulator, seed), 0, True)


@given(scenario=tiny_scenarios(), seed=SEEDS)
@settings(max_examples=40)
def test_worst_equilibrium_is_worth_no_more_than_the_best_of_the_same_searches(scenario: Scenario, seed: int) -> None:
    simulator, best, worst = Simulator(scenario, seed=seed), EquilibriumPlayer(starts=4), WorstEquilibriumPlayer()
    worst.starts = best.starts
    assume(all_can_arrive(simulator))
    assert worth_mbps(worst, simulator, seed) <= worth_mbps(best, simulator, seed)
    assert (worst.searches, worst.cycles, worst.unsettled) == (best.searches, best.cycles, best.unsettled)


@given(scenario=tiny_scenarios(), seed=SEEDS)
@settings(max_examples=40)
def test_the_welfare_ascent_never_ends_below_a_start_nor_below_an_equilibrium_found_from_it(
    scenario: Scenario, seed: int
) -> None:
    simulator, player = Simulator(scenario, seed=seed), WelfarePlayer(starts=4)
    assume(all_can_arrive(simulator))
    rules, state, rng = simulator.rules, simulator.state, np.random.default_rng(seed)
    starts = [routes_alone(rules, state, 0, DEFAULT_SLACK)]
    starts += [straight_routes(rules, state, 0, DEFAULT_SLACK, rng) for _ in range(player.starts - 1)]
    worths_mbps = [plan_worth_mbps(rules, state, 0, start, 0, True) for start in starts]
    worths_mbps.append(worth_mbps(EquilibriumPlayer(starts=4), simulator, seed))
    assert worth_mbps(player, simulator, seed) >= max(worths_mbps) - 1e-9 * abs(max(worths_mbps))
    assert (player.searches, player.cycles, player.unsettled) == (8, 0, 0)  # from each start, and its equilibrium


def test_fixed_points_come_before_the_rest_and_then_the_welfare_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    # Three starts that stay as they are: both UAVs of the waiting game leave in slot 1, 2 or 3. They then get 2, 3 and
    # 50/21 Mbps each, so the second has most welfare and the first least.
    simulator = waiting_game()
    starts = [joint_wait(simulator, slots, slots) for slots in (1, 2, 3)]
    for circling, best, worst in (((), 2, 1), ((2,), 3, 1), ((1, 2), 3, 3), ((1, 2, 3), 2, 1)):
        periods = [slots in circling for slots in (1, 2, 3)]
        for player, chosen in ((EquilibriumPlayer(), best), (WorstEquilibriumPlayer(), worst)):
            settled = iter(Settled(1, not period, int(period)) for period in periods)
            monkeypatch.setattr(equilibrium, "settle", lambda *_, settled=settled: next(settled))
            monkeypatch.setattr(player, "_first_plans", lambda *_: iter(starts))
            assert played(player, simulator, seed=0).slots.tolist() == [chosen, chosen]
            assert (player.searches, player.cycles) == (3, len(circling))
            assert player.unsettled == (len(circling) == 3)


# A game without an equilibrium


def joint_wait(simulator: Simulator, first_slots: int, second_slots: int) -> Plan:
    """Both UAVs of the waiting game wait where they are, and reach their destinations in these slots."""
    slots = np.array([first_slots, second_slots])
    gone = np.arange(WAITING.max_slots + 1) >= slots[:, None]  # [N, S + 1]
    return Plan(np.where(gone[..., None], DESTINATIONS[:, None], ORIGINS[:, None]), slots)


def test_the_longer_you_wait_the_longer_i_wait_until_it_pays_to_go_at_once() -> None:
    # beta = 0.5: the weights of the slots are 1; 1/3 and 2/3; 1/7, 2/7 and 4/7; the utility is the mean over T.
    # The other arrives in slot 1: arriving with it 2 Mbps; in two slots (30 + 2 * 4) / 3 / 2 Mbps; in three
    # (30 + 2 * 30 + 4 * 4) / 7 / 3.
    # The other arrives in slot 2: in one slot 4 Mbps, (14 + 2 * 2) / 6 in two, (14 + 2 * 30 + 4 * 4) / 21 in three.
    # The other arrives in slot 3: 4 Mbps, (14 + 2 * 4) / 6, or (14 + 2 * 14 + 4 * 2) / 21.
    by_hand_mbps = {1: [2, 38 / 6, 106 / 21], 2: [4, 18 / 6, 90 / 21], 3: [4, 22 / 6, 50 / 21]}
    simulator = waiting_game()
    for theirs, expected_mbps in by_hand_mbps.items():
        plans = [joint_wait(simulator, mine, theirs) for mine in (1, 2, 3)]
        utilities_mbps = [fly_plan(simulator, plan).utilities_mbps[0, 0] for plan in plans]
        np.testing.assert_allclose(utilities_mbps, expected_mbps)
        # 1 is best answered by 2, 2 by 3, and 3 by 1: like scissors, paper and stone, nothing answers itself.
        flight, _ = best_response(simulator.rules, simulator.state, 0, plans[0], 0, False, DEFAULT_SLACK)
        assert flight.slots == 1 + np.argmax(expected_mbps) == {1: 2, 2: 3, 3: 1}[theirs]


def all_flights(uav: int) -> list[NDArray[np.int64]]:
    """Every way of a UAV of the waiting game, as voxels [S + 1, 3]."""
    flights, goal = [], DESTINATIONS[uav, 0]
    for way in itertools.product(range(WAITING.width_voxels), repeat=WAITING.max_slots):
        x = np.array([ORIGINS[uav, 0], *way])
        slots = int(np.argmax(x == goal))
        if goal in way and (abs(np.diff(x)) <= WAITING.max_voxel_steps).all() and (x[slots:] == goal).all():
            flights.append(x[:, None] * [1, 0, 0])
    return flights


def test_no_joint_plan_of_the_waiting_game_is_an_equilibrium() -> None:
    simulator, flights = waiting_game(), [all_flights(0), all_flights(1)]
    pairs = [np.stack(pair) for pair in itertools.product(*flights)]
    plans = [Plan(voxels, np.zeros(2, dtype=np.int64)) for voxels in pairs]
    flown = fly(simulator, np.stack([actions_of(simulator.rules, plan) for plan in plans], axis=1))
    assert flown.arrived.all()
    # Straight on, by way of either voxel of cell 0 (UAV 0) or of voxels 1 and 2 (UAV 1), and with two voxels between
    # origin and destination in 5 ways and in 6.
    shape = (8, 9, 2)
    collisions, utilities_mbps = flown.collisions.reshape(shape), flown.utilities_mbps.reshape(shape).round(9)
    for a, b in np.ndindex(shape[:2]):
        here = collisions[a, b], -utilities_mbps[a, b]
        gains = [(collisions[c, b, 0], -utilities_mbps[c, b, 0]) < (here[0][0], here[1][0]) for c in range(shape[0])]
        gains += [(collisions[a, d, 1], -utilities_mbps[a, d, 1]) < (here[0][1], here[1][1]) for d in range(shape[1])]
        assert any(gains)


def responses(simulator: Simulator, plan: Plan) -> Iterator[tuple[tuple[int, ...], float]]:
    """Flight times of the joint plan after each response that gains anything, and what it gains in Mbps; for ever."""
    rules, state = simulator.rules, simulator.state
    for i in itertools.cycle(range(len(plan.slots))):
        before_mbps = planned_utilities_mbps(rules, state, 0, plan)[i]
        flight, path = best_response(rules, state, 0, plan, i, False, DEFAULT_SLACK)
        gain_mbps = flight.worth_mbps - before_mbps
        if gain_mbps > 1e-9:
            plan.voxels[i], plan.slots[i] = path, flight.slots
            yield tuple(plan.slots.tolist()), gain_mbps


def test_responses_to_the_waiting_game_go_round_in_a_circle_of_gains() -> None:
    # Both are to arrive in slot 2, 3 Mbps each. From the table above: UAV 0 waits a slot more (90/21), so UAV 1 goes at
    # once (4 against 22/6), so UAV 0 waits a slot less (38/6 against 106/21), so UAV 1 waits as long as it can (90/21
    # against 4), and so on with their parts exchanged. Six responses after the first the joint plan is there again.
    simulator = waiting_game()
    plan = joint_wait(simulator, 2, 2)
    circle = [(3, 2), (3, 1), (2, 1), (2, 3), (1, 3), (1, 2), (3, 2)]
    gains_mbps = [90 / 21 - 3, *[4 - 22 / 6, 38 / 6 - 106 / 21, 90 / 21 - 4] * 2]
    assert min(gains_mbps) > 0.28
    found = list(itertools.islice(responses(simulator, plan), len(circle)))
    assert [slots for slots, _ in found] == circle
    np.testing.assert_allclose([gain_mbps for _, gain_mbps in found], gains_mbps)


def test_a_circle_is_seen_when_a_joint_plan_comes_back() -> None:
    simulator = waiting_game()
    plan = joint_wait(simulator, 2, 2)
    settled = settle(simulator.rules, simulator.state, 0, plan, "utility", DEFAULT_SLACK)
    assert (settled.is_fixed, settled.period) == (False, 3)
    # Another period later the same joint plan is there again.
    later = Plan(plan.voxels.copy(), plan.slots.copy())
    rounds = itertools.islice(responses(simulator, later), 2 * settled.period)
    assert [slots for slots, _ in rounds][-1] == tuple(plan.slots.tolist())
    np.testing.assert_array_equal(later.voxels, plan.voxels)


def test_a_search_gives_up_after_so_many_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    simulator = waiting_game()
    plan = joint_wait(simulator, 2, 2)
    cut = settle(simulator.rules, simulator.state, 0, plan, "utility", DEFAULT_SLACK, most_rounds=2)
    assert cut == Settled(2, False, 0)  # the circle closes after three
    monkeypatch.setattr("lawn_sb3.planning.equilibrium.settle", lambda *_: cut)
    player = EquilibriumPlayer(starts=4)
    played(player, simulator, seed=0)
    assert (player.searches, player.cycles, player.cut, player.unsettled) == (4, 0, 4, 1)


@pytest.mark.parametrize("player_type", [EquilibriumPlayer, WorstEquilibriumPlayer])
def test_searches_that_go_round_are_counted_and_a_plan_is_flown_all_the_same(player_type: type[SearchPlayer]) -> None:
    simulator, player = waiting_game(), player_type(starts=4)
    plan = played(player, simulator, seed=0)
    assert (player.searches, player.cycles, player.unsettled) == (4, 4, 1)
    assert fly_plan(simulator, plan).arrived.all()


def test_the_welfare_ascent_of_the_waiting_game_ends() -> None:
    # One goes at once, 4 Mbps, the other waits. With two slots it has 38/6 Mbps, with three 106/21, so two are best:
    # W = 4 + 38/6 = 31/3 Mbps.
    simulator, player = waiting_game(), WelfarePlayer(starts=4)
    plan = played(player, simulator, seed=0)
    assert (player.searches, player.cycles, player.unsettled) == (8, 0, 0)
    assert fly_plan(simulator, plan).welfare_mbps[0] == pytest.approx(31 / 3)


# What a UAV is guaranteed


def test_the_corridor_guarantees_4_mbps() -> None:
    # Beside the other UAV in every slot a UAV of the corridor has 2 RBs, 4 Mbps; straight on is best.
    simulator = Simulator(CORRIDOR)
    simulator.reset(missions=Missions(ORIGINS, DESTINATIONS))
    guaranteed_mbps = guaranteed_utilities_mbps(simulator.rules, simulator.state, DEFAULT_SLACK)
    np.testing.assert_allclose(guaranteed_mbps, [[4.0, 4.0]])


def test_no_uav_of_the_paper_s_missions_has_less_than_guaranteed_in_an_equilibrium() -> None:
    # What is guaranteed does not look at collisions, and an equilibrium without them may cost a UAV more than that
    # where it is crowded; the paper's airspace is wide enough.
    simulator = Simulator(PAPER, 100)
    simulator.reset(missions=draw_missions(PAPER, 100, np.random.default_rng(1)))
    guaranteed_mbps = guaranteed_utilities_mbps(simulator.rules, simulator.state, DEFAULT_SLACK)
    rows = evaluate(WorstEquilibriumPlayer(starts=4), PAPER, 100, seed=1)
    assert (rows["utility_mbps"].to_numpy().reshape(guaranteed_mbps.shape) >= guaranteed_mbps * (1 - 1e-9)).all()


@given(situation=situations())
@settings(max_examples=50)
def test_the_guarantee_holds_whatever_the_others_fly_and_never_exceeds_the_bound(situation: Situation) -> None:
    (simulator, plan, uav, slack), (rules, state) = situation, (situation.rules, situation.state)
    guaranteed_mbps = guaranteed_utilities_mbps(rules, state, slack)[0, uav]
    # The best of all sequences of actions against these flights of the others, whatever it collides with.
    best_mbps = every_flight(simulator, plan, uav).utilities_mbps[:, uav].max()
    assert guaranteed_mbps <= best_mbps * (1 + 1e-9)
    # The best response says the same where nobody is in the way.
    around = others_in(rules, state, 0, plan, uav, False)
    unhindered = around._replace(voxels=around.voxels[:0], slots=around.slots[:0])
    lone = nobody(len(plan.voxels[0]) - 1, len(rules.num_rbs))
    path = np.empty_like(plan.voxels[uav])
    response, alone = (best_flight(rules, state, 0, uav, them, slack, path) for them in (unhindered, lone))
    assert guaranteed_mbps <= max(response.worth_mbps, 0.0) * (1 + 1e-9)
    assert max(response.worth_mbps, 0.0) <= max(alone.worth_mbps, 0.0) * (1 + 1e-9)
