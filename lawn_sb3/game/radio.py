"""The radio link: nearest-GBS association, cell loads, equal RB shares and rates (Section II-A)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from lawn_sb3.game.compiled import njit
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NEAREST = 5
"""GBSs that are looked at for each voxel where there are more."""


def link_distances_m(position_m: Floats, gbs_positions_m: Floats) -> Floats:
    """Distances ||q_i - g_b|| from a position to every GBS.

    :param position_m: positions in metres [..., 3]
    :param gbs_positions_m: GBS positions in metres [M, 3], or for each position [..., M, 3]
    :return: distances in metres [..., M]
    """
    return np.asarray(np.linalg.norm(position_m[..., None, :] - gbs_positions_m, axis=-1))


def nearest_gbs(distances_m: Floats) -> Ints:
    """The association rule, above Eq. (1): a UAV is served by the nearest GBS; a tie goes to the lower index.

    b_i = argmin_k ||q_i - g_k||

    :param distances_m: distances to every GBS in metres [..., M]
    :return: index of the serving GBS [...]
    """
    # Distances that differ only by rounding are a tie, on every machine.
    return np.asarray(np.argmin(np.round(distances_m, 6), axis=-1), dtype=np.int64)


@njit
def rb_share(num_rbs: int, cell_load: int) -> int:
    """RBs of each UAV in a cell, Eq. (1), eq:rb.

    kappa_{b,i} = floor(K_b / n_b)

    :param num_rbs: K_b, RBs of the GBS
    :param cell_load: n_b, UAVs that it serves, at least 1
    :return: kappa_{b,i} in RBs

    >>> [rb_share(10, load) for load in (1, 2, 3, 11)]
    [10, 5, 3, 0]
    """
    return num_rbs // cell_load


def rb_rate_mbps(distance_m: Floats, snr_at_1m: float, path_loss_exponent: float, rb_bandwidth_hz: float) -> Floats:
    """Rate over a single RB: Eq. (2), eq:rate, with kappa = 1.

    r_ib = Delta f log2(1 + P_tx beta_0 / (sigma^2 d^alpha))

    :param distance_m: d, link distance in metres, above 0
    :param snr_at_1m: P_tx beta_0 / sigma^2, linear
    :param path_loss_exponent: alpha
    :param rb_bandwidth_hz: Delta f in Hz
    :return: r_ib in Mbps

    >>> rb_rate_mbps(np.array(10.0), 300.0, 2.0, 180e3)  # SNR 300 / 10^2 = 3: 0.18 MHz * log2(4)
    array(0.36)
    """
    snr = snr_at_1m / np.asarray(distance_m) ** path_loss_exponent
    return np.asarray(rb_bandwidth_hz * np.log2(1.0 + snr) / 1e6)


@njit
def achievable_rate_mbps(num_rbs: int, single_rb_rate_mbps: float) -> float:
    """Achievable rate, Eq. (2), eq:rate.

    R_i = kappa_{b,i} Delta f log2(1 + P_tx beta_0 / (sigma^2 d^alpha)) = kappa_{b,i} r_ib

    :param num_rbs: kappa_{b,i}, RBs of the UAV, from :func:`rb_share`
    :param single_rb_rate_mbps: r_ib, what one RB carries where the UAV is, from :func:`rb_rate_mbps`
    :return: R_i in Mbps
    """
    return num_rbs * single_rb_rate_mbps


class RadioMap(NamedTuple):
    """What the link is worth in each voxel, evaluated once at the voxel centres."""

    cell: Ints
    """Serving GBS b [W, L, H]."""
    rb_rate_mbps: Floats
    """Rate over one RB in Mbps [W, L, H]."""


def radio_map(scenario: Scenario) -> RadioMap:
    """Evaluate association and rate in every voxel.

    :param scenario: the scenario
    :return: the map

    >>> link = radio_map(Scenario())
    >>> link.cell[2, 7, 0], round(float(link.rb_rate_mbps[2, 7, 0]), 3)  # 5 m above GBS 1: SNR 97.47 dB
    (np.int64(1), 5.828)
    """
    voxels = np.moveaxis(np.indices(scenario.grid), 0, -1).reshape(-1, 3)
    cell, serving_m = _serving_gbs(scenario.voxel_centre(voxels), scenario.gbs_positions)
    rate = rb_rate_mbps(serving_m, scenario.snr_at_1m, scenario.path_loss_exponent, scenario.rb_bandwidth_hz)
    return RadioMap(cell.reshape(scenario.grid), rate.reshape(scenario.grid))


def _serving_gbs(position_m: Floats, gbs_positions_m: Floats) -> tuple[Ints, Floats]:
    """Index of the serving GBS and the distance to it in metres, for positions in metres [B, 3].

    Of many GBSs only the nearest few are looked at, unless all of these are equally near.
    """
    near = np.arange(len(gbs_positions_m))
    if len(near) > NEAREST:
        apart_m, found = map(np.asarray, KDTree(gbs_positions_m).query(position_m, NEAREST))
        crowded = apart_m[:, -1] - apart_m[:, 0] < 1e-5
        cell, serving_m = _nearest_of(position_m, gbs_positions_m, np.sort(found, axis=-1))
        cell[crowded], serving_m[crowded] = _nearest_of(position_m[crowded], gbs_positions_m, near)
        return cell, serving_m
    return _nearest_of(position_m, gbs_positions_m, near)


def _nearest_of(position_m: Floats, gbs_positions_m: Floats, indices: Ints) -> tuple[Ints, Floats]:
    """The same of given GBSs alone: ascending indices, for all positions [K] or for each [B, K]."""
    distances_m = link_distances_m(position_m, gbs_positions_m[indices])
    first = nearest_gbs(distances_m)[:, None]
    indices = np.broadcast_to(indices, distances_m.shape)
    return np.take_along_axis(indices, first, 1)[:, 0], np.take_along_axis(distances_m, first, 1)[:, 0]


def cell_borders(scenario: Scenario) -> Floats:
    """Where neighbouring voxels of the lowest layer belong to different GBSs.

    :param scenario: the scenario
    :return: line segments on the ground in metres [B, 2, 2]
    """
    cell, size = radio_map(scenario).cell[:, :, 0], scenario.voxel_size_m
    segments = [[(x + 1, y), (x + 1, y + 1)] for x, y in np.argwhere(cell[1:] != cell[:-1])]
    segments += [[(x, y + 1), (x + 1, y + 1)] for x, y in np.argwhere(cell[:, 1:] != cell[:, :-1])]
    return size * np.array(segments, dtype=np.float64).reshape(-1, 2, 2)


def rate_unit_mbps(scenario: Scenario) -> float:
    """The unit of rates and utilities inside the rewards (reading ``rate_unit``).

    :param scenario: the scenario
    :return: Mbps; for ``lone-uav`` the rate of a UAV alone in its cell, one voxel away from its GBS, which has the
        most RBs of all

    >>> round(rate_unit_mbps(Scenario()), 2)  # 10 RBs of 0.18 MHz * log2(1 + 10^9.1447)
    54.68
    """
    if scenario.rate_unit == "mbps":
        return 1.0
    if isinstance(scenario.rate_unit, float):
        return scenario.rate_unit
    voxel_m = np.array(scenario.voxel_size_m)
    rate = rb_rate_mbps(voxel_m, scenario.snr_at_1m, scenario.path_loss_exponent, scenario.rb_bandwidth_hz)
    return achievable_rate_mbps(int(scenario.num_rbs.max()), float(rate))
