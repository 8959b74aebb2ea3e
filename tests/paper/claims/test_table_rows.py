"""Rows of Table II: agreement within three standard errors, and what the printed times can mean."""

from __future__ import annotations

from typing import Any

import pytest

from lawn_sb3.paper.claims.claim import CannotTellError
from lawn_sb3.paper.claims.table_rows import agrees_with_row, average_completion, reaches, time_ratio, varies_little
from tests.paper.claims.by_hand import evidence, flown

MAPPO_ROW: dict[str, Any] = {  # the paper's, where nothing ever varies
    "reward": [[3.19] * 2] * 2, "rate_mbps": [[35.68] * 2] * 2, "makespan_slots": [[8.7] * 2] * 2,
    "arrived": [[True] * 2] * 2,
}  # fmt: skip


def test_a_row_that_comes_out_is_reproduced() -> None:
    finding = agrees_with_row(evidence(flown("mappo", **MAPPO_ROW)), "mappo")
    assert finding.verdict == "reproduced"
    assert "R̂ 35.68 [35.68, 35.68] (paper 35.68)" in finding.figure


def test_figures_that_are_off_are_named_with_their_distance() -> None:
    finding = agrees_with_row(evidence(flown("mappo", **{**MAPPO_ROW, "reward": [[4.0] * 2] * 2})), "mappo")
    assert finding.verdict == "partly"
    assert finding.why == "J̄ above the paper's by 0.81."
    # With success: no UAV arrives.
    changed = {**MAPPO_ROW, "arrived": [[False] * 2] * 2, "rate_mbps": [[30.0] * 2] * 2}
    assert agrees_with_row(evidence(flown("mappo", **changed)), "mappo").why == (
        "R̂ below the paper's by 5.68 and success below the paper's by 100.00."
    )


def test_a_row_of_which_nothing_comes_out_is_not_reproduced() -> None:
    assert agrees_with_row(evidence(flown("iql", reward=[[9.0] * 2] * 2)), "iql").verdict == "not reproduced"


@pytest.mark.parametrize(("mean", "verdict"), [(6.2, "reproduced"), (6.3, "partly")])
def test_three_standard_errors_decide(mean: float, verdict: str) -> None:
    # Two missions, mean +- 1: variance 2. Theirs and ours: 2 (1/2 + 1/200) = 1.01, so three errors are 3.015. The seeds
    # do not differ, and the rounding of 0.005 does not count. The paper has 3.19: 3.01 and 3.11 away.
    changed = {**MAPPO_ROW, "reward": [[mean - 1.0, mean + 1.0]] * 2}
    assert agrees_with_row(evidence(flown("mappo", **changed)), "mappo").verdict == verdict


@pytest.mark.parametrize(("mean", "verdict"), [(6.7, "reproduced"), (6.8, "partly")])
def test_seeds_that_differ_widen_the_error(mean: float, verdict: str) -> None:
    # Seeds at mean +- 1: variance 2, times 1/2 + 1/5 (theirs are five) = 1.4; three errors: 3.55. 3.51 and 3.61 away.
    changed = {**MAPPO_ROW, "reward": [[mean - 1.0] * 2, [mean + 1.0] * 2]}
    assert agrees_with_row(evidence(flown("mappo", **changed)), "mappo").verdict == verdict


def test_the_rounding_of_print_counts() -> None:
    # T-bar is printed to 0.1: three times half of it is 0.15.
    for makespan, verdict in ((8.84, "reproduced"), (8.86, "partly")):
        changed = {**MAPPO_ROW, "makespan_slots": [[makespan] * 2] * 2}
        assert agrees_with_row(evidence(flown("mappo", **changed)), "mappo").verdict == verdict


def test_a_row_needs_a_row_of_the_paper_and_two_seeds() -> None:
    with pytest.raises(CannotTellError, match="a row of IPPO in the paper's Table II"):
        agrees_with_row(evidence(flown("ippo", reward=[[1.0]] * 2)), "ippo")
    with pytest.raises(CannotTellError, match="two seeds"):
        agrees_with_row(evidence(flown("iql", reward=[[1.0]])), "iql")


def test_a_printed_time_above_the_mean_over_uavs_is_impossible() -> None:
    # One UAV arrives after 40 slots, one fails at 100: 70 on average, 100 until the last is done.
    found = evidence(flown("random", num_uavs=2, slots=[[40, 100]] * 2, makespan_slots=[[100, 100]] * 2))
    finding = average_completion(found, "random")
    assert finding.verdict == "impossible as printed"
    assert "T 70.0 [70.0, 70.0] slots on average over the UAVs, 100.0 [100.0, 100.0] until the last" in finding.figure


def test_a_printed_time_that_nobody_undercuts_is_reproduced() -> None:
    assert average_completion(evidence(flown("random", slots=[[100]] * 2)), "random").verdict == "reproduced"
    # 99.7 to 100 slots: the interval reaches the printed time.
    assert average_completion(evidence(flown("random", slots=[[99.7], [100]])), "random").verdict == "reproduced"
    with pytest.raises(CannotTellError, match="two seeds"):
        average_completion(evidence(flown("random", slots=[[40]])), "random")


@pytest.mark.parametrize(
    ("straight_slots", "other_slots", "verdict"),
    [(5, 8, "reproduced"), (6, 8, "partly"), (5, 4, "partly"), (4, 4, "not reproduced")],
)
def test_the_time_ratio_never_exceeds_1_and_is_1_on_a_shortest_path(
    straight_slots: int, other_slots: int, verdict: str
) -> None:
    # Missions of at least five slots.
    found = evidence(flown("straight", slots=[[straight_slots]]), flown("qmix", slots=[[other_slots]]))
    finding = time_ratio(found, "straight")
    assert finding.verdict == verdict
    assert f"STRAIGHT: from {5 / straight_slots:.3f} to" in finding.figure


def test_a_time_ratio_of_0_is_none() -> None:
    found = evidence(flown("straight", slots=[[5]]), flown("qmix", min_slots=[[0]]))
    assert time_ratio(found, "straight").verdict == "partly"


def test_failed_missions_have_no_time_ratio() -> None:
    found = evidence(flown("straight", slots=[[5, 1]], arrived=[[True, False]]))
    assert time_ratio(found, "straight").verdict == "reproduced"
    with pytest.raises(CannotTellError, match="completed missions of STRAIGHT"):
        time_ratio(evidence(flown("straight", arrived=[[False]])), "straight")


def test_a_player_is_flat_whose_seeds_get_much_the_same() -> None:
    # 25 % and 50 % success: the interval is 25 points wide.
    found = evidence(flown("random", arrived=[[True, False, False, False], [True, True, False, False]]))
    finding = varies_little(found, "success_percent", "random", 25.1)
    assert finding.verdict == "reproduced"
    assert finding.figure == "RANDOM: success 37.50 [25.00, 50.00]"
    assert finding.why.endswith("has to be narrower than 25.1 points, and is 25.0 wide.")
    assert varies_little(found, "success_percent", "random", 25.0).verdict == "not reproduced"
    with pytest.raises(CannotTellError, match="two seeds"):
        varies_little(evidence(flown("random", arrived=[[True]])), "success_percent", "random", 5.0)


def test_a_perfect_success_is_so_once_rounded() -> None:
    # One of 2,500 fails: 99.96 %, printed 100.0. One of 1,000: 99.9 %.
    found = evidence(
        flown("mappo", arrived=[[False] + [True] * 2499]), flown("mappo-o", arrived=[[False] + [True] * 999])
    )
    assert reaches(found, "success_percent", ["mappo"], 100.0).verdict == "reproduced"
    assert reaches(found, "success_percent", ["mappo-o"], 100.0).verdict == "not reproduced"
    both = reaches(found, "success_percent", ["mappo", "mappo-o"], 100.0)
    assert both.verdict == "partly"
    assert both.figure == "MAPPO: success 99.96; MAPPO-O: success 99.90"
    assert both.why == "Rounded to one decimal the mean has to reach 100: 1 of 2 do."
