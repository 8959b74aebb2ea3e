"""The mean-field planner: what it may know, the arithmetic of its tables, and what it does where one can check it."""

import copy
import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.game import Simulator
from lawn_sb3.game.player import Player
from lawn_sb3.planning import (
    BestRoutePlayer,
    MeanFieldDestinationsPlayer,
    MeanFieldMemoryPlayer,
    MeanFieldPlayer,
    ShortestPathPlayer,
)
from lawn_sb3.planning.mean_field.fit import _join_each, longest_mission
from lawn_sb3.planning.mean_field.sight import Senses, bucket, images, keys_of, look
from lawn_sb3.planning.mean_field.tables import find_finest
from lawn_sb3.scenario import PRESETS, Scenario
from tests.game.random_play import SEEDS, random_play, scenarios
from tests.planning.test_players import with_other_others

PAPER = PRESETS["paper"]
SHORT: dict[str, Any] = {"rounds": 2, "episodes": 60}
KINDS = [MeanFieldPlayer, MeanFieldDestinationsPlayer, MeanFieldMemoryPlayer]


def started(player: MeanFieldPlayer, simulator: Simulator) -> MeanFieldPlayer:
    player.start(simulator, np.random.default_rng(0))
    return player


def test_what_joining_a_cell_gives_and_takes_by_hand() -> None:
    """Two UAVs in cell 0 of 12 RBs, with 1 and 2 Mbps of utility from each RB; cell 1 has 5 RBs and nobody in it.

    With a third one they have 4 RBs each instead of 6: they lose 2 * 1 + 2 * 2 = 6 Mbps. The third one itself, which
    had been in cell 0 too, does not count.
    """
    rules = Simulator(PAPER.changed(rbs_per_gbs=(12, 5, 10, 10)), 1).rules
    outcome = np.full((4, 2), np.nan)
    _join_each(rules, np.array([0, 0, 0, -1]), np.array([1.0, 2.0, 7.0, 0.0]), 2, outcome)
    assert outcome.tolist() == [[4.0, 6.0], [5.0, 0.0], [10.0, 0.0], [10.0, 0.0]]


def test_later_times_have_no_smaller_buckets() -> None:
    later = [bucket(s) for s in range(200)]
    assert later == sorted(later)


def test_a_uav_alone_expects_all_rbs_and_flies_the_best_route() -> None:
    alone = PAPER.changed(num_uavs=1)
    planners: list[Player] = [MeanFieldPlayer(**SHORT), BestRoutePlayer()]
    mine, best = (evaluate(player, alone, 40, seed=3).utility_mbps.to_numpy() for player in planners)
    np.testing.assert_allclose(mine, best)


@given(scenario=scenarios(), seed=SEEDS, slack=st.integers(0, 2), slots=st.integers(0, 3))
@settings(max_examples=25)
def test_it_reads_nothing_but_its_own_observation_and_clock(
    scenario: Scenario, seed: int, slack: int, slots: int
) -> None:
    simulator = Simulator(scenario.changed(max_slots=30), 2, seed)
    player = started(MeanFieldPlayer(slack, rounds=1, episodes=20), simulator)
    for _ in random_play(simulator, seed, slots):
        simulator.go_on()
    rng = np.random.default_rng(seed)
    for i in range(scenario.num_uavs):
        other = with_other_others(simulator, i, rng)
        assert (player.act(simulator)[:, i] == player.act(other)[:, i]).all()


@pytest.mark.parametrize("kind", KINDS)
@given(scenario=scenarios(), seed=SEEDS)
@settings(max_examples=10)
def test_all_arrive_in_time(kind: type[MeanFieldPlayer], scenario: Scenario, seed: int) -> None:
    rows = evaluate(kind(rounds=1, episodes=20), scenario.changed(max_slots=30), 4, seed)
    assert rows.arrived.all()
    assert (rows.slots == rows.min_slots).all()


def test_telling_the_others_destinations_changes_the_sight_and_nothing_else_does() -> None:
    """Three others: two in the air, headed for the cell of the corner (9, 9), and one that has arrived."""
    simulator = Simulator(PAPER, 1, seed=0)
    rules, state = simulator.rules, copy.deepcopy(simulator.state)
    state.destination[0, 1:] = (9, 9, 0)
    state.flying[0, 3] = False
    sight = np.zeros((2, 4), dtype=np.int64)
    own = look(rules, state, 0, 0, Senses(destinations=True, memory=False), sight)
    assert own == rules.cell[tuple(state.position[0, 0])]
    assert sight[0].sum() == state.cell_load.sum() - 1
    assert sight[1].tolist() == [2 * (b == rules.cell[9, 9, 0]) for b in range(4)]


def test_the_square_has_eight_images_and_what_was_seen_in_one_counts_in_all() -> None:
    simulator = Simulator(PAPER, 1, seed=0)
    player = started(MeanFieldPlayer(**SHORT), simulator)
    same = images(simulator.rules)
    assert len(same) == 8
    sight = np.array([[2, 1, 0, 0]])
    plain = player.tables.rows.means[find_finest(player.tables, keys_of(0, sight, 0, same[0]))]
    for image in same:
        own = int(np.flatnonzero(image == 0)[0])  # where cell 0 comes to lie
        row = find_finest(player.tables, keys_of(own, sight[:, image], 0, np.arange(4)))
        assert row >= 0
        np.testing.assert_allclose(player.tables.rows.means[row], plain[:, image])


def test_shares_expected_lie_between_one_of_all_and_all() -> None:
    player = started(MeanFieldPlayer(**SHORT), Simulator(PAPER, 1, seed=0))
    share, loss = np.moveaxis(player.tables.rows.means[: player.tables.size[0]], -1, 0)
    num_rbs = PAPER.num_rbs
    assert (share <= num_rbs + 1e-9).all()
    assert (share >= num_rbs // PAPER.num_uavs - 1e-9).all()
    assert (loss >= -1e-9).all()


def test_the_same_seed_fits_the_same_tables_and_another_game_fits_them_anew() -> None:
    one, other = (started(MeanFieldPlayer(**SHORT), Simulator(PAPER, 1, seed=s)) for s in (0, 1))
    np.testing.assert_array_equal(one.tables.rows.means, other.tables.rows.means)
    before = one.tables
    assert started(one, Simulator(PAPER, 2, seed=5)).tables is before
    assert started(one, Simulator(PAPER.changed(num_uavs=2), 1, seed=0)).tables is not before


def test_rounds_are_reported() -> None:
    heard: list[tuple[int, int]] = []
    started(MeanFieldPlayer(rounds=3, episodes=20, on_round=lambda *done: heard.append(done)), Simulator(PAPER, 1))
    assert heard == [(1, 3), (2, 3), (3, 3)]


def test_the_longest_mission_leads_from_corner_to_corner() -> None:
    assert longest_mission(PAPER) == -(-(9 + 9 + 2) // PAPER.max_voxel_steps)


def test_who_knows_more_earns_more_and_all_earn_more_than_a_straight_flight() -> None:
    """The same 600 missions; means over missions differ by several times their standard error."""
    players: list[Player] = [ShortestPathPlayer(), *(kind(rounds=6, episodes=1500) for kind in KINDS[:2])]
    means = []
    for player in players:
        rows = evaluate(player, PAPER, 600, seed=31000)
        means.append(rows.groupby("episode").utility_mbps.mean())
    for less, more in itertools.pairwise(means):
        gain = more - less
        assert gain.mean() > 3 * gain.std() / np.sqrt(len(gain))
