"""What to expect of each cell, slots ahead, by what is seen now: means over many flights, filed by what was known.

Much of what can be known is seen rarely. Every mean is therefore drawn towards the mean of those who knew less; the
fewer flights it is over, the more so. From most to least: the sight with the clock; the sight; own cell and loads; of
one cell alone, its load and all the others; nothing. Before anything was seen, a UAV expects every cell for itself.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.compiled import njit
from lawn_sb3.game.state import Rules
from lawn_sb3.planning.mean_field.sight import Keys, Senses, bucket

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

PRIOR_FLIGHTS = 10.0
"""The mean of those who knew less counts as much as this many flights."""
MOST_ROWS = 2**15
MOST_CELL_ROWS = 2**17
MOST_MEANS = 2**21
"""Bounds on the tables: sights, sights of one cell alone, and means of all sights (buckets times cells)."""
MOST_TOLD_APART = 17
"""Numbers of UAVs in a cell that are told apart, from 0 up; larger ones count as the last."""


class Means(NamedTuple):
    """Means of RB shares and of the others' losses in Mbps, in the last axis, and what they are made of."""

    sums: Floats  # [R, K, M, 2]
    counts: Floats  # [R, K, M] flights
    means: Floats  # [R, K, M, 2]


class Tables(NamedTuple):
    """All means of a scenario, by bucket of slots ahead (K of them) and cell."""

    rows: Means
    """By sight [R, K, M]."""
    cells: Means
    """By what is known of one cell alone; that cell is part of the row's index [C, K, 1]."""
    overall: Means
    """Whatever was seen [1, K, M]."""
    size: Ints
    """How many of the R rows are in use [1]."""
    places: Ints
    """The row of a key, found by open addressing; -1 where there is none [2 R]."""
    keys: Ints
    """The key of each row [R]."""
    parents: Ints
    """The row of those who knew less; -1 for a row that knows the loads alone [R]."""
    parent_cells: Ints
    """For a row that knows the loads alone, the rows of each single cell [R, M]."""
    told_apart: int
    """Numbers of UAVs in a cell, from 0 up, that the rows of each cell alone tell apart."""


def empty_tables(rules: Rules, num_uavs: int, senses: Senses, longest: int) -> Tables:
    """Tables before anything was seen.

    :param rules: the game's constants
    :param num_uavs: N
    :param senses: what a UAV knows
    :param longest: slots of the longest flight
    :return: the tables
    """
    num_gbs, buckets = len(rules.num_rbs), bucket(longest) + 1
    rows = max(MOST_MEANS // (buckets * num_gbs), 2)
    rows = min(2 ** (rows.bit_length() - 1), MOST_ROWS)
    counted = 3 if senses.num_rows > 1 else 2  # numbers of UAVs that a row of one cell alone goes by
    fitting = int((MOST_CELL_ROWS / (2 * num_gbs)) ** (1.0 / counted))
    told_apart = max(min(num_uavs + 1, MOST_TOLD_APART, fitting), 1)
    tables = Tables(
        rows=_empty_means(rows, buckets, num_gbs),
        cells=_empty_means(2 * num_gbs * told_apart**counted, buckets, 1),
        overall=_empty_means(1, buckets, num_gbs),
        size=np.zeros(1, dtype=np.int64),
        places=np.full(2 * rows, -1, dtype=np.int64),
        keys=np.zeros(rows, dtype=np.int64),
        parents=np.full(rows, -1, dtype=np.int64),
        parent_cells=np.zeros((rows, num_gbs), dtype=np.int64),
        told_apart=told_apart,
    )
    average(rules, tables)
    return tables


def _empty_means(rows: int, buckets: int, columns: int) -> Means:
    shape = (rows, buckets, columns)
    return Means(np.zeros((*shape, 2)), np.zeros(shape), np.zeros((*shape, 2)))


@njit
def cell_row(cell: int, own: int, sight: Ints, seen_in: int, total: int, told_apart: int) -> int:
    """The row of what is known of one cell alone: its load, the second number known of it, and all other UAVs.

    :param cell: the cell that the row is for
    :param own: the UAV's own cell, as the sight numbers cells
    :param seen_in: the cell's number in the sight
    :param total: other UAVs in all cells
    :return: index of the row
    """
    top = told_apart - 1
    row = 2 * cell + (seen_in == own)
    row = (row * told_apart + min(sight[0, seen_in], top)) * told_apart + min(total, top)
    if sight.shape[0] > 1:
        row = row * told_apart + min(sight[1, seen_in], top)
    return int(row)


@njit
def find_row(tables: Tables, key: int) -> int:
    """The row of a sight's key; -1 if there is none."""
    return int(tables.places[_place_of(tables, key)])


@njit
def _place_of(tables: Tables, key: int) -> int:
    """Where the row of a key is noted; or would be, if nothing is noted there."""
    mask = len(tables.places) - 1
    place = key & mask
    while tables.places[place] >= 0 and tables.keys[tables.places[place]] != key:
        place = (place + 1) & mask
    return place


@njit
def find_finest(tables: Tables, keys: Keys) -> int:
    """The row of those who knew as much as possible of what a UAV knows; -1 if not even its loads were seen."""
    for key in (keys.clock, keys.rows, keys.loads):
        row = find_row(tables, key)
        if row >= 0:
            return row
    return -1


@njit
def add_row(tables: Tables, key: int, parent: int) -> int:
    """The row of a sight's key, made if there is none; -1 if there is no room for it.

    :param parent: the row of those who knew less
    """
    place = _place_of(tables, key)
    if tables.places[place] >= 0:
        return int(tables.places[place])
    row = tables.size[0]
    if row == len(tables.keys):
        return -1
    tables.size[0] += 1
    tables.places[place], tables.keys[row], tables.parents[row] = row, key, parent
    return int(row)


@njit
def average(rules: Rules, tables: Tables) -> None:
    """Work out all means anew, from those who knew nothing to those who knew most."""
    overall, cells, rows = tables.overall, tables.cells, tables.rows
    num_buckets, num_gbs = overall.counts.shape[1:]
    for b in range(num_gbs):
        overall.means[0, 0, b, 0], overall.means[0, 0, b, 1] = rules.num_rbs[b], 0.0  # nobody else, and no loss
        for k in range(1, num_buckets):
            _draw(overall, 0, k, b, overall.means[0, k - 1, b, 0], overall.means[0, k - 1, b, 1])
    per_cell = len(cells.counts) // num_gbs
    for row in range(len(cells.counts)):
        b = row // per_cell
        for k in range(num_buckets):
            _draw(cells, row, k, 0, overall.means[0, k, b, 0], overall.means[0, k, b, 1])
    for row in range(tables.size[0]):  # a parent's index is below its children's
        parent = tables.parents[row]
        for b in range(num_gbs):
            for k in range(num_buckets):
                if parent >= 0:
                    _draw(rows, row, k, b, rows.means[parent, k, b, 0], rows.means[parent, k, b, 1])
                else:
                    alone = tables.parent_cells[row, b]
                    _draw(rows, row, k, b, cells.means[alone, k, 0, 0], cells.means[alone, k, 0, 1])


@njit
def _draw(table: Means, row: int, k: int, b: int, share: float, loss_mbps: float) -> None:
    """Work out a mean, drawn towards that of those who knew less."""
    flights = table.counts[row, k, b] + PRIOR_FLIGHTS
    table.means[row, k, b, 0] = (table.sums[row, k, b, 0] + PRIOR_FLIGHTS * share) / flights
    table.means[row, k, b, 1] = (table.sums[row, k, b, 1] + PRIOR_FLIGHTS * loss_mbps) / flights


def fade(tables: Tables, kept: float) -> None:
    """Let what was seen so far count less: ``kept`` of what it did."""
    for table, used in ((tables.rows, int(tables.size[0])), (tables.cells, None), (tables.overall, None)):
        table.sums[:used] *= kept
        table.counts[:used] *= kept
