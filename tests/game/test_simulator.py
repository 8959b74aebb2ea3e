"""The simulator: seeds, snapshots, missions, how games go on, what is refused, and the paper's Random row."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lawn_sb3.choices import Continuation
from lawn_sb3.errors import UserError
from lawn_sb3.game import Missions, Simulator, draw_missions
from lawn_sb3.scenario import PRESETS, Scenario
from tests.game.random_play import SEEDS, random_actions, random_play, scenarios

PAPER = PRESETS["paper"]
SMALL = PAPER.changed(width_voxels=3, length_voxels=3, max_slots=8)  # so small that missions end all the time
BOTH = pytest.mark.parametrize("continuation", ["mission", "episode"])


def history(simulator: Simulator, seed: int, slots: int = 40) -> list[np.ndarray]:
    """All that happens in a while of random play, going on after every slot."""
    arrays: list[np.ndarray] = []
    for played in random_play(simulator, seed, slots):
        arrays += [*played.outcome, *played.state]
        simulator.go_on()
    return arrays


def assert_equal(one: list[np.ndarray], other: list[np.ndarray]) -> None:
    for mine, theirs in zip(one, other, strict=True):
        np.testing.assert_array_equal(mine, theirs)


def ends(simulator: Simulator, game: int, uavs: np.ndarray) -> list[tuple[int, ...]]:
    state = simulator.state
    return [tuple(v) for v in [*state.position[game, uavs].tolist(), *state.destination[game, uavs].tolist()]]


@BOTH
def test_same_seed_gives_the_same_games(continuation: Continuation) -> None:
    one, other = (Simulator(SMALL, 3, seed=7, continuation=continuation) for _ in range(2))
    assert_equal(history(one, seed=1), history(other, seed=1))


def test_seed_sequence_seeds_too() -> None:
    one, other = (Simulator(PAPER, 3, seed=np.random.SeedSequence(7, spawn_key=(1,))) for _ in range(2))
    assert_equal([*one.state], [*other.state])


@pytest.mark.parametrize("seeds", [(7, 8), (None, None)])
def test_other_seeds_and_no_seed_give_other_missions_and_so_do_the_games_of_one(seeds: tuple[int | None, ...]) -> None:
    one, other = (Simulator(PAPER, 3, seed=seed).state.position for seed in seeds)
    assert (one != other).any()
    assert (one[0] != one[1]).any()


def test_reset_with_a_seed_starts_over_and_without_goes_on() -> None:
    simulator = Simulator(SMALL, 3, seed=7)
    first = simulator.state.position.copy()
    for _ in random_play(simulator, seed=1, slots=5):
        pass
    simulator.reset()
    assert (simulator.state.position != first).any()
    assert simulator.state.flying.all()
    assert not simulator.state.slot.any()
    assert not simulator.state.ema_rate_mbps.any()
    simulator.reset(seed=7)
    np.testing.assert_array_equal(simulator.state.position, first)


@BOTH
def test_restored_snapshot_goes_on_as_if_nothing_had_happened(continuation: Continuation) -> None:
    simulator = Simulator(SMALL, 3, seed=7, continuation=continuation)
    history(simulator, seed=1, slots=5)
    snapshot = simulator.snapshot()
    expected = history(simulator, seed=2)
    simulator.restore(snapshot)
    assert_equal(history(simulator, seed=2), expected)
    simulator.restore(snapshot)  # a second time: going on has not changed the snapshot
    assert_equal(history(simulator, seed=2), expected)


def test_snapshot_of_another_shape_is_refused() -> None:
    with pytest.raises(UserError, match=r"\(3, 4, 3\).*\(2, 4, 3\)"):
        Simulator(PAPER, 2, seed=7).restore(Simulator(PAPER, 3, seed=7).snapshot())


@given(scenario=scenarios(), seed=SEEDS)
@settings(max_examples=50)
def test_new_mission_never_overlaps_with_those_in_flight(scenario: Scenario, seed: int) -> None:
    simulator = Simulator(scenario, 2, seed, "mission")
    for played in random_play(simulator, seed, slots=20):
        simulator.go_on()
        assert simulator.state.flying.all()
        for game, still_flying in enumerate(played.state.flying):
            in_flight = set(ends(simulator, game, still_flying))
            new = ends(simulator, game, ~still_flying)
            assert len(set(new)) == len(new)
            assert in_flight.isdisjoint(new)


def test_explicit_missions_are_flown() -> None:
    origins = np.array([[0, 0, 0], [1, 1, 1], [2, 2, 2], [9, 9, 0]])
    simulator = Simulator(PAPER, 2)
    simulator.reset(missions=Missions(origins, origins[::-1]))
    assert simulator.state.position.tolist() == [origins.tolist()] * 2
    assert simulator.state.destination.tolist() == [origins[::-1].tolist()] * 2
    # 9 + 9 + 0 = 18 steps and 1 + 1 + 1 = 3 steps, at 3 a slot
    assert simulator.state.min_slots.tolist() == [[6, 1, 1, 6]] * 2


def test_refused_missions_leave_the_game_as_it_was() -> None:
    simulator = Simulator(PAPER, 1, seed=7)
    before = simulator.state.position.copy()
    with pytest.raises(UserError, match="origins have shape"):
        simulator.reset(missions=Missions(np.zeros((2, 3), dtype=int), np.ones((2, 3), dtype=int)))
    np.testing.assert_array_equal(simulator.state.position, before)


def test_episode_restarts_a_game_only_once_all_its_uavs_are_done() -> None:
    simulator = Simulator(SMALL, 20, seed=7, continuation="episode")
    restarts = waits = 0
    for played in random_play(simulator, seed=1, slots=30):
        simulator.go_on()
        over = ~played.state.flying.any(axis=1)
        assert simulator.state.flying[over].all()
        assert not simulator.state.slot[over].any()
        np.testing.assert_array_equal(simulator.state.flying[~over], played.state.flying[~over])
        np.testing.assert_array_equal(simulator.state.destination[~over], played.state.destination[~over])
        restarts += over.sum()
        waits += (~played.state.flying[~over]).sum()
    assert restarts > 20
    assert waits > 20


def test_games_of_fewer_uavs_have_each_number_as_often_and_those_in_no_game_count_nowhere() -> None:
    simulator = Simulator(PAPER, 3_000, seed=7, continuation="episode", fewest_uavs=2)
    state = simulator.state
    present = state.flying.sum(axis=1)
    assert np.bincount(present)[2:] == pytest.approx(1_000, abs=120)  # standard error 26
    np.testing.assert_array_equal(state.flying, np.arange(4) < present[:, None])
    np.testing.assert_array_equal(state.cell_load.sum(axis=1), present)
    np.testing.assert_array_equal((state.position == state.destination).all(axis=-1), ~state.flying)
    actions = random_actions(simulator, np.random.default_rng(0))
    outcome = simulator.step(actions)
    assert not outcome.rate_mbps[np.arange(4) >= present[:, None]].any()


def test_games_of_fewer_uavs_draw_their_number_anew_and_reset_flies_the_missions_it_is_given() -> None:
    simulator = Simulator(SMALL, 20, seed=7, continuation="episode", fewest_uavs=1)
    numbers: set[int] = set()
    for played in random_play(simulator, seed=1, slots=30):
        over = ~played.state.flying.any(axis=1)
        simulator.go_on()
        numbers |= set(simulator.state.flying[over].sum(axis=1).tolist())
        np.testing.assert_array_equal(simulator.state.flying[~over], played.state.flying[~over])
    assert numbers == {1, 2, 3, 4}
    missions = draw_missions(SMALL, 20, np.random.default_rng(0))
    simulator.reset(missions=missions)
    assert simulator.state.flying.all()
    np.testing.assert_array_equal(simulator.state.position, missions.origins)


def test_nothing_happens_to_uavs_that_are_down_until_they_go_on() -> None:
    simulator = Simulator(SMALL, 5, seed=7)
    *_, last = random_play(simulator, seed=1, slots=SMALL.max_slots)
    assert not last.state.flying.any()
    *_, later = random_play(simulator, seed=2, slots=3)
    assert_equal([*later.state], [*last.state])
    assert [np.count_nonzero(field) for field in later.outcome] == [0] * len(later.outcome)


@given(seed=SEEDS, slack=st.integers(0, 3))
def test_whoever_keeps_to_in_time_moves_arrives_in_time(seed: int, slack: int) -> None:
    simulator, rng = Simulator(PAPER.changed(num_uavs=5), 3, seed, "episode"), np.random.default_rng(seed)
    state, slots = simulator.state, np.zeros((3, 5))
    while state.flying.any():
        allowed = simulator.allowed_moves(slack)
        assert allowed.any(axis=-1).all()
        actions = np.where(allowed, rng.random(allowed.shape), -1.0).argmax(axis=-1)
        outcome = simulator.step(actions)
        slots[outcome.arrived] = state.slot[outcome.arrived]
        assert not outcome.timed_out.any()
    assert (slots >= state.min_slots).all()
    assert (slots <= state.min_slots + slack).all()


def test_in_time_moves_never_outlast_the_deadline() -> None:
    simulator = Simulator(PAPER.changed(max_slots=7), 50, 0, "episode")
    while simulator.state.flying.any():
        allowed = simulator.allowed_moves(slack=90)
        assert not simulator.step(allowed.argmax(axis=-1)).timed_out.any()  # hovers for as long as it may


def test_as_printed_airspace_plays() -> None:
    simulator = Simulator(PRESETS["as-printed"], 5, seed=7)
    for played in random_play(simulator, seed=1, slots=100):
        assert (played.state.position < (100, 100, 30)).all()
        assert (played.outcome.rate_mbps[played.flew] > 0).all()
    assert not simulator.state.flying.any()


@pytest.mark.parametrize(
    ("actions", "said"),
    [
        (np.zeros((4,), dtype=int), ["(4,)", "(2, 4)"]),
        (np.zeros((4, 2), dtype=int), ["(4, 2)", "(2, 4)"]),
        (np.zeros((2, 4, 1), dtype=int), ["(2, 4, 1)", "(2, 4)"]),
        (np.full((2, 4), 63), ["0 to 62"]),
        (np.full((2, 4), -1), ["0 to 62"]),
        (np.full((2, 4), 1.0), ["whole numbers", "float64"]),
        (np.full((2, 4), np.nan), ["whole numbers", "float64"]),
    ],
    ids=["one-game", "transposed", "too-deep", "too-high", "negative", "fraction", "nan"],
)
def test_actions_that_do_not_exist_are_refused(actions: np.ndarray, said: list[str]) -> None:
    simulator = Simulator(PAPER, 2, seed=7)
    before = simulator.state.position.copy()
    with pytest.raises(UserError) as refusal:
        simulator.step(actions)
    assert [words for words in said if words not in str(refusal.value)] == []
    np.testing.assert_array_equal(simulator.state.position, before)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"num_games": 0}, "num_games = 0: at least 1"),
        ({"seed": -1}, "seed = -1: a whole number from 0 up"),
        ({"continuation": "missions"}, "did you mean 'mission'"),
        ({"continuation": "episode", "fewest_uavs": 5}, "fewest_uavs = 5: from 1 to num_uavs = 4"),
        ({"continuation": "episode", "fewest_uavs": 0}, "fewest_uavs = 0: from 1 to num_uavs = 4"),
        ({"fewest_uavs": 2}, "continuation episode"),
        ({"continuation": "episode", "fewest_uavs": 2, "scenario": PAPER.changed(arrived_uav="stays")}, "leaves"),
    ],
)
def test_impossible_simulator_is_refused(arguments: dict[str, Any], said: str) -> None:
    with pytest.raises(UserError, match=said):
        Simulator(**{"scenario": PAPER, **arguments})


def test_random_play_gives_the_random_row_of_table_ii() -> None:
    """Success 22.4 %, R-hat 36.20 Mbps, makespan 100.0 slots, accumulated reward -3.57 (Table II)."""
    episodes = 1_000
    simulator = Simulator(PAPER, episodes, seed=0, continuation="episode")
    rng = np.random.default_rng(1)
    shape = simulator.state.flying.shape
    arrived, reward, corrected_mbps = np.zeros(shape, dtype=bool), np.zeros(shape), np.zeros(shape)
    for _ in range(PAPER.max_slots):
        flew = simulator.state.flying.copy()
        outcome = simulator.step(random_actions(simulator, rng))
        arrived |= outcome.arrived
        reward += outcome.reward_terms.sum(axis=-1)
        corrected_mbps = np.where(flew, outcome.corrected_rate_mbps, corrected_mbps)
    assert not simulator.state.flying.any()
    completion = np.where(arrived, simulator.state.slot, PAPER.max_slots)

    assert 21.0 <= 100 * arrived.mean() <= 24.0
    assert 35.7 <= corrected_mbps.mean() <= 37.1
    assert completion.max(axis=1).mean() >= 99.7
    assert -3.8 <= reward.mean() <= -3.2
