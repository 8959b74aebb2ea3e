"""The symmetries of a square airspace."""

import numpy as np
import pytest

from lawn_sb3.envs.symmetry import EIGHT, frames
from lawn_sb3.errors import UserError
from lawn_sb3.game.airspace import action_table
from lawn_sb3.game.radio import radio_map
from lawn_sb3.scenario import PRESETS, load_scenario

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
