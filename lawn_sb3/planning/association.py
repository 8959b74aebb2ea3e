"""The association game of one slot: every UAV chooses a GBS, which splits its RBs equally among those that chose it.

It is what remains of the congestion game if nobody looks beyond the next slot. A rate is a share, which depends on how
many have chosen the GBS, times what an RB carries, which depends on the UAV and the GBS alone. Its logarithm is
therefore a sum, and has an exact potential (Monderer and Shapley, 1996): whenever one UAV alone changes its choice, the
potential changes by as much as that UAV's log-rate. Hence a choice from which no UAV gains by deviating alone always
exists. Rates themselves have no such potential, and utilities of whole trajectories, which add up rates of several
slots, need not have an equilibrium.

Rates r_ib over one RB are given as ``rb_rate_mbps`` [..., N, M] in Mbps, 0 where GBS b cannot serve UAV i; ``num_rbs``
are the K_b [M], and ``choice`` holds the index b_i of the GBS that each UAV chooses [..., N].
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lawn_sb3.errors import UserError
from lawn_sb3.game.airspace import move, stop_at
from lawn_sb3.game.radio import rb_share
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.game.state import voxel_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class OneSlotGame(NamedTuple):
    """The association game that the UAVs play in the next slot of a real game."""

    rb_rate_mbps: Floats
    """Rate over one RB in the best voxel of each cell that each UAV can reach [N, M]; 0 where it can reach none."""
    actions: Ints
    """The move to that voxel, as an index into the action table [N, M]; 0 where there is none."""


def association_rates_mbps(rb_rate_mbps: ArrayLike, num_rbs: ArrayLike, choice: ArrayLike) -> Floats:
    """Rate of every UAV in a joint choice: Eq. (2), eq:rate, with Eq. (1), eq:rb.

    R_i = floor(K_b / n_b) r_ib,  b = b_i

    :return: R_i in Mbps [..., N]
    :raises UserError: if the shapes do not fit or a choice is no GBS

    >>> association_rates_mbps([[1.0, 2.0], [4.0, 2.0], [3.0, 5.0]], [5, 3], [0, 0, 1])  # floor(5/2) = 2 RBs, and 3
    array([ 2.,  8., 15.])
    """
    rb_rate, gbs_rbs, chosen = np.asarray(rb_rate_mbps, dtype=np.float64), np.asarray(num_rbs), np.asarray(choice)
    if rb_rate.ndim < 2 or chosen.ndim < 1 or rb_rate.shape[-2:] != (chosen.shape[-1], *gbs_rbs.shape):
        shapes = f"rb_rate_mbps has shape {rb_rate.shape}, num_rbs {gbs_rbs.shape}, choice {chosen.shape}"
        raise UserError(f"{shapes}: expected [..., N, M], [M] and [..., N]")
    every_gbs = np.arange(len(gbs_rbs))
    if not np.isin(chosen, every_gbs).all() or not np.issubdtype(chosen.dtype, np.integer):
        raise UserError(f"a choice must be the index of a GBS: a whole number from 0 to {every_gbs[-1]}")
    loads = (chosen[..., None] == every_gbs).sum(axis=-2)  # n_b [..., M]
    shares = np.vectorize(rb_share)(gbs_rbs[chosen], np.take_along_axis(loads, chosen, axis=-1))
    return np.asarray(shares * np.where(chosen[..., None] == every_gbs, rb_rate, 0.0).sum(axis=-1))


def deviation_cycle(choice: ArrayLike, uavs: tuple[int, int], targets: tuple[int, int]) -> Ints:
    """Joint choices around a closed cycle: the first UAV deviates, then the second; the first returns, the second too.

    :param choice: index of the GBS that each UAV chooses at first [..., N]
    :param uavs: indices of the two UAVs
    :param targets: the GBS that each of the two deviates to
    :return: joint choices before each of the four deviations [..., 4, N]; the fourth leads back to the first
    """
    around = np.repeat(np.asarray(choice, dtype=np.int64)[..., None, :], 4, axis=-2)
    around[..., 1:3, uavs[0]] = targets[0]
    around[..., 2:4, uavs[1]] = targets[1]
    return around


def cycle_gain(payoffs: ArrayLike, uavs: tuple[int, int]) -> Floats:
    """Sum of the deviators' gains around a closed cycle of four deviations, as :func:`deviation_cycle` makes it.

    A game has an exact potential if and only if this is 0 for all such cycles (Monderer and Shapley, 1996,
    Corollary 2.9); what it differs from 0 by is how far these payoffs are from having one.

    :param payoffs: rates or log-rates of all UAVs in the four joint choices of a cycle [..., 4, N]
    :param uavs: indices of the two UAVs
    :return: sum of the four gains, in the unit of the payoffs [...]
    """
    first, second = (np.asarray(payoffs, dtype=np.float64)[..., i] for i in uavs)  # each [..., 4]
    gains = (
        first[..., 1] - first[..., 0],
        second[..., 2] - second[..., 1],
        first[..., 3] - first[..., 2],
        second[..., 0] - second[..., 3],
    )
    return np.asarray(sum(gains))


def one_slot_game(simulator: Simulator, game: int) -> OneSlotGame:
    """The association game of the next slot, as one game of a simulator stands.

    A cell of which a UAV can reach no voxel within the slot carries 0 Mbps for it, so that nobody gains by choosing it.
    The rates of a joint choice are those of the real slot if all flying UAVs, and no others, take part in it and make
    the moves. A UAV that is done carries 0 Mbps everywhere and should be left out; if it stays where it arrived, it
    takes RBs of its cell, which this game does not know. Collisions are ignored: two UAVs that choose one GBS may be
    sent to the same voxel.

    :param simulator: the games
    :param game: index of the game
    :return: what an RB carries, and the moves; of voxels that carry the same, the first in the action table
    """
    rules, state = simulator.rules, simulator.state
    shape = (state.flying.shape[1], len(rules.num_rbs))
    rb_rate_mbps, actions = np.zeros(shape), np.zeros(shape, dtype=np.int64)
    for i in np.flatnonzero(state.flying[game]):
        here, goal = voxel_of(state.position, game, int(i)), voxel_of(state.destination, game, int(i))
        for a, (x, y, z) in enumerate(rules.actions):
            end = move(here, (x, y, z), rules.grid, rules.clip_moves)
            if rules.fly_through:
                end = stop_at(here, end, goal)
            b = rules.cell[end]
            if rules.rb_rate_mbps[end] > rb_rate_mbps[i, b]:
                rb_rate_mbps[i, b], actions[i, b] = rules.rb_rate_mbps[end], a
    return OneSlotGame(rb_rate_mbps, actions)
