"""The symmetries of a square airspace: turns and mirrors that leave the radio map and the RBs as they are."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.errors import UserError
from lawn_sb3.game.airspace import action_table
from lawn_sb3.game.radio import radio_map
from lawn_sb3.scenario import Scenario

Ints = NDArray[np.int64]
Turn = tuple[bool, bool, bool]
"""Swap x and y; then mirror x; then mirror y."""

EIGHT: tuple[Turn, ...] = tuple((swap, x, y) for swap in (False, True) for x in (False, True) for y in (False, True))
NONE: tuple[Turn, ...] = EIGHT[:1]


class Frames(NamedTuple):
    """What each of K turns does."""

    column: Ints
    """Where each column of voxels goes, x * L + y [K, W * L]."""
    cell: Ints
    """The cell that each cell becomes [K, M]."""
    action: Ints
    """What each action becomes [K, A]."""


def turned(voxels: Ints, turn: Turn, size: int) -> Ints:
    """Turn voxels: x and y [..., 2] in an airspace of ``size`` voxels along each side."""
    x, y = (voxels[..., 1], voxels[..., 0]) if turn[0] else (voxels[..., 0], voxels[..., 1])
    return np.stack([size - 1 - x if turn[1] else x, size - 1 - y if turn[2] else y], axis=-1)


def frames(scenario: Scenario, symmetric: bool = True) -> Frames:
    """Work out what the eight symmetries of the square do to voxels, cells and actions.

    :param scenario: the game
    :param symmetric: all eight; otherwise the one that turns nothing
    :return: the tables
    :raises UserError: if the airspace does not have all eight, naming the first that it lacks
    """
    width, length, _ = scenario.grid
    if symmetric and width != length:
        raise UserError(f"no symmetric frame: the airspace of {width} x {length} voxels is no square")
    moves = action_table(scenario.max_voxel_steps)
    index = {tuple(move): a for a, move in enumerate(moves.tolist())}
    columns = np.stack(np.divmod(np.arange(width * length), length), axis=-1)  # [W * L, 2]
    parts: list[tuple[Ints, Ints, Ints]] = []
    for turn in EIGHT if symmetric else NONE:
        to = turned(columns, turn, width) if symmetric else columns
        column = to[:, 0] * length + to[:, 1]
        flat = turned(moves[:, :2], turn, 1)  # a mirror turns a displacement's sign
        action = np.array([index[(x, y, z)] for (x, y), z in zip(flat.tolist(), moves[:, 2].tolist(), strict=True)])
        parts.append((column, _turned_cells(scenario, column, turn), action))
    return Frames(*(np.stack(part) for part in zip(*parts, strict=True)))


def _turned_cells(scenario: Scenario, column: Ints, turn: Turn) -> Ints:
    """The cell of each cell's voxels after the turn; refused if the radio map or the RBs do not turn with it."""
    link, num_rbs = radio_map(scenario), scenario.num_rbs
    cells, rates = (table.reshape(len(column), -1) for table in link)  # [W * L, H]
    to = np.full(scenario.num_gbs, -1, dtype=np.int64)
    to[cells] = cells[column]
    unused = np.setdiff1d(np.arange(scenario.num_gbs), cells)
    to[unused] = unused  # cells without a voxel stay
    same_cells = np.array_equal(to[cells], cells[column]) and len(np.unique(to)) == len(to)
    if same_cells and np.allclose(rates, rates[column]) and np.array_equal(num_rbs, num_rbs[to]):
        return to
    names = ("x and y swapped", "x mirrored", "y mirrored")
    how = ", ".join(name for name, done in zip(names, turn, strict=True) if done)
    raise UserError(
        f"no symmetric frame: with {how}, GBS sites or their RBs are not what they were in scenario {scenario.name!r}; "
        "give policy_kwargs symmetric: false"
    )
