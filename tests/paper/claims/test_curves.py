"""Training curves: crossings, relapses, fluctuations and declines, as one reads them off a figure."""

from collections.abc import Sequence
from typing import Any

import pandas as pd
import pytest

from lawn_sb3.paper.claims.curves import (
    fluctuates_more,
    iql_declines,
    parameter_sharing,
    reward_approximates_utility,
    stable_thereafter,
    success_within_150k,
)
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.roles import FORMS
from tests.handmade import evidence, flown_by_seed, method_of, recipe_of_parts, trained

MISSIONS = "missions/success_percent"
Curves = Sequence[Sequence[float]]


def both(role: str, greedy: Curves, missions: Curves) -> pd.DataFrame:
    shown = trained(role, *missions, column=MISSIONS)
    return trained(role, *greedy).merge(shown, on=["method", "seed", "time/env_steps"], how="outer")


def mappo(greedy: Curves, missions: Curves) -> Evidence:
    """The same curves of both forms of CTDE-MAPPO."""
    return evidence(curves=[both(role, greedy, missions) for role in FORMS])


def test_a_level_is_reached_when_the_slowest_seed_gets_there() -> None:
    # Greedy after 50 K and 100 K env steps; training missions, averaged over all points so far, after 100 K each.
    finding = success_within_150k(mappo([[96, 97], [0, 95]], [[90, 100], [91, 99]]))
    assert finding.verdict == "reproduced"
    assert "MAPPO: 100,000 env steps greedy, 100,000 env steps in training missions" in finding.figure


def test_a_level_reached_late_or_by_some_seeds_alone_is_not() -> None:
    late = mappo([[0, 0, 0, 96]] * 2, [[0, 0, 0, 100]] * 2)  # 200 K; on average 25 % in training
    finding = success_within_150k(late)
    assert finding.verdict == "contradicted"
    assert "200,000 env steps greedy, never in training missions" in finding.figure
    one_late = mappo([[96] * 4, [0, 0, 0, 96]], [[100] * 4] * 2)
    assert success_within_150k(one_late).verdict == "partly"
    finding = success_within_150k(mappo([[96], [94]], [[100], [100]]))
    assert finding.verdict == "partly"
    assert "50,000 env steps greedy (1 of 2 seeds never), 50,000 env steps in training missions" in finding.figure


def test_a_training_too_short_to_tell_is_not_held_against_a_method() -> None:
    short = {role: method_of(role, env_steps=50_000) for role in FORMS}
    found = evidence(curves=[both(role, [[90]], [[90]]) for role in FORMS], recipe=recipe_of_parts(short))
    with pytest.raises(CannotTellError, match="trainings of 150,000 env steps of MAPPO"):
        success_within_150k(found)
    found = evidence(curves=[both(role, [[96]], [[96]]) for role in FORMS], recipe=recipe_of_parts(short))
    assert success_within_150k(found).verdict == "reproduced"


def test_a_method_that_never_falls_back_is_stable() -> None:
    finding = stable_thereafter(mappo([[90, 95, 96]] * 2, [[97, 96, 95]] * 2))
    assert finding.verdict == "reproduced"
    assert "MAPPO: 0 of 2 points below greedy, lowest 95.0 %, of one seed 95.0 %, 0 of 3 points" in finding.figure
    assert finding.why == (
        "No point of the mean after its first at 95 % may lie below it. The trainings end after 150,000 env steps: "
        "beyond was not looked."
    )


def test_a_relapse_of_the_mean_breaks_it() -> None:
    finding = stable_thereafter(mappo([[95, 99, 99], [95, 60, 99]], [[97] * 3] * 2))
    assert finding.verdict == "partly"
    assert "1 of 3 points below greedy, lowest 79.5 %, of one seed 60.0 %" in finding.figure
    assert "; not so MAPPO greedy and MAPPO-O greedy. " in finding.why


def test_a_relapse_of_one_seed_that_the_mean_outweighs_is_told_alone() -> None:
    finding = stable_thereafter(mappo([[95, 99, 99], [95, 93, 99]], [[97] * 3] * 2))
    assert finding.verdict == "reproduced"
    assert "0 of 3 points below greedy, lowest 95.0 %, of one seed 93.0 %" in finding.figure


def test_training_missions_are_smoothed_before_a_relapse_counts() -> None:
    # 100 and 92 average to 96.
    assert stable_thereafter(mappo([[99] * 2] * 2, [[100, 92]] * 2)).verdict == "reproduced"


def test_a_method_that_never_gets_there_is_not_stable() -> None:
    finding = stable_thereafter(mappo([[90, 91], [99, 99]], [[90, 91]] * 2))
    assert finding.verdict == "contradicted"
    assert "not every seed there greedy" in finding.figure


def test_fluctuation_is_the_mean_change_in_the_second_half() -> None:
    # Second halves: QMIX 80, 90, 70 (changes 10 and 20, mean 15), MAPPO 90, 91, 90 (mean 1).
    found = evidence(curves=[trained("qmix", *[[0, 50, 80, 90, 70]] * 2), trained("mappo", *[[0, 50, 90, 91, 90]] * 2)])
    finding = fluctuates_more(found, "qmix", ["mappo"])
    assert finding.verdict == "reproduced"
    assert finding.figure == "QMIX: 15.00 [15.00, 15.00] points; MAPPO: 1.00 [1.00, 1.00] points"
    assert finding.why == "Each difference (14.00 [14.00, 14.00]) has to lie above 0: 1 of 1 does."
    assert fluctuates_more(found, "mappo", ["qmix"]).verdict == "contradicted"


def test_more_fluctuation_that_may_be_chance_is_not_shown() -> None:
    # Changes of 2 and 4 against 1 and 1: mean 2, standard error 1, and 12.71 of them count with two seeds.
    found = evidence(
        curves=[trained("qmix", [50, 50, 52, 50], [50, 50, 54, 50]), trained("mappo", *[[50, 50, 51, 50]] * 2)]
    )
    finding = fluctuates_more(found, "qmix", ["mappo"])
    assert finding.verdict == "not shown"
    assert "(2.00 [-10.71, 14.71])" in finding.why


def test_curves_that_never_change_do_not_fluctuate_more_than_each_other() -> None:
    flat = evidence(curves=[trained(role, *[[100] * 4] * 2) for role in ("qmix", "mappo")])
    assert fluctuates_more(flat, "qmix", ["mappo"]).verdict == "not shown"


def test_more_than_one_of_two_forms_is_partly() -> None:
    shown = {"qmix": [80, 90, 80], "mappo": [80, 99, 80], "mappo-o": [80, 81, 80]}
    found = evidence(curves=[trained(role, *[values] * 2) for role, values in shown.items()])
    finding = fluctuates_more(found, "qmix", ["mappo", "mappo-o"])
    assert finding.verdict == "partly"
    assert finding.why.endswith("1 of 2 does.")


@pytest.mark.parametrize(
    ("curves", "reason"),
    [
        ([trained("mappo", [80, 90, 80], [80, 90, 80])], "algo qmix"),
        ([trained("qmix", [80, 90, 80]), trained("mappo", [80, 90, 80])], "two seeds"),
        ([trained("qmix", [80], [80]), trained("mappo", [80], [80])], "three points"),
        ([trained("qmix", [80], [80], column="other"), trained("mappo", [80], [80])], "learning curve of QMIX"),
    ],
)
def test_fluctuation_needs_curves_of_several_points_and_seeds(curves: list[pd.DataFrame], reason: str) -> None:
    with pytest.raises(CannotTellError, match=reason):
        fluctuates_more(evidence(curves=curves), "qmix", ["mappo"])


def test_who_is_higher_on_average_learns_faster() -> None:
    # Means over training 60 and 40.
    found = evidence(curves=[trained("mappo-o", *[[30, 90]] * 2), trained("mappo-separate", *[[0, 80]] * 2)])
    finding = parameter_sharing(found)
    assert finding.verdict == "reproduced"
    assert "MAPPO-O: 60.00 [60.00, 60.00] %; MAPPO-SEPARATE: 40.00" in finding.figure
    level = evidence(curves=[trained(role, *[[30, 90]] * 2) for role in ("mappo-o", "mappo-separate")])
    assert parameter_sharing(level).verdict == "not shown"


@pytest.mark.parametrize(
    ("seeds", "verdict"),
    [
        ([[60, 40, 30, 20], [70, 50, 40, 26]], "reproduced"),  # early peak of 65; lost 40 and 44
        ([[10, 20, 60, 20], [10, 20, 70, 26]], "partly"),  # the same, but the peak is late
        ([[60, 99, 99, 98], [60, 99, 99, 98]], "not shown"),  # lost 1
        ([[60, 40, 30, 20], [60, 60, 60, 60]], "not shown"),  # lost 40 and 0: not in every training
        ([[60, 40, 30, 50], [60, 40, 30, 20]], "not shown"),  # 10 and 40, each more than 5: 25 +- 12.71 * 15
        ([[60, 60, 60, 59], [60, 60, 60, 56]], "not shown"),  # 1 and 4, each less than 5: 2.5 +- 12.71 * 1.5
        ([[90, 0, 60, 50], [0, 90, 60, 50]], "not shown"),  # each peaks by chance: where the other does, lost -50
        ([[10, 20, 30, 40], [10, 20, 30, 40]], "not shown"),  # never fell
    ],
)
def test_a_decline_is_a_loss_of_all_seeds_from_an_early_peak(seeds: Curves, verdict: str) -> None:
    assert iql_declines(evidence(curves=[trained("iql", *seeds)])).verdict == verdict


def test_a_decline_is_described_by_peak_end_and_loss() -> None:
    finding = iql_declines(evidence(curves=[trained("iql", [60, 40, 30, 20], [70, 50, 40, 26])]))
    assert finding.figure == (
        "IQL: peak of the mean 65.0 % at 50,000 of 200,000 env steps, end 23.0 %, lost 42.0 [16.6, 67.4] points"
    )
    with pytest.raises(CannotTellError, match="two seeds"):
        iql_declines(evidence(curves=[trained("iql", [60, 20])]))


def rising(utility: Sequence[float], missions: Sequence[float] = (1.0, 2.0, 3.0)) -> Evidence:
    """Two equal seeds of both forms whose reward rises from evaluation to evaluation, and from mission to mission."""
    rewards = range(1, len(utility) + 1)
    curves = [
        trained(role, *[rewards] * 2, column="greedy/reward").merge(
            trained(role, *[utility] * 2, column="greedy/utility_mbps")
        )
        for role in FORMS
    ]
    own: dict[str, Any] = {"reward": [[1.0, 2.0, 3.0]] * 2, "utility_mbps": [missions] * 2}
    return evidence(*(flown_by_seed(role, **own) for role in FORMS), curves=curves)


@pytest.mark.parametrize(
    ("utility", "whole", "late", "verdict"),
    [
        ([10, 20, 30, 40, 90], "1.00", "1.00", "reproduced"),
        # Ranks 1, 2, 3, 5, 4: 1 - 6 (1 + 1) / (5 * 24) = 0.9; the last three as 2, 1, 3 and 3, 1, 2.
        ([10, 20, 40, 30, 90], "0.90", "0.50", "reproduced"),
        ([10, 20, 90, 30, 40], "0.70", "-0.50", "partly"),
        ([50, 40, 30, 20, 10], "-1.00", "-1.00", "partly"),
    ],
)
def test_figures_rise_together_if_they_rank_evaluations_alike_early_and_late(
    utility: list[float], whole: str, late: str, verdict: str
) -> None:
    finding = reward_approximates_utility(rising(utility))
    assert finding.verdict == verdict
    assert finding.figure.startswith(
        f"MAPPO: rank correlation {whole} [{whole}, {whole}], in the second half of training {late} [{late}, {late}], "
        "over UAVs of the test missions 1.00 [1.00, 1.00]; "
    )


def test_rewards_that_rank_missions_otherwise_do_not_approximate_utility() -> None:
    assert reward_approximates_utility(rising([10, 20, 30, 40, 90], [2.0, 3.0, 1.0])).verdict == "partly"
    assert reward_approximates_utility(rising([50, 40, 30, 20, 10], [3.0, 2.0, 1.0])).verdict == "contradicted"


def test_correlations_of_seeds_that_spread_are_not_shown() -> None:
    # 1 and 0.6 over missions, both above 0.5: 0.8 +- 12.71 * 0.2. The curves correlate by 1 and 1.
    found = rising([10, 20, 30, 40, 90])
    rewards, utilities = (
        [1.0, 2.0, 3.0, 4.0],
        [[1.0, 2.0, 3.0, 4.0], [1.0, 4.0, 2.0, 3.0]],
    )  # 1 - 6 * 6 / (4 * 15) = 0.4
    rows = [flown_by_seed(role, reward=[rewards] * 2, utility_mbps=utilities) for role in FORMS]
    finding = reward_approximates_utility(evidence(*rows, curves=[found.results.curves]))
    assert finding.verdict == "partly"
    assert finding.why.startswith("Each has to reach 0.5, where one ranks much as the other does: 4 of 6 do, 2 cannot")


@pytest.mark.parametrize("utility", [[10, 10, 10, 10, 10], [10, 20, 30, 30, 30], [10, 20, 30]])
def test_constants_and_two_points_have_no_rank_correlation(utility: list[float]) -> None:
    with pytest.raises(CannotTellError, match="points that differ"):
        reward_approximates_utility(rising(utility))
