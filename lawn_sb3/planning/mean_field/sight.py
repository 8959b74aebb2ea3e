"""What a UAV of the mean-field planner knows about the others: how many are in each cell, and little else.

It is written as a few rows with one number per cell, so that it looks the same for every number of cells and UAVs. Rows
are told apart by their hash. If the airspace looks the same after it is flipped or transposed, so do the games in it,
and what was seen in one cell counts for its images too.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.compiled import njit
from lawn_sb3.game.state import Rules, State, voxel_of

Ints = NDArray[np.int64]

EXACT_SLOTS = 8
"""Times up to this many slots are told apart one by one; longer ones fall into four buckets per octave."""

_SEED, _PRIME = 0x2545F4914F6CDD1D, 0x100000001B3
_POSITIVE = 0x7FFFFFFFFFFFFFFF


class Senses(NamedTuple):
    """What a UAV knows besides its own o_i, Eq. (12), eq:obs, and the slots that it has flown."""

    destinations: bool
    """How many other UAVs in the air head for each cell."""
    memory: bool
    """The cell loads that it saw one slot before."""

    @property
    def num_rows(self) -> int:
        """B, how many numbers it knows of each cell."""
        return 1 + self.destinations + self.memory


class Keys(NamedTuple):
    """A sight in a form that can be looked up, from the least that is known to all of it."""

    loads: int
    """The UAV's own cell and how many others are in each cell."""
    rows: int
    """The same, with all that is known of each cell."""
    clock: int
    """The same, with the slots flown."""


@njit
def bucket(slots: int) -> int:
    """The bucket of a time: the slots themselves up to ``EXACT_SLOTS``, above that their logarithm in quarter octaves.

    >>> [bucket(slots) for slots in (0, 5, 8, 16, 32)]
    [0, 5, 8, 12, 16]
    """
    if slots <= EXACT_SLOTS:
        return slots
    return EXACT_SLOTS + int(4.0 * np.log2(slots / EXACT_SLOTS))


@njit
def look(rules: Rules, state: State, game: int, uav: int, senses: Senses, sight: Ints) -> int:
    """Write what a UAV knows of each cell.

    :param sight: other UAVs in each cell; then, if known, those heading for it, and its load one slot before, oneself
        included [B, M]; written
    :return: the UAV's own cell
    """
    own = rules.cell[voxel_of(state.position, game, uav)]
    row = 0
    for b in range(sight.shape[1]):
        sight[row, b] = state.cell_load[game, b]
    sight[row, own] -= 1
    if senses.destinations:
        row += 1
        sight[row, :] = 0
        for j in range(state.flying.shape[1]):
            if j != uav and state.flying[game, j]:
                sight[row, rules.cell[voxel_of(state.destination, game, j)]] += 1
    if senses.memory:
        row += 1
        for b in range(sight.shape[1]):
            sight[row, b] = state.past_load[game, 0, b]
    return int(own)


@njit
def keys_of(own: int, sight: Ints, clock: int, image: Ints) -> Keys:
    """Hash a sight into 63 bits each, unique in practice.

    :param own: the UAV's own cell
    :param sight: what it knows of each cell [B, M]
    :param clock: slots flown
    :param image: the cell that takes the place of each cell, such as 0, 1, 2... [M]
    """
    key = _SEED
    for b in image:
        key = _fold(key, 2 * sight[0, b] + (b == own))
    loads = key
    for row in range(1, sight.shape[0]):
        for b in image:
            key = _fold(key, sight[row, b])
    rows = key
    return Keys(_fold(loads, -1), _fold(rows, -2), _fold(_fold(rows, bucket(clock)), -3))


@njit
def _fold(key: int, value: int) -> int:
    key = (key ^ (value + 0x9E3779B9)) * _PRIME
    return (key ^ (key >> 29)) & _POSITIVE


def images(rules: Rules) -> Ints:
    """How the cells change places when the airspace is flipped or transposed and the game stays the same.

    :return: the cell that takes the place of each cell [P, M]; the first row is 0, 1, 2...
    """
    num_gbs = len(rules.num_rbs)
    found = [np.arange(num_gbs)]
    for transposed in (False, True):
        for flips in ((), (0,), (1,), (0, 1)):
            cell, rate = (_moved(table, flips, transposed) for table in (rules.cell, rules.rb_rate_mbps))
            if cell.shape != rules.cell.shape or not np.allclose(rate, rules.rb_rate_mbps, rtol=1e-9, atol=0.0):
                continue
            image = np.arange(num_gbs)
            image[rules.cell] = cell
            is_same = (image[rules.cell] == cell).all() and (rules.num_rbs[image] == rules.num_rbs).all()
            if is_same and len(set(image.tolist())) == num_gbs and not any((image == one).all() for one in found):
                found.append(image)
    return np.array(found, dtype=np.int64)


def _moved(table: NDArray[np.generic], flips: tuple[int, ...], transposed: bool) -> NDArray[np.generic]:
    return np.flip(table.swapaxes(0, 1) if transposed else table, axis=flips)
