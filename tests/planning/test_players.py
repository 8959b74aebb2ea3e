"""The players that plan: they arrive in time, refuse what cannot be flown, and never have more than the bound."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lawn_sb3.choices import Continuation
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.game import Missions, draw_missions
from lawn_sb3.game.airspace import min_slots, moves_inside
from lawn_sb3.game.kernel import count_loads
from lawn_sb3.game.player import Player, RandomPlayer
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning import (
    BestRoutePlayer,
    BoundPlayer,
    EquilibriumPlayer,
    ForecastPlayer,
    ShortestPathPlayer,
    WelfarePlayer,
    WorstEquilibriumPlayer,
)
from lawn_sb3.planning.plan_player import PlanPlayer
from lawn_sb3.scenario import PRESETS, Scenario
from tests.envs.corridor import CORRIDOR, DESTINATIONS, ORIGINS, action
from tests.game.random_play import SEEDS, random_play, scenarios

PAPER = PRESETS["paper"]
EPISODES = 3

Planner = PlanPlayer | ForecastPlayer
PLANNERS: dict[str, Callable[[], Planner]] = {
    "best-route": BestRoutePlayer,
    "bound": BoundPlayer,
    "forecast": ForecastPlayer,
    "equilibrium": lambda: EquilibriumPlayer(starts=3),
    "worst-equilibrium": lambda: WorstEquilibriumPlayer(starts=3),
    "welfare": lambda: WelfarePlayer(starts=3),
}
EVERY_PLANNER = pytest.mark.parametrize("make", PLANNERS.values(), ids=PLANNERS)


class Watched:
    """A player whose actions are kept, and have to stay inside the airspace by themselves."""

    def __init__(self, player: Player) -> None:
        self.name = player.name
        self.flies_alone = getattr(player, "flies_alone", False)
        self.actions: list[NDArray[np.int64]] = []
        self._player = player

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        self._player.start(simulator, rng)

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        actions, state, rules = self._player.act(simulator), simulator.state, simulator.rules
        inside = np.take_along_axis(moves_inside(state.position, rules.actions, rules.grid), actions[..., None], axis=2)
        assert (inside[..., 0] | ~state.flying).all()
        self.actions.append(np.where(state.flying, actions, -1))
        return actions


def flyable(scenario: Scenario) -> Scenario:
    """The same scenario with time enough for the longest mission there is, and no more than that if it had less."""
    farthest = (scenario.grid[0] - 1, scenario.grid[1] - 1, scenario.grid[2] - 1)
    longest = min_slots((0, 0, 0), farthest, scenario.max_voxel_steps)
    return scenario.changed(max_slots=max(scenario.max_slots, longest))


def actions_of(player: Player, scenario: Scenario, player_seed: int, episodes: int = 20) -> list[NDArray[np.int64]]:
    """What a player does in an evaluation; -1 for UAVs that are done."""
    watched = Watched(player)
    evaluate(watched, scenario, episodes, seed=5, player_seed=player_seed)
    return watched.actions


# Every mission is flown in time


@EVERY_PLANNER
@given(scenario=scenarios().map(flyable), seed=SEEDS)
@settings(max_examples=25)
def test_every_mission_is_completed_in_time_and_within_the_slack(
    make: Callable[[], Planner], scenario: Scenario, seed: int
) -> None:
    player = make()
    rows = evaluate(Watched(player), scenario, EPISODES, seed)
    assert rows["arrived"].all()
    assert (rows["slots"] >= rows["min_slots"]).all()
    assert (rows["slots"] <= np.minimum(rows["min_slots"] + player.slack, scenario.max_slots)).all()


@EVERY_PLANNER
@pytest.mark.parametrize("continuation", ["mission", "episode"])
@given(scenario=scenarios().map(flyable), seed=SEEDS)
@settings(max_examples=10)
def test_new_missions_are_completed_in_time_too(
    make: Callable[[], Planner], continuation: Continuation, scenario: Scenario, seed: int
) -> None:
    simulator, player = Simulator(scenario, 2, seed, continuation), make()
    watched = Watched(player)
    watched.start(simulator, np.random.default_rng(seed))
    for _ in range(50):
        outcome = simulator.step(watched.act(simulator))
        assert not outcome.timed_out.any()
        assert (simulator.state.slot <= simulator.state.min_slots + player.slack).all()
        simulator.go_on()


def test_a_game_that_goes_on_is_planned_anew_only_where_a_uav_has_a_new_mission() -> None:
    # In two games of the corridor the UAVs fly straight, two slots of one voxel; in game 1 UAV 1 has one voxel to go.
    origins, destinations = np.stack([ORIGINS] * 2), np.stack([DESTINATIONS] * 2)
    destinations[1, 1] = (2, 0, 0)
    origins[1, 0], destinations[1, 0] = (3, 0, 0), (1, 0, 0)
    simulator, planned = Simulator(CORRIDOR, 2, seed=0), [0]

    def count() -> None:
        planned[0] += 1

    player = BestRoutePlayer(slack=0, on_game=count)
    simulator.reset(missions=Missions(origins, destinations))
    player.start(simulator, np.random.default_rng(0))
    assert planned == [2]
    simulator.step(player.act(simulator))
    simulator.go_on()
    simulator.step(player.act(simulator))
    assert planned == [3]


def test_a_game_that_went_another_way_is_planned_anew() -> None:
    # Both UAVs hover for nine slots, longer than any flight that was planned at the outset; two slots bring them there.
    simulator, player = Simulator(CORRIDOR.changed(max_slots=12), continuation="episode"), BestRoutePlayer()
    simulator.reset(missions=Missions(ORIGINS, DESTINATIONS))
    player.start(simulator, np.random.default_rng(0))
    for _ in range(9):
        simulator.step(np.zeros((1, 2), dtype=np.int64))
    arrived = [simulator.step(player.act(simulator)).arrived.tolist() for _ in range(2)]
    assert arrived == [[[False, False]], [[True, True]]]


# What cannot be flown is refused


@EVERY_PLANNER
def test_a_mission_beyond_the_deadline_is_refused_by_name(make: Callable[[], Planner]) -> None:
    # One voxel a slot and two slots: UAV 0 has two voxels to go, UAV 1 of game 1 has three.
    simulator = Simulator(CORRIDOR.changed(max_slots=2), 2)
    origins, destinations = np.stack([ORIGINS] * 2), np.stack([DESTINATIONS] * 2)
    origins[1], destinations[1] = [[1, 0, 0], [0, 0, 0]], [[2, 0, 0], [3, 0, 0]]
    simulator.reset(missions=Missions(origins, destinations))
    with pytest.raises(UserError, match="UAV 1 of game 1 cannot fly its mission"):
        make().start(simulator, np.random.default_rng(0))


# Seeds


@EVERY_PLANNER
def test_equal_seeds_give_equal_actions(make: Callable[[], Planner]) -> None:
    player = make()
    first = actions_of(player, PAPER, player_seed=3)
    np.testing.assert_equal(actions_of(player, PAPER, player_seed=3), first)
    np.testing.assert_equal(actions_of(make(), PAPER, player_seed=3), first)


def test_other_seeds_give_searches_other_starts() -> None:
    # Starts drawn anew lead to another worst equilibrium in about one of seven games; here there are 100.
    first, second = (actions_of(WorstEquilibriumPlayer(starts=2), PAPER, player_seed, 100) for player_seed in (3, 4))
    assert len(first) != len(second) or any((a != b).any() for a, b in zip(first, second, strict=True))


@pytest.mark.parametrize("make", [BestRoutePlayer, BoundPlayer, ForecastPlayer])
def test_players_that_draw_nothing_do_not_depend_on_their_seed(make: Callable[[], Planner]) -> None:
    np.testing.assert_equal(actions_of(make(), PAPER, player_seed=3), actions_of(make(), PAPER, player_seed=4))


# The forecast is decentralised


def with_other_others(simulator: Simulator, i: int, rng: np.random.Generator) -> Simulator:
    """A game in which UAV i and all loads are the same, but not the others' places, missions, clocks and EMA rates."""
    scenario, rules = simulator.scenario, simulator.rules
    other = Simulator(scenario, simulator.num_games, seed=0)
    other.restore(simulator.snapshot())
    state, voxels = other.state, np.argwhere(np.ones(rules.grid, dtype=np.bool_))
    state.slot[:] = rng.integers(0, rules.max_slots, state.slot.shape)
    state.min_slots[:] = rng.integers(1, rules.max_slots + 1, state.slot.shape)
    state.ema_rate_mbps[:] = rng.uniform(0.0, 100.0, state.slot.shape)
    others = np.delete(np.arange(scenario.num_uavs), i)
    for g in range(simulator.num_games):
        for j, k in zip(others, rng.permutation(others), strict=True):  # j stands in for k
            state.flying[g, j] = simulator.state.flying[g, k]
            cell = rules.cell[tuple(simulator.state.position[g, k])]
            position = rng.choice(voxels[rules.cell.ravel() == cell])
            state.position[g, j] = position
            state.destination[g, j] = rng.choice(voxels[(voxels != position).any(axis=1)])
    for mine, theirs in zip(simulator.state[:-2], state[:-2], strict=True):
        theirs[:, i] = mine[:, i]
    count_loads(rules, state)
    assert (state.cell_load == simulator.state.cell_load).all()
    return other


@given(scenario=scenarios(), seed=SEEDS, slack=st.integers(0, 2), slots=st.integers(0, 4))
@settings(max_examples=60)
def test_the_forecast_reads_nothing_but_its_own_observation_and_clock(
    scenario: Scenario, seed: int, slack: int, slots: int
) -> None:
    simulator, rng = Simulator(scenario, 2, seed), np.random.default_rng(seed)
    for _ in random_play(simulator, seed, slots):
        simulator.go_on()
    player = ForecastPlayer(slack)
    actions = player.act(simulator)
    for i in range(scenario.num_uavs):
        assert (player.act(with_other_others(simulator, i, rng))[:, i] == actions[:, i]).all()


def test_the_forecast_goes_where_fewer_other_uavs_are() -> None:
    # In the corridor, with two voxels a slot, a UAV needs two slots from voxel 0 to voxel 3. It can break its way in
    # voxel 1, which belongs to cell 0 like its origin, or in voxel 2, which belongs to cell 1 like its destination. An
    # RB carries 2 Mbps. Cell 0 has 5 RBs, so 10 Mbps alone and 4 Mbps beside the other UAV; cell 1 has 6, 12 or 6 Mbps.
    # While the other is in cell 1, staying in cell 0 is worth 10 Mbps against 6; while it is in cell 0, 4 against 12.
    scenario = CORRIDOR.changed(max_voxel_steps=2, rbs_per_gbs=(5, 6))
    simulator, player = Simulator(scenario), ForecastPlayer()
    for other, steps in ((2, 1), (1, 2)):
        simulator.reset(missions=Missions(np.array([[0, 0, 0], [other, 0, 0]]), np.array([[3, 0, 0], [0, 0, 0]])))
        player.start(simulator, np.random.default_rng(0))
        assert player.act(simulator)[0, 0] == action(simulator.rules.actions, steps, 0, 0)


# The bound


def alone_mbps(scenario: Scenario, missions: Missions) -> NDArray[np.float64]:
    """What every UAV has on its best route of any length up to the deadline, flown without any other UAV [G, N]."""
    num_games, num_uavs = missions.origins.shape[:2]
    utilities_mbps = np.zeros((num_games, num_uavs))
    for i in range(num_uavs):
        simulator = Simulator(scenario.changed(num_uavs=1), num_games, continuation="episode")
        simulator.reset(missions=Missions(missions.origins[:, [i]], missions.destinations[:, [i]]))
        player = BestRoutePlayer(slack=scenario.max_slots)
        player.start(simulator, np.random.default_rng(0))
        while simulator.state.flying.any():
            utilities_mbps[:, i] += simulator.step(player.act(simulator)).utility_mbps[:, 0]
    return utilities_mbps


def utilities_mbps(player: Player, scenario: Scenario, seed: int) -> NDArray[np.float64]:
    rows = evaluate(player, scenario, EPISODES, seed)
    return np.asarray(rows["utility_mbps"].to_numpy().reshape(EPISODES, scenario.num_uavs))


@given(scenario=scenarios().map(flyable), seed=SEEDS)
@settings(max_examples=25)
def test_no_uav_of_any_player_has_more_than_alone(scenario: Scenario, seed: int) -> None:
    bound_mbps = alone_mbps(scenario, draw_missions(scenario, EPISODES, np.random.default_rng(seed)))
    makers: list[Callable[[], Any]] = [RandomPlayer, ShortestPathPlayer, *PLANNERS.values()]
    for make in makers:
        had_mbps = utilities_mbps(make(), scenario, seed)
        assert (had_mbps <= bound_mbps * (1 + 1e-9)).all(), make().name


@given(scenario=scenarios(max_voxel_steps=2, max_slots=4), seed=SEEDS)
@settings(max_examples=25)
def test_no_sequence_of_actions_gives_more_than_alone(scenario: Scenario, seed: int) -> None:
    # 2,000 games on the same missions, which fit into four slots, each played at random.
    scenario = flyable(scenario)
    missions = draw_missions(scenario, 1, np.random.default_rng(seed))
    games = Simulator(scenario, 2_000, continuation="episode")
    games.reset(missions=Missions(missions.origins[0], missions.destinations[0]))
    had_mbps = sum(slot.outcome.utility_mbps for slot in random_play(games, seed, scenario.max_slots))
    assert (had_mbps <= alone_mbps(scenario, missions) * (1 + 1e-9)).all()


@given(scenario=scenarios().map(flyable), seed=SEEDS)
@settings(max_examples=25)
def test_the_bound_is_what_uavs_have_that_really_fly_alone(scenario: Scenario, seed: int) -> None:
    missions = draw_missions(scenario, EPISODES, np.random.default_rng(seed))
    had_mbps = utilities_mbps(BoundPlayer(), scenario, seed)
    np.testing.assert_allclose(had_mbps, alone_mbps(scenario, missions), rtol=1e-9)


def test_the_bound_waits_where_waiting_pays_for_however_long_it_does() -> None:
    # A corridor of ten slots, with a GBS between its last two voxels; all others are too far off to carry anything. In
    # T slots a UAV has the full rate r in T - 8 of them, the last: U = r (1 - 0.95^(T - 8)) / (1 - 0.95^T) 10 / T,
    # which is 0.3748 r for T = 15, 0.3757 r for T = 16 and 0.3738 r for T = 17.
    scenario = PAPER.changed(
        num_uavs=1, width_voxels=11, length_voxels=1, max_altitude_m=10, max_voxel_steps=1, ema_beta=0.05,
        gbs_positions_m=[(100.0, 5.0, 0.0)], path_loss_exponent=10, tx_power_dbm=-60,
    )  # fmt: skip
    simulator, player = Simulator(scenario, continuation="episode"), BoundPlayer()
    simulator.reset(missions=Missions(np.array([[0, 0, 0]]), np.array([[10, 0, 0]])))
    player.start(simulator, np.random.default_rng(0))
    had_mbps = 0.0
    while simulator.state.flying.any():
        had_mbps += float(simulator.step(player.act(simulator)).utility_mbps[0, 0])
    assert simulator.state.slot[0, 0] == 16
    full_mbps = 10 * float(simulator.rules.rb_rate_mbps[10, 0, 0])
    assert had_mbps == pytest.approx(full_mbps * (1 - 0.95**8) / (1 - 0.95**16) * 10 / 16, rel=0.01)


def test_two_uavs_of_the_corridor_have_10_mbps_each_alone_and_less_together() -> None:
    # Alone a UAV gets 10 Mbps in every slot, so U = 10 without any detour. Flying straight, UAV 0 through voxels 1 and
    # 2, UAV 1 through 2 and 3: slot 1 finds them in cells 0 and 1, 10 Mbps each, slot 2 both in cell 1, 4 Mbps each.
    # With beta = 0.5 slot 2 counts twice as much: (10 + 2 * 4) / 3 = 6 Mbps.
    missions = Missions(ORIGINS[None], DESTINATIONS[None])
    np.testing.assert_allclose(alone_mbps(CORRIDOR, missions), [[10.0, 10.0]])
    simulator, player = Simulator(CORRIDOR), BestRoutePlayer()
    simulator.reset(missions=missions)
    player.start(simulator, np.random.default_rng(0))
    simulator.step(player.act(simulator))
    np.testing.assert_allclose(simulator.step(player.act(simulator)).utility_mbps, [[6.0, 6.0]])
