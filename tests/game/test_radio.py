"""The radio link of Section II-A: association, RB shares and rates."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lawn_sb3.game.radio import (
    achievable_rate_mbps,
    cell_borders,
    link_distances_m,
    nearest_gbs,
    radio_map,
    rate_unit_mbps,
    rb_rate_mbps,
    rb_share,
)
from lawn_sb3.scenario import PRESETS, Scenario

PAPER = PRESETS["paper"]


def rb_rate(distance_m: float, snr_at_1m: float, path_loss_exponent: float, rb_bandwidth_hz: float) -> float:
    return float(rb_rate_mbps(np.array(distance_m), snr_at_1m, path_loss_exponent, rb_bandwidth_hz))


# Association: b_i = argmin_k ||q_i - g_k||


def test_link_distance_is_euclidean_and_in_metres() -> None:
    # From (5, 5, 5) to (7, 8, -1): sqrt(2^2 + 3^2 + 6^2) = 7; to (5, 5, 0): 5
    distances = link_distances_m(np.array([5.0, 5.0, 5.0]), np.array([[7.0, 8.0, -1.0], [5.0, 5.0, 0.0]]))
    assert distances.tolist() == [7.0, 5.0]


def test_uav_is_served_by_the_nearest_gbs() -> None:
    assert nearest_gbs(np.array([[30.0, 10.0, 20.0], [5.0, 10.0, 20.0]])).tolist() == [1, 0]


def test_tie_between_gbss_goes_to_the_lower_index_despite_rounding() -> None:
    assert nearest_gbs(np.array([50.0, 20.0 + 1e-12, 20.0])) == 1


RING = [(55.0 + 30.0 * math.cos(k), 55.0 + 30.0 * math.sin(k), 0.0) for k in np.linspace(0.0, 2 * math.pi, 12, False)]


@given(
    sites=st.lists(st.tuples(*(st.integers(0, 10).map(lambda n: 10.0 * n),) * 2, st.just(0.0)), min_size=6, unique=True)
)
@example(sites=RING)  # twelve GBSs equally near to the middle
@settings(max_examples=25, deadline=None)
def test_of_many_gbss_the_nearest_of_all_serves(sites: list[tuple[float, float, float]]) -> None:
    scenario = PAPER.changed(width_voxels=11, length_voxels=11, gbs_positions_m=sites)
    voxels = np.moveaxis(np.indices(scenario.grid), 0, -1)
    distances_m = link_distances_m(scenario.voxel_centre(voxels), scenario.gbs_positions)
    np.testing.assert_array_equal(radio_map(scenario).cell, nearest_gbs(distances_m))


@given(num_rbs=st.integers(1, 300), load=st.integers(1, 300))
def test_rb_shares_never_exceed_the_rbs_of_the_gbs_in_sum(num_rbs: int, load: int) -> None:
    assert 0 <= num_rbs - load * rb_share(num_rbs, load) < load


def test_rate_falls_with_the_path_loss_exponent() -> None:
    # SNR = 56 / 2^3 = 7, log2(1 + 7) = 3, 1 MHz * 3 = 3 Mbps
    assert rb_rate(2.0, 56.0, 3.0, 1e6) == pytest.approx(3.0)


@given(num_rbs=st.integers(1, 100), load=st.integers(1, 20), distance_m=st.floats(1.0, 1e4), alpha=st.floats(1.5, 5.0))
def test_rate_never_rises_with_load_nor_with_distance(num_rbs: int, load: int, distance_m: float, alpha: float) -> None:
    near, far = (rb_rate(d, 1e9, alpha, 180e3) for d in (distance_m, 1.1 * distance_m))
    rate = achievable_rate_mbps(rb_share(num_rbs, load), near)
    assert achievable_rate_mbps(rb_share(num_rbs, load + 1), near) <= rate
    assert achievable_rate_mbps(rb_share(num_rbs, load), far) <= rate


def test_each_quarter_of_the_paper_s_airspace_is_one_cell() -> None:
    cell = radio_map(PAPER).cell
    assert cell.shape == (10, 10, 3)
    assert [np.unique(quarter).tolist() for half in np.split(cell, 2) for quarter in np.split(half, 2, axis=1)] == [
        [0],
        [1],
        [2],
        [3],
    ]


def test_rate_is_evaluated_at_the_voxel_centre() -> None:
    # Voxel (4, 2, 2) has its centre at (45, 25, 25), sqrt(20^2 + 25^2) = 32.016 m away: 111.447 - 30.107 = 81.341 dB,
    # log2(1 + 10^8.1341) = 27.021, 4.864 Mbps.
    assert radio_map(PAPER).rb_rate_mbps[4, 2, 2] == pytest.approx(4.864, abs=5e-4)
    # With the floor of the airspace at 20 m, voxel (4, 2, 0) has its centre there.
    raised = radio_map(PAPER.changed(min_altitude_m=20.0, max_altitude_m=50.0))
    assert raised.rb_rate_mbps[4, 2, 0] == pytest.approx(4.864, abs=5e-4)


def test_rate_unit_is_a_lone_uav_s_rate_or_mbps_or_a_number_of_mbps() -> None:
    # One voxel from its GBS: 111.447 dB - 20 log10(10) = 91.447 dB, 10 RBs * 180 kHz * log2(1 + 10^9.1447)
    assert rate_unit_mbps(PAPER) == pytest.approx(1.8 * math.log2(1 + 10**9.144727), rel=1e-6)
    assert rate_unit_mbps(PAPER.changed(rate_unit="mbps")) == 1.0
    assert rate_unit_mbps(PAPER.changed(rate_unit=27.5)) == 27.5


def test_the_papers_cells_are_quarters_of_the_area() -> None:
    # Four GBSs at the quarter points: borders along x = 50 m and y = 50 m, 10 voxels each.
    borders = cell_borders(PAPER)
    assert borders.shape == (20, 2, 2)
    upright = borders[borders[:, 0, 0] == borders[:, 1, 0]]
    level = borders[borders[:, 0, 1] == borders[:, 1, 1]]
    assert (upright[..., 0] == 50.0).all()
    assert (level[..., 1] == 50.0).all()
    assert sorted(upright[:, 0, 1]) == sorted(level[:, 0, 0]) == [10.0 * k for k in range(10)]


def test_a_border_lies_wherever_neighbours_are_served_by_different_gbss() -> None:
    game = Scenario(gbs_positions_m=((11.0, 42.0, 0.0), (63.0, 77.0, 0.0), (88.0, 9.0, 0.0)))
    cell = radio_map(game).cell[:, :, 0]
    assert len(cell_borders(game)) == (cell[1:] != cell[:-1]).sum() + (cell[:, 1:] != cell[:, :-1]).sum()
    assert cell_borders(game.changed(gbs_positions_m=((11.0, 42.0, 0.0),))).shape == (0, 2, 2)
