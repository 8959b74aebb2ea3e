"""Claims about the game: whether it has a potential, and whether a policy collects the welfare that there is."""

from __future__ import annotations

import pytest

from lawn_sb3.report.claims.claim import CannotTellError
from lawn_sb3.report.claims.game_theory import has_potential, maximises_welfare
from tests.report.claims.by_hand import evidence, flown, recipe_of


def test_a_policy_that_earns_less_than_the_planner_does_not_maximise() -> None:
    found = evidence(
        flown("mappo", utility_mbps=[[36.0, 38.0], [36.0, 38.0]]),
        flown("mappo-o", utility_mbps=[[45.0, 47.0], [47.0, 49.0]]),
        flown("welfare", utility_mbps=[[46.0, 47.0], [46.0, 47.0]]),
    )
    below = maximises_welfare(found, ["mappo"], "welfare")
    assert below.verdict == "not reproduced"
    # 37 against 46.5 in both seeds: no spread, so the interval is the difference.
    assert below.figure == "WELFARE: mean U 46.50 Mbps; MAPPO: -9.50 [-9.50, -9.50] Mbps against it"
    assert below.why.endswith("; MAPPO does.")
    level = maximises_welfare(found, ["mappo-o"], "welfare")
    # 46 and 48 against 46.5: 0.5 with a standard error of 1, so 12.7 to both sides.
    assert level.verdict == "reproduced"
    assert "0.50 [-12.21, 13.21]" in level.figure
    assert maximises_welfare(found, ["mappo", "mappo-o"], "welfare").verdict == "partly"


def test_without_the_planner_nobody_can_tell() -> None:
    with pytest.raises(CannotTellError, match="player welfare"):
        maximises_welfare(evidence(flown("mappo", utility_mbps=[[1.0], [1.0]])), ["mappo"], "welfare")


def test_one_slot_has_a_potential_in_log_rates_but_not_in_rates() -> None:
    found = has_potential(evidence(recipe=recipe_of(episodes=20)), 20)
    assert found.verdict == "partly"
    assert ", in 0 for log-rates" in found.figure
    assert "in 0 for rates" not in found.figure


def test_a_single_cell_leaves_nobody_a_choice() -> None:
    one = recipe_of(changes=["gbs_grid=[1, 1]"], episodes=5)
    with pytest.raises(CannotTellError, match="change their cells"):
        has_potential(evidence(recipe=one), 5)


def test_with_equal_links_the_rates_have_a_potential_too() -> None:
    # Two sites among 2 x 2 voxels, each voxel as near to its site as any other: rates depend on the loads alone, which
    # is a congestion game as Rosenthal has them.
    alike = recipe_of(
        changes=["num_uavs=2", "width_voxels=2", "length_voxels=2", "max_altitude_m=10", "gbs_grid=[2, 1]"], episodes=5
    )
    found = has_potential(evidence(recipe=alike), 5)
    assert found.verdict == "reproduced"
