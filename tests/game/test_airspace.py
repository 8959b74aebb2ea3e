"""The airspace of Section II-B: action set, moves, least flight times and missions."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lawn_sb3.errors import UserError
from lawn_sb3.game import Missions, draw_missions
from lawn_sb3.game.airspace import (
    Voxel,
    action_table,
    check_missions,
    distance,
    is_inside,
    min_slots,
    move,
    moves_in_time,
    stop_at,
)
from lawn_sb3.scenario import PRESETS
from tests.game.random_play import SEEDS, scenarios

GRID = (4, 5, 3)
VOXELS = st.tuples(st.integers(0, 3), st.integers(0, 4), st.integers(0, 2))
DISPLACEMENTS = st.tuples(*[st.integers(-6, 6)] * 3)
TWO_UAVS = PRESETS["paper"].changed(num_uavs=2)


# Points of the integer lattice with L1 norm k: 1, 6, 18, 38, 66 for k = 0 ... 4. Up to v_max they sum to these.
@pytest.mark.parametrize(("v_max", "size"), [(1, 7), (2, 25), (3, 63), (4, 129)])
def test_action_set_holds_every_displacement_up_to_v_max_once(v_max: int, size: int) -> None:
    table = action_table(v_max)
    assert table.shape == (size, 3)
    assert np.abs(table).sum(axis=1).max() == v_max
    assert len({tuple(row) for row in table.tolist()}) == size


@pytest.mark.parametrize(
    ("voxel", "displacement", "clipped", "hovering"),
    [
        ((1, 2, 0), (1, -1, 1), (2, 1, 1), (2, 1, 1)),  # inside: (1, 2, 0) + (1, -1, 1) = (2, 1, 1)
        # (3, 1, 0) + (2, 1, -1) = (5, 2, -1); in a 4 x 5 x 3 airspace x ends at 3 and z begins at 0.
        ((3, 1, 0), (2, 1, -1), (3, 2, 0), (3, 1, 0)),
    ],
)
def test_a_move_out_of_the_airspace_is_clipped_by_coordinate_or_refused_as_a_whole(
    voxel: Voxel, displacement: Voxel, clipped: Voxel, hovering: Voxel
) -> None:
    assert move(voxel, displacement, GRID, True) == clipped
    assert move(voxel, displacement, GRID, False) == hovering


@given(voxel=VOXELS, displacement=DISPLACEMENTS, clip=st.booleans())
def test_moves_stay_inside_the_airspace(voxel: Voxel, displacement: Voxel, clip: bool) -> None:
    assert is_inside(move(voxel, displacement, GRID, clip), GRID)


def test_airspace_ends_at_its_last_voxels() -> None:
    assert all(is_inside(voxel, GRID) for voxel in [(0, 0, 0), (3, 4, 2)])
    outside = [(4, 4, 2), (3, 5, 2), (3, 4, 3), (-1, 0, 0), (0, -1, 0), (0, 0, -1)]
    assert [voxel for voxel in outside if is_inside(voxel, GRID)] == []


# From (0, 0, 0) to (2, 1, 2): along x through (1, 0, 0) to (2, 0, 0), then y to (2, 1, 0), then z through (2, 1, 1).
@pytest.mark.parametrize("passed", [(1, 0, 0), (2, 0, 0), (2, 1, 0), (2, 1, 1), (2, 1, 2)])
def test_flying_through_stops_at_a_destination_on_the_way(passed: Voxel) -> None:
    assert stop_at((0, 0, 0), (2, 1, 2), passed) == passed


# And back: through (1, 1, 2) to (0, 1, 2), then to (0, 0, 2), then through (0, 0, 1).
@pytest.mark.parametrize("passed", [(1, 1, 2), (0, 1, 2), (0, 0, 2), (0, 0, 1), (0, 0, 0)])
def test_flying_through_stops_on_the_way_down_too(passed: Voxel) -> None:
    assert stop_at((2, 1, 2), (0, 0, 0), passed) == passed


@pytest.mark.parametrize("missed", [(0, 1, 0), (1, 1, 0), (0, 0, 1), (2, 0, 1), (3, 0, 0), (2, 2, 0), (2, 1, 3)])
def test_flying_through_misses_a_destination_off_the_way(missed: Voxel) -> None:
    assert stop_at((0, 0, 0), (2, 1, 2), missed) == (2, 1, 2)


def test_in_time_moves_of_a_mission_worked_out_by_hand() -> None:
    # From (0, 0, 0) to (4, 0, 0) with v_max = 3 in two slots: the first move has to leave at most three steps.
    moves = action_table(3)
    allowed = moves_in_time(np.array([0, 0, 0]), np.array([4, 0, 0]), np.array(2), moves, (10, 10, 3), 3)
    steps_left = np.abs(moves - [4, 0, 0]).sum(axis=1)
    np.testing.assert_array_equal(allowed, (moves >= 0).all(axis=1) & (steps_left <= 3))
    assert not allowed[0]  # hovering leaves four steps for one slot


@pytest.mark.parametrize(
    ("destination", "slots"),
    [
        ((3, 2, 1), 2),  # ceil((3 + 2 + 1) / 3) = 2
        ((0, 1, 0), 1),  # ceil(1 / 3) = 1
    ],
)
def test_least_flight_time_is_l1_distance_over_speed_rounded_up(destination: Voxel, slots: int) -> None:
    assert min_slots((0, 0, 0), destination, 3) == slots
    assert min_slots(destination, (0, 0, 0), 3) == slots


def test_distance_is_euclidean() -> None:
    # sqrt((1 - 3)^2 + (2 - 5)^2 + (7 - 1)^2) = sqrt(4 + 9 + 36) = 7
    assert distance((1, 2, 7), (3, 5, 1)) == 7.0


@given(scenario=scenarios(), seed=SEEDS)
@settings(max_examples=50)
def test_origins_and_destinations_of_a_game_are_distinct_voxels(scenario: Any, seed: int) -> None:
    missions = draw_missions(scenario, 3, np.random.default_rng(seed))
    for ends in np.concatenate(missions, axis=1):
        assert len(np.unique(ends, axis=0)) == 2 * scenario.num_uavs
        assert (ends >= 0).all()
        assert (ends < scenario.grid).all()


def test_missions_can_fill_the_airspace() -> None:
    full = PRESETS["paper"].changed(width_voxels=2, length_voxels=2, max_altitude_m=20.0, num_uavs=4)
    missions = draw_missions(full, 1, np.random.default_rng(0))
    assert len(np.unique(np.concatenate(missions, axis=1)[0], axis=0)) == 8


# Mean |x - x'| of two uniform whole numbers below n is (n - 1/n) / 3: 3.3 for n = 10, 33.33 for 100, 0.889 for 3,
# 9.99 for 30. The mean L1 distance is 7.49 (paper) or 76.66 (as printed) and, between distinct voxels, 7.51 (paper);
# over 3 voxels a slot, rounding up adds about 1/3 slot: 2.84 and 25.9.
@pytest.mark.parametrize(("preset", "mean_slots"), [("paper", 2.84), ("as-printed", 25.9)])
def test_missions_are_uniform_over_the_airspace(preset: str, mean_slots: float) -> None:
    missions = draw_missions(PRESETS[preset], 10_000, np.random.default_rng(0))
    l1 = np.abs(missions.origins - missions.destinations).sum(axis=-1)
    assert np.ceil(l1 / 3).mean() == pytest.approx(mean_slots, rel=0.01)


ORIGINS, DESTINATIONS = [[0, 0, 0], [1, 1, 1]], [[9, 9, 2], [5, 5, 0]]


def test_missions_for_all_games_alike_are_repeated_for_each() -> None:
    checked = check_missions(TWO_UAVS, Missions(np.array(ORIGINS), np.array(DESTINATIONS)), 3)
    assert checked.origins.tolist() == [ORIGINS] * 3
    assert checked.destinations.tolist() == [DESTINATIONS] * 3


def test_missions_can_be_given_game_by_game() -> None:
    origins, destinations = np.array([ORIGINS, DESTINATIONS]), np.array([DESTINATIONS, ORIGINS])
    checked = check_missions(TWO_UAVS, Missions(origins, destinations), 2)
    assert checked.origins.tolist() == [ORIGINS, DESTINATIONS]
    assert checked.destinations.tolist() == [DESTINATIONS, ORIGINS]


def test_a_uav_may_fly_to_where_another_one_starts() -> None:
    swap = Missions(np.array(ORIGINS), np.array(ORIGINS[::-1]))
    assert check_missions(TWO_UAVS, swap, 1).destinations.tolist() == [ORIGINS[::-1]]


@pytest.mark.parametrize(
    ("origins", "destinations", "said"),
    [
        ([[0, 0, 0], [10, 1, 1]], DESTINATIONS, ["origins", "UAV 1", "[10, 1, 1]", "(10, 10, 3)"]),
        (ORIGINS, [[9, 9, -1], [5, 5, 0]], ["destinations", "UAV 0", "[9, 9, -1]", "(10, 10, 3)"]),
        (ORIGINS, [[9, 9, 2], [1, 1, 1]], ["UAV 1", "origin", "destination"]),
        ([[1, 1, 1], [1, 1, 1]], DESTINATIONS, ["share an origin"]),
        (ORIGINS[:1], DESTINATIONS, ["origins", "(1, 3)", "(2, 3)"]),
        (ORIGINS, [[9, 9], [5, 5]], ["destinations", "(2, 2)", "(2, 3)"]),
        ([ORIGINS, ORIGINS], DESTINATIONS, ["origins", "(2, 2, 3)", "(1, 2, 3)"]),
        (ORIGINS, [[9.5, 9, 2], [5, 5, 0]], ["destinations", "whole", "float64"]),
    ],
    ids=["above-grid", "below-grid", "no-way-to-go", "shared-origin", "too-few", "flat", "too-many-games", "fraction"],
)
def test_mission_that_cannot_be_flown_is_refused_in_one_line(
    origins: list[Any], destinations: list[Any], said: list[str]
) -> None:
    with pytest.raises(UserError) as refusal:
        check_missions(TWO_UAVS, Missions(np.array(origins), np.array(destinations)), 1)
    message = str(refusal.value)
    assert "\n" not in message
    assert [words for words in said if words not in message] == []
