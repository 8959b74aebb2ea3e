"""Claims about the game: whether it has a potential, and whether a policy collects the welfare that there is."""

from __future__ import annotations

import pytest

from lawn_sb3.paper.claims.claim import CannotTellError, Finding
from lawn_sb3.paper.claims.game_theory import costs_fairness, has_potential, maximises_welfare
from tests.paper.claims.by_hand import evidence, flown, recipe_of


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


def test_fairness_is_judged_on_average_and_episode_by_episode() -> None:
    # Two UAVs with x and y have the Gini coefficient |x - y| / 2(x + y): 0.25 for 10 and 30, 0 for 20 and 20.
    even, uneven = [20.0, 20.0], [10.0, 30.0]
    recipe = recipe_of(episodes=2)

    def judged(welfare: list[float], equilibrium: list[float]) -> Finding:
        flights = {"welfare": welfare, "equilibrium": equilibrium}
        return costs_fairness(
            evidence(*(flown(role, 2, utility_mbps=[own] * 2) for role, own in flights.items()), recipe=recipe),
            "welfare",
            "equilibrium",
        )

    assert judged(uneven + uneven, even + even).verdict == "reproduced"
    assert judged(even + even, uneven + even).verdict == "not reproduced"
    sometimes = judged(uneven + even, [8.0, 32.0, *even])  # 0.125 against 0.15 on average
    assert sometimes.verdict == "not reproduced"
    mixed = judged(uneven + even, [*even, 5.0, 35.0])  # 0.25 and 0 against 0 and 0.375
    assert mixed.verdict == "partly"
    assert "difference -0.062 [-0.062, -0.062]; in 50 % of the episodes WELFARE is the less even one" in mixed.figure


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
