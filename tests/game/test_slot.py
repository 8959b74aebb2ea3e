"""One slot after another in an airspace small enough to work out by hand.

The lane is six voxels in a row, with centres at x = 5, 15 ... 55 m and 5 m high; GBSs stand on the ground at x = 10,
30 and 50 m. Voxels 0 and 1 are cell 0, voxels 2 and 3 cell 1, voxels 4 and 5 cell 2, and every voxel lies sqrt(50) m
from its GBS. There the SNR is 150 / 50 = 3, and an RB of 1 MHz carries log2(1 + 3) = 2 Mbps. Of 10 RBs a lone UAV
gets all, 20 Mbps; two get 5 each, 10 Mbps; three get floor(10 / 3) = 3 each, 6 Mbps.
"""

from typing import Any

import numpy as np
import pytest

from lawn_sb3.game import Missions, Simulator
from lawn_sb3.game.payoff import welfare
from lawn_sb3.game.state import Outcome
from tests.envs.corridor import CORRIDOR

LANE = CORRIDOR.changed(
    name="lane", width_voxels=6, max_voxel_steps=2, max_slots=4, gbs_grid=(3, 1), rbs_per_gbs=10, nav_weight=0.5,
    collision_penalty=1.0, fail_penalty=5.0,
)  # fmt: skip


def lane_game(*missions: tuple[int, int], **changes: Any) -> Simulator:
    """One game in the lane; a mission is its origin and destination along x."""
    simulator = Simulator(LANE.changed(num_uavs=len(missions), **changes), continuation="episode")
    ends = np.array([[(x, 0, 0) for x in mission] for mission in missions])
    simulator.reset(missions=Missions(ends[:, 0], ends[:, 1]))
    return simulator


def fly(simulator: Simulator, *steps: int) -> Outcome:
    """One slot in which each UAV moves along x."""
    actions = [np.flatnonzero((simulator.rules.actions == (dx, 0, 0)).all(axis=1))[0] for dx in steps]
    return simulator.step(np.array([actions]))


def xs(simulator: Simulator) -> list[int]:
    return [int(x) for x in simulator.state.position[0, :, 0]]


def test_a_whole_game_gives_what_is_worked_out_by_hand() -> None:
    game = lane_game((0, 3), (1, 5))
    assert game.state.min_slots.tolist() == [[2, 2]]  # ceil(3 / 2) and ceil(4 / 2)
    assert game.state.cell_load.tolist() == [[2, 0, 0]]

    # Both fly to voxel 2: a collision, 10 Mbps each. EMA 0.5 * 10 = 5, corrected 5 / 0.5 = 10.
    # Progress 3 -> 1 and 4 -> 3 voxels, at 0.5 a voxel.
    first = fly(game, 2, 1)
    assert first.cell.tolist() == [[1, 1]]
    assert first.cell_load.tolist() == [[2, 2]]
    assert first.num_rbs.tolist() == [[5, 5]]
    assert first.rate_mbps[0] == pytest.approx([10.0, 10.0])
    assert first.corrected_rate_mbps[0] == pytest.approx([10.0, 10.0])
    assert first.collided.tolist() == [[True, True]]
    assert first.arrived.tolist() == [[False, False]]
    assert first.reward_terms[0, 0] == pytest.approx([5.0, 1.0, -1.0, 0.0])
    assert first.reward_terms[0, 1] == pytest.approx([5.0, 0.5, -1.0, 0.0])

    # UAV 0 arrives in voxel 3, UAV 1 reaches voxel 4: 20 Mbps each. EMA 0.5 * 5 + 0.5 * 20 = 12.5, up by 7.5;
    # corrected 12.5 / 0.75 = 16.667; U_0 = 16.667 * 2 / 2.
    second = fly(game, 1, 2)
    assert second.rate_mbps[0] == pytest.approx([20.0, 20.0])
    assert second.arrived.tolist() == [[True, False]]
    assert second.reward_terms[0, 0] == pytest.approx([7.5, 0.5, 0.0, 50 / 3])
    assert second.reward_terms[0, 1] == pytest.approx([7.5, 1.0, 0.0, 0.0])
    utilities = second.utility_mbps.copy()
    assert game.state.cell_load.tolist() == [[0, 0, 1]]

    # UAV 1 arrives in voxel 5: EMA 0.5 * 12.5 + 0.5 * 20 = 16.25, up by 3.75; corrected 16.25 / 0.875 = 18.571;
    # U_1 = 18.571 * 2 / 3 = 12.381. W = 16.667 + 12.381 = 29.048.
    third = fly(game, 0, 1)
    assert third.reward_terms[0, 1] == pytest.approx([3.75, 0.5, 0.0, 16.25 / 0.875 * 2 / 3])
    assert not game.state.flying.any()
    assert welfare(utilities + third.utility_mbps) == pytest.approx([29.048], abs=5e-4)


def test_each_gbs_shares_its_own_rbs() -> None:
    # The 4 RBs of cell 0 carry 8 Mbps; two UAVs share the one RB of cell 1 and get none.
    outcome = fly(lane_game((0, 5), (2, 5), (3, 5), rbs_per_gbs=(4, 1, 10)), 0, 0, 0)
    assert outcome.num_rbs.tolist() == [[4, 0, 0]]
    assert outcome.rate_mbps[0] == pytest.approx([8.0, 0.0, 0.0])


# Collisions, Eq. (4)


def test_uavs_that_swap_voxels_do_not_collide() -> None:
    game = lane_game((0, 5), (1, 5))
    assert fly(game, 1, -1).collided.tolist() == [[False, False]]
    assert xs(game) == [1, 0]


def test_only_those_in_the_same_voxel_collide() -> None:
    assert fly(lane_game((0, 5), (1, 5), (2, 5)), 1, 0, 0).collided.tolist() == [[True, True, False]]


def test_a_collision_in_the_destination_counts() -> None:
    outcome = fly(lane_game((0, 2), (3, 5)), 2, -1)
    assert outcome.arrived.tolist() == [[True, False]]
    assert outcome.collided.tolist() == [[True, True]]


def test_games_do_not_collide_nor_share_with_each_other() -> None:
    game = Simulator(LANE.changed(num_uavs=1), num_games=2)
    game.reset(missions=Missions(np.array([[0, 0, 0]]), np.array([[5, 0, 0]])))
    outcome = game.step(np.zeros((2, 1), dtype=int))
    assert not outcome.collided.any()
    assert outcome.cell_load.tolist() == [[1], [1]]


# The deadline, Eq. (5): T_max = 4 slots


def test_mission_fails_in_the_slot_of_the_deadline() -> None:
    game = lane_game((0, 5))
    for _ in range(3):
        assert fly(game, 0).timed_out.tolist() == [[False]]
    last = fly(game, 0)
    assert last.timed_out.tolist() == [[True]]
    assert last.reward_terms[0, 0, 3] == -5.0
    assert last.utility_mbps.tolist() == [[0.0]]
    assert not game.state.flying.any()


def test_arrival_in_the_slot_of_the_deadline_is_in_time() -> None:
    game = lane_game((0, 5))
    for _ in range(3):
        fly(game, 1)
    last = fly(game, 2)
    assert last.arrived.tolist() == [[True]]
    assert last.timed_out.tolist() == [[False]]
    # 20 Mbps throughout; U = 20 * ceil(5 / 2) / 4 = 15
    assert last.utility_mbps[0] == pytest.approx([15.0])


@pytest.mark.parametrize(("reading", "x"), [("clip", 0), ("hover", 1)])
def test_move_out_of_the_airspace_follows_its_reading(reading: str, x: int) -> None:
    game = lane_game((1, 5), out_of_bounds=reading)
    fly(game, -2)
    assert xs(game) == [x]


@pytest.mark.parametrize(
    ("reading", "loads", "collided", "rate_mbps"),
    [("leaves", [0, 1, 0], False, 20.0), ("stays", [1, 1, 0], True, 10.0)],
)
def test_uav_that_has_arrived_keeps_its_rbs_and_voxel_if_it_stays(
    reading: str, loads: list[int], collided: bool, rate_mbps: float
) -> None:
    game = lane_game((0, 1), (3, 0), arrived_uav=reading)
    fly(game, 1, 0)
    assert game.state.cell_load.tolist() == [loads]
    outcome = fly(game, 0, -2)
    assert outcome.collided.tolist() == [[False, collided]]
    assert outcome.cell_load.tolist() == [[0, 1 + collided]]
    assert outcome.rate_mbps[0] == pytest.approx([0.0, rate_mbps])


@pytest.mark.parametrize(("reading", "x", "arrived"), [("slot-end", 2, False), ("fly-through", 1, True)])
def test_passing_the_destination_follows_its_reading(reading: str, x: int, arrived: bool) -> None:
    game = lane_game((0, 1), arrival=reading)
    assert fly(game, 2).arrived.tolist() == [[arrived]]
    assert xs(game) == [x]


# After one slot of 20 Mbps the EMA is 10: 10 / (1 - 0.5^1) = 20, or 10 / (1 - 0.5^4) = 10.667.
@pytest.mark.parametrize(("reading", "corrected"), [("completion", 20.0), ("deadline", 10 / 0.9375)])
def test_bias_is_corrected_over_its_horizon(reading: str, corrected: float) -> None:
    outcome = fly(lane_game((0, 1), bias_horizon=reading), 1)
    assert outcome.corrected_rate_mbps[0] == pytest.approx([corrected])
    assert outcome.utility_mbps[0] == pytest.approx([corrected])


def test_rewards_count_rates_and_utilities_in_the_rate_unit() -> None:
    # 10 m from a GBS the SNR is 1.5: the unit is 10 RBs * 1 MHz * log2(2.5) = 13.219 Mbps.
    # Arrival after one slot at 20 Mbps: EMA 10, U = 20.
    terms = fly(lane_game((0, 1), rate_unit="lone-uav"), 1).reward_terms[0, 0]
    assert terms == pytest.approx([10 / 13.219, 0.5, 0.0, 20 / 13.219], rel=1e-4)
