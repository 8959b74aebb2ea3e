"""The radio link: nearest-GBS association, cell loads, equal RB shares and rates (Section II-A)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.compiled import njit
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def link_distances_m(position_m: Floats, gbs_positions_m: Floats) -> Floats:
    """Distances ||q_i - g_b|| from a position to every GBS.

    :param position_m: positions in metres [..., 3]
    :param gbs_positions_m: GBS positions in metres [M, 3]
    :return: distances in metres [..., M]
    """
    return np.asarray(np.linalg.norm(position_m[..., None, :] - gbs_positions_m, axis=-1))


def nearest_gbs(distances_m: Floats) -> Ints:
    """The association rule b_i = argmin_k ||q_i - g_k||; a tie goes to the lower index.

    :param distances_m: distances to every GBS in metres [..., M]
    :return: index of the serving GBS [...]
    """
    # Distances that differ only by rounding are a tie, on every machine.
    return np.asarray(np.argmin(np.round(distances_m, 6), axis=-1), dtype=np.int64)


@njit
def rb_share(num_rbs: int, cell_load: int) -> int:
    """Equal RB allocation kappa_{b,i} (eq:rb).

    :param num_rbs: RBs K_b of the GBS
    :param cell_load: UAVs n_b it serves, at least 1
    :return: RBs for each of them, rounded down
    """
    return num_rbs // cell_load


def rb_rate_mbps(distance_m: Floats, snr_at_1m: float, path_loss_exponent: float, rb_bandwidth_hz: float) -> Floats:
    """Rate over a single RB: eq:rate with kappa = 1.

    :param distance_m: link distance in metres, above 0
    :param snr_at_1m: P_tx * beta_0 / sigma^2, linear
    :param path_loss_exponent: alpha
    :param rb_bandwidth_hz: Delta f in Hz
    :return: rate in Mbps
    """
    snr = snr_at_1m / np.asarray(distance_m) ** path_loss_exponent
    return np.asarray(rb_bandwidth_hz * np.log2(1.0 + snr) / 1e6)


@njit
def achievable_rate_mbps(num_rbs: int, single_rb_rate_mbps: float) -> float:
    """Achievable rate R_i (eq:rate).

    :param num_rbs: RBs kappa of the UAV
    :param single_rb_rate_mbps: what one RB carries where the UAV is, from :func:`rb_rate_mbps`
    :return: rate in Mbps
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
    """
    voxels = np.moveaxis(np.indices(scenario.grid), 0, -1)
    distances_m = link_distances_m(scenario.voxel_centre(voxels), scenario.gbs_positions)
    cell = nearest_gbs(distances_m)
    serving_m = np.take_along_axis(distances_m, cell[..., None], axis=-1)[..., 0]
    rate = rb_rate_mbps(serving_m, scenario.snr_at_1m, scenario.path_loss_exponent, scenario.rb_bandwidth_hz)
    return RadioMap(cell, rate)


def rate_unit_mbps(scenario: Scenario) -> float:
    """The unit of rates and utilities inside the rewards (reading ``rate_unit``).

    :param scenario: the scenario
    :return: Mbps; for ``lone-uav`` the rate of a UAV alone in its cell, one voxel away from its GBS,
        which has the most RBs of all
    """
    if scenario.rate_unit == "mbps":
        return 1.0
    if isinstance(scenario.rate_unit, float):
        return scenario.rate_unit
    voxel_m = np.array(scenario.voxel_size_m)
    rate = rb_rate_mbps(voxel_m, scenario.snr_at_1m, scenario.path_loss_exponent, scenario.rb_bandwidth_hz)
    return achievable_rate_mbps(int(scenario.num_rbs.max()), float(rate))
