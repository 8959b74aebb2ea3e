"""Rows of Table II: agreement within a margin that is shown, and what the printed times can mean."""

from collections.abc import Sequence
from typing import Any

import pytest

from lawn_sb3.paper.claims import Finding
from lawn_sb3.paper.claims.evidence import CannotTellError
from lawn_sb3.paper.claims.table_rows import (
    agrees_with_row,
    average_completion,
    needs_coordination,
    perfect_success,
    random_flat,
    time_ratio,
)
from lawn_sb3.paper.roles import FORMS
from tests.handmade import evidence, flown_by_seed, measured

SPREAD = [-1.0, 1.0] * 100
"""Deviations of 200 episodes: variance 200 / 199, so that two standard errors of a difference are 0.2005."""
ROW: dict[str, Any] = {"reward": 3.19, "rate_mbps": 35.68, "makespan_slots": 8.7, "arrived": True}
"""That of CTDE-MAPPO in the paper."""


def row(role: str = "mappo", /, fitted: bool = False, **changes: Any) -> Finding:
    """The paper's row of CTDE-MAPPO in 200 episodes of two seeds, where nothing ever varies, but for some columns."""
    columns = {name: [[value] * 200] * 2 for name, value in ROW.items()}
    return agrees_with_row(evidence(flown_by_seed(role, **{**columns, **changes})), role, fitted)


def seeds_at(*means: float, spread: Sequence[float] = SPREAD) -> list[list[float]]:
    return [[mean + deviation for deviation in spread] for mean in means]


def test_a_row_that_comes_out_is_reproduced() -> None:
    finding = row()
    assert finding.verdict == "reproduced"
    assert "R̂ 35.68 [35.68, 35.68] (paper 35.68 ± 0.01)" in finding.figure
    assert finding.why.endswith(": all four agree.")


def test_figures_that_are_off_are_named_with_their_distance() -> None:
    finding = row(reward=[[4.0] * 200] * 2)
    assert finding.verdict == "partly"
    assert finding.why.endswith(": J̄ is above the paper's by 0.81.")
    # With success: no UAV arrives.
    assert row(arrived=[[False] * 200] * 2, rate_mbps=[[30.0] * 200] * 2).why.endswith(
        ": R̂ is below the paper's by 5.68 and success is below the paper's by 100.00."
    )


def test_a_row_of_which_nothing_comes_out_is_not_reproduced() -> None:
    assert agrees_with_row(measured("reward", iql=[[9.0] * 200] * 2), "iql").verdict == "contradicted"


@pytest.mark.parametrize(("mean", "verdict"), [(3.39, "reproduced"), (2.99, "reproduced"), (3.40, "partly")])
def test_test_missions_may_move_a_figure_by_two_standard_errors(mean: float, verdict: str) -> None:
    # Both means are over 200 episodes of variance 1.005: 2 sqrt(2 * 1.005 / 200) = 0.2005, and 0.005 of rounding.
    finding = row(reward=seeds_at(mean, mean))
    assert finding.verdict == verdict
    assert "(paper 3.19 ± 0.21)" in finding.figure


def test_the_rounding_of_print_counts() -> None:
    # T-bar is printed to 0.1.
    for makespan, verdict in ((8.74, "reproduced"), (8.76, "partly")):
        assert row(makespan_slots=[[makespan] * 200] * 2).verdict == verdict


def test_noise_between_seeds_leaves_open_whether_a_figure_agrees() -> None:
    # Seeds that differ by 0.002: standard error 0.001, for means of two and of five seeds sqrt(1 + 2 / 5) = 1.18 times
    # that; 12.71 of them are 0.015. By 0.1: 0.75, and so all of the margin of 0.2055 and more.
    assert row(reward=seeds_at(3.189, 3.191)).verdict == "reproduced"
    noisy = row(reward=seeds_at(3.14, 3.24))
    assert noisy.verdict == "partly"
    assert "J̄ 3.19 [2.44, 3.94] (paper 3.19 ± 0.21)" in noisy.figure
    assert noisy.why.endswith(": J̄ cannot be told.")
    # The same noise, whether the mean agrees or not, and far more of it.
    assert row(reward=seeds_at(3.6, 3.7)).why.endswith(": J̄ cannot be told.")
    assert row(reward=seeds_at(-90.0, 90.0)).why.endswith(": J̄ cannot be told.")


def test_a_row_of_noise_alone_is_not_shown() -> None:
    noise = seeds_at(0.0, 100.0)
    finding = row(reward=noise, rate_mbps=noise, makespan_slots=noise, arrived=[[True] * 200, [False] * 200])
    assert finding.verdict == "not shown"


def test_rows_are_tested_among_all_others() -> None:
    # Standard error 0.001 sqrt(1.4), and 0.2055 to either bound: t = 174, p = 0.004 with 1 degree of freedom.
    columns: dict[str, Any] = {name: [[value] * 200] * 2 for name, value in ROW.items()}
    found = evidence(flown_by_seed("mappo", **{**columns, "reward": seeds_at(3.189, 3.191)}))
    assert agrees_with_row(found, "mappo").verdict == "reproduced"
    assert {tested[0] for tested in found.tests.p_values} == {"reward as printed"}
    assert len(found.tests.p_values) == 2
    found.tests.level = 0.001
    assert agrees_with_row(found, "mappo").verdict == "partly"


def test_of_fitted_figures_only_those_that_do_not_agree_say_anything() -> None:
    open_, fails = seeds_at(3.14, 3.24), [[9.0] * 200] * 2
    assert row(fitted=True).verdict == "fitted"
    assert row(fitted=True, reward=open_).verdict == "fitted"  # which is no evidence, so none is needed for it
    assert row(fitted=True, reward=fails).verdict == "contradicted"
    assert row(fitted=True, reward=open_, rate_mbps=fails).verdict == "contradicted"


def test_a_row_needs_a_row_of_the_paper_two_seeds_and_as_many_episodes() -> None:
    with pytest.raises(CannotTellError, match="a row of IPPO in the paper's Table II"):
        agrees_with_row(measured("reward", ippo=[[1.0] * 200] * 2), "ippo")
    with pytest.raises(CannotTellError, match="two seeds"):
        agrees_with_row(measured("reward", iql=[[1.0] * 200]), "iql")
    with pytest.raises(CannotTellError, match="200 test episodes of IQL, as the paper has"):
        agrees_with_row(measured("reward", iql=[[1.0] * 199] * 2), "iql")


def test_a_printed_time_above_the_mean_over_uavs_is_impossible() -> None:
    # One UAV arrives after 40 slots, one fails at 100: 70 on average, 100 until the last is done.
    found = evidence(flown_by_seed("random", num_uavs=2, slots=[[40, 100]] * 2, makespan_slots=[[100, 100]] * 2))
    finding = average_completion(found)
    assert finding.verdict == "impossible as printed"
    assert "T 70.0 [70.0, 70.0] slots on average over the UAVs, 100.0 [100.0, 100.0] until the last" in finding.figure


def test_a_printed_time_that_nobody_undercuts_is_reproduced() -> None:
    assert average_completion(measured("slots", random=[[100]] * 2)).verdict == "reproduced"
    with pytest.raises(CannotTellError, match="two seeds"):
        average_completion(measured("slots", random=[[40]]))


def test_a_printed_time_that_seeds_may_or_may_not_undercut_is_not_shown() -> None:
    # 99.7 and 100 slots: 99.85 +- 12.71 * 0.15; and 98 and 99, both below: 98.5 +- 12.71 * 0.5.
    for seeds in ([[99.7], [100.0]], [[98.0], [99.0]]):
        finding = average_completion(measured("slots", random=seeds))
        assert finding.verdict == "not shown"
        assert finding.why == "The mean over UAVs may not lie below the printed time."


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

    finding = judged(400)  # 0.25 % and 0.5 %: 12.71 standard errors of 0.125 to both sides
    assert finding.verdict == "reproduced"
    assert finding.figure == "RANDOM: success 0.38 [-1.21, 1.96]"
    assert finding.why.endswith("has to be narrower than 5 points, and is 3.2 wide.")
    assert judged(200).verdict == "not shown"  # 0.5 % and 1 %: it has no curve that could show the contrary
    with pytest.raises(CannotTellError, match="two seeds"):
        random_flat(measured("arrived", random=[[True]]))


def test_a_perfect_success_is_so_once_rounded() -> None:
    # One of 2,500 fails: 99.96 %, printed 100.0. One of 1,000: 99.9 %.
    most, fewer = [False] + [True] * 2499, [False] + [True] * 999

    def judged(*forms: list[bool]) -> Finding:
        return perfect_success(measured("arrived", **{role: [own] * 2 for role, own in zip(FORMS, forms, strict=True)}))

    assert judged(most, most).verdict == "reproduced"
    assert judged(fewer, fewer).verdict == "contradicted"
    both = judged(most, fewer)
    assert both.verdict == "partly"
    assert both.figure == "MAPPO: success 99.96 [99.96, 99.96]; MAPPO-O: success 99.90 [99.90, 99.90]"
    assert both.why == "Rounded to one decimal the mean has to reach 100: 1 of 2 does."
    with pytest.raises(CannotTellError, match="two seeds"):
        perfect_success(measured("arrived", **{role: [[True]] for role in FORMS}))


def test_a_success_that_further_seeds_may_miss_is_not_shown() -> None:
    # All of 1,000, and all but one or two: means 99.95 and 99.9, both +- 12.71 times as much as they lack.
    for failed in (1, 2):
        seeds = [[True] * 1000, [False] * failed + [True] * (1000 - failed)]
        finding = perfect_success(measured("arrived", **dict.fromkeys(FORMS, seeds)))
        assert finding.verdict == "not shown"
        assert finding.why.endswith("0 of 2 do, 2 cannot be told.")


def test_seeds_that_are_all_perfect_are_told_as_what_they_are() -> None:
    # Of five: were more than 45 % of all seeds not perfect, five in a row would be in less than 0.55^5 = 5 %.
    finding = perfect_success(measured("arrived", **{role: [[True]] * 5 for role in FORMS}))
    assert finding.verdict == "reproduced"
    assert finding.why.endswith("there is no spread to test: of other seeds up to 45 % still may.")


def test_a_task_that_straight_flight_always_masters_needs_no_coordination() -> None:
    always = needs_coordination(measured("arrived", straight=[[True] * 3] * 2))
    assert always.verdict == "contradicted"
    assert always.figure == "STRAIGHT: success 100.0 %, 0 of 6 missions failed"
    assert always.why == "Some mission has to be failed: none is."
    assert needs_coordination(measured("arrived", straight=[[True, True, False]] * 2)).verdict == "reproduced"


def test_the_margin_of_success_is_no_less_than_chance_has_it_at_the_printed_share() -> None:
    # QMIX: 96.1 % printed, sqrt(96.1 * 3.9 / 4) = 9.68 points an episode of four UAVs, two errors of a difference 1.94.
    qmix: dict[str, Any] = {"reward": 3.01, "rate_mbps": 38.8, "makespan_slots": 34.6, "arrived": True}
    columns: dict[str, Any] = {name: [[value] * 200] * 2 for name, value in qmix.items()}
    flights = flown_by_seed("qmix", **columns)
    assert "success 100.00 [100.00, 100.00] (paper 96.1 ± 1.99)" in agrees_with_row(evidence(flights), "qmix").figure


def test_a_fitted_row_raises_no_bar_for_the_others() -> None:
    columns: dict[str, Any] = {name: [[value] * 200] * 2 for name, value in ROW.items()}
    flights = flown_by_seed("random", **{**columns, "reward": [[-3.5] * 200, [-3.6] * 200]})
    found = evidence(flights)
    agrees_with_row(found, "random", fitted=True)
    assert not found.tests.p_values
    agrees_with_row(found, "random")
    assert found.tests.p_values
