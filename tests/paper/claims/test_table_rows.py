"""Rows of Table II: agreement within three standard errors, and what the printed times can mean."""

from typing import Any

import pytest

from lawn_sb3.paper.claims import Finding
from lawn_sb3.paper.claims.evidence import CannotTellError
from lawn_sb3.paper.claims.table_rows import (
    agrees_with_row,
    average_completion,
    perfect_success,
    random_flat,
    time_ratio,
)
from lawn_sb3.paper.roles import FORMS
from tests.handmade import evidence, flown_by_seed, measured


def mappo_row(**changes: Any) -> Finding:
    """The paper's row, where nothing ever varies, but for some columns."""
    row: dict[str, Any] = {"reward": 3.19, "rate_mbps": 35.68, "makespan_slots": 8.7, "arrived": True}
    columns = {name: [[value] * 2] * 2 for name, value in row.items()}
    return agrees_with_row(evidence(flown_by_seed("mappo", **{**columns, **changes})), "mappo")


def test_a_row_that_comes_out_is_reproduced() -> None:
    finding = mappo_row()
    assert finding.verdict == "reproduced"
    assert "R̂ 35.68 [35.68, 35.68] (paper 35.68)" in finding.figure


def test_figures_that_are_off_are_named_with_their_distance() -> None:
    finding = mappo_row(reward=[[4.0] * 2] * 2)
    assert finding.verdict == "partly"
    assert finding.why == "J̄ above the paper's by 0.81."
    # With success: no UAV arrives.
    assert mappo_row(arrived=[[False] * 2] * 2, rate_mbps=[[30.0] * 2] * 2).why == (
        "R̂ below the paper's by 5.68 and success below the paper's by 100.00."
    )


def test_a_row_of_which_nothing_comes_out_is_not_reproduced() -> None:
    assert agrees_with_row(measured("reward", iql=[[9.0] * 2] * 2), "iql").verdict == "contradicted"


@pytest.mark.parametrize(("mean", "verdict"), [(6.2, "reproduced"), (6.3, "partly")])
def test_three_standard_errors_decide(mean: float, verdict: str) -> None:
    # Two missions, mean +- 1: variance 2. Theirs and ours: 2 (1/2 + 1/200) = 1.01, so three errors are 3.015. The seeds
    # do not differ, and the rounding of 0.005 does not count. The paper has 3.19: 3.01 and 3.11 away.
    assert mappo_row(reward=[[mean - 1.0, mean + 1.0]] * 2).verdict == verdict


@pytest.mark.parametrize(("mean", "verdict"), [(6.7, "reproduced"), (6.8, "partly")])
def test_seeds_that_differ_widen_the_error(mean: float, verdict: str) -> None:
    # Seeds at mean +- 1: variance 2, times 1/2 + 1/5 (theirs are five) = 1.4; three errors: 3.55. 3.51 and 3.61 away.
    assert mappo_row(reward=[[mean - 1.0] * 2, [mean + 1.0] * 2]).verdict == verdict


def test_the_rounding_of_print_counts() -> None:
    # T-bar is printed to 0.1: three times half of it is 0.15.
    for makespan, verdict in ((8.84, "reproduced"), (8.86, "partly")):
        assert mappo_row(makespan_slots=[[makespan] * 2] * 2).verdict == verdict


def test_a_row_needs_a_row_of_the_paper_and_two_seeds() -> None:
    with pytest.raises(CannotTellError, match="a row of IPPO in the paper's Table II"):
        agrees_with_row(measured("reward", ippo=[[1.0]] * 2), "ippo")
    with pytest.raises(CannotTellError, match="two seeds"):
        agrees_with_row(measured("reward", iql=[[1.0]]), "iql")


def test_a_printed_time_above_the_mean_over_uavs_is_impossible() -> None:
    # One UAV arrives after 40 slots, one fails at 100: 70 on average, 100 until the last is done.
    found = evidence(flown_by_seed("random", num_uavs=2, slots=[[40, 100]] * 2, makespan_slots=[[100, 100]] * 2))
    finding = average_completion(found)
    assert finding.verdict == "impossible as printed"
    assert "T 70.0 [70.0, 70.0] slots on average over the UAVs, 100.0 [100.0, 100.0] until the last" in finding.figure


def test_a_printed_time_that_nobody_undercuts_is_reproduced() -> None:
    assert average_completion(measured("slots", random=[[100]] * 2)).verdict == "reproduced"
    # 99.7 to 100 slots: the interval reaches the printed time.
    assert average_completion(measured("slots", random=[[99.7], [100]])).verdict == "reproduced"
    with pytest.raises(CannotTellError, match="two seeds"):
        average_completion(measured("slots", random=[[40]]))


@pytest.mark.parametrize(
    ("straight_slots", "other_slots", "verdict"),
    [(5, 8, "reproduced"), (6, 8, "partly"), (5, 4, "partly"), (4, 4, "contradicted")],
)
def test_the_time_ratio_never_exceeds_1_and_is_1_on_a_shortest_path(
    straight_slots: int, other_slots: int, verdict: str
) -> None:
    # Missions of at least five slots.
    found = evidence(
        flown_by_seed("straight", slots=[[straight_slots]], min_slots=[[5]]),
        flown_by_seed("qmix", slots=[[other_slots]], min_slots=[[5]]),
    )
    finding = time_ratio(found)
    assert finding.verdict == verdict
    assert f"STRAIGHT: from {5 / straight_slots:.3f} to" in finding.figure


def test_a_time_ratio_of_0_is_none() -> None:
    found = evidence(flown_by_seed("straight", arrived=[[True]]), flown_by_seed("qmix", min_slots=[[0]]))
    assert time_ratio(found).verdict == "partly"


def test_failed_missions_have_no_time_ratio() -> None:
    found = evidence(flown_by_seed("straight", slots=[[1, 9]], arrived=[[True, False]]))
    assert time_ratio(found).verdict == "reproduced"
    with pytest.raises(CannotTellError, match="completed missions of STRAIGHT"):
        time_ratio(evidence(flown_by_seed("straight", arrived=[[False]])))


def test_a_player_is_flat_whose_seeds_get_much_the_same() -> None:
    def judged(uavs: int) -> Finding:
        """One of so many UAVs arrives with the first seed, two with the second."""
        return random_flat(measured("arrived", random=[[k < seed for k in range(uavs)] for seed in (1, 2)]))

    finding = judged(25)  # 4 % and 8 %
    assert finding.verdict == "reproduced"
    assert finding.figure == "RANDOM: success 6.00 [4.00, 8.00]"
    assert finding.why.endswith("has to be narrower than 5 points, and is 4.0 wide.")
    assert judged(20).verdict == "not shown"  # 5 % and 10 %: it has no curve that could show the contrary
    with pytest.raises(CannotTellError, match="two seeds"):
        random_flat(measured("arrived", random=[[True]]))


def test_a_perfect_success_is_so_once_rounded() -> None:
    # One of 2,500 fails: 99.96 %, printed 100.0. One of 1,000: 99.9 %.
    most, fewer = [False] + [True] * 2499, [False] + [True] * 999

    def judged(*forms: list[bool]) -> Finding:
        return perfect_success(measured("arrived", **{role: [own] for role, own in zip(FORMS, forms, strict=True)}))

    assert judged(most, most).verdict == "reproduced"
    assert judged(fewer, fewer).verdict == "not shown"  # one seed has no interval
    seeds = {role: [fewer, fewer] for role in FORMS}
    assert perfect_success(measured("arrived", **seeds)).verdict == "contradicted"
    both = judged(most, fewer)
    assert both.verdict == "partly"
    assert both.figure == "MAPPO: success 99.96; MAPPO-O: success 99.90"
    assert both.why == "Rounded to one decimal the mean has to reach 100: 1 of 2 does, 1 cannot be told."
