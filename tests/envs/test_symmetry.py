"""The symmetries of a square airspace, and the in-time moves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lawn_sb3.envs.symmetry import EIGHT, frames
from lawn_sb3.errors import UserError
from lawn_sb3.game import Simulator
from lawn_sb3.game.airspace import action_table, moves_in_time
from lawn_sb3.game.radio import radio_map
from lawn_sb3.scenario import PRESETS, load_scenario
from tests.game.random_play import SEEDS

PAPER = PRESETS["paper"]


def test_the_papers_airspace_has_all_eight_symmetries() -> None:
    tables = frames(PAPER)
    assert len(tables.column) == len(EIGHT) == 8
    assert len(np.unique(tables.column[:, 0])) == 4  # the corner (0, 0) comes to lie in each corner
    assert sorted(tables.cell[:, 0].tolist()) == [0, 0, 1, 1, 2, 2, 3, 3]


def test_a_turn_takes_cells_rates_and_moves_along() -> None:
    tables, link, moves = frames(PAPER), radio_map(PAPER), action_table(3)
    cells, rates = (table.reshape(100, 3) for table in link)
    for column, cell, action in zip(*tables, strict=True):
        np.testing.assert_array_equal(cell[cells], cells[column])
        np.testing.assert_allclose(rates, rates[column])
        for a, b in enumerate(action):  # a move from the centre and its turn end in voxels that belong together
            end, turned = 5 + moves[a], np.array([*np.divmod(column[55], 10), 5]) + moves[b]
            assert column[end[0] * 10 + end[1]] == turned[0] * 10 + turned[1]
            assert end[2] == turned[2]


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        (["width_voxels=12"], "no square"),
        (["rbs_per_gbs=[10, 10, 10, 9]"], "GBS sites or their RBs"),
        (["gbs_grid=[3, 2]"], "GBS sites or their RBs"),
    ],
)
def test_a_game_without_the_symmetries_is_refused_in_one_line(changes: list[str], why: str) -> None:
    game = load_scenario("paper", changes)
    with pytest.raises(UserError, match=why):
        frames(game)
    assert frames(game, symmetric=False).column.shape == (1, game.grid[0] * game.grid[1])


def test_in_time_moves_of_a_mission_worked_out_by_hand() -> None:
    # From (0, 0, 0) to (4, 0, 0) with v_max = 3 in two slots: the first move has to leave at most three steps.
    moves = action_table(3)
    allowed = moves_in_time(np.array([0, 0, 0]), np.array([4, 0, 0]), np.array(2), moves, (10, 10, 3), 3)
    steps_left = np.abs(moves - [4, 0, 0]).sum(axis=1)
    np.testing.assert_array_equal(allowed, (moves >= 0).all(axis=1) & (steps_left <= 3))
    assert not allowed[0]  # hovering leaves four steps for one slot


@given(seed=SEEDS, slack=st.integers(0, 3))
def test_whoever_keeps_to_in_time_moves_arrives_in_time(seed: int, slack: int) -> None:
    game = load_scenario("paper", ["num_uavs=5"])
    simulator, rng = Simulator(game, 3, seed, "episode"), np.random.default_rng(seed)
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
    game = load_scenario("paper", ["max_slots=7"])
    simulator = Simulator(game, 50, 0, "episode")
    while simulator.state.flying.any():
        allowed = simulator.allowed_moves(slack=90)
        assert not simulator.step(allowed.argmax(axis=-1)).timed_out.any()  # hovers for as long as it may
