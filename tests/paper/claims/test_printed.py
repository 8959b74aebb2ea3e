"""Claims that the paper's own constants and equations decide."""

from collections.abc import Sequence

import pandas as pd
import pytest

from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.printed import (
    continuous_actions,
    critic_team_return,
    ema_consistency,
    one_voxel_a_slot,
    payoff_decomposition,
    rate_term_duration,
    share_falls,
    sum_rate_inadequate,
    table_1_grid,
    table_1_reward_unit,
    voxel_centres,
)
from tests.handmade import evidence, flown, recipe_of_parts


def game(*changes: str) -> Evidence:
    return evidence(recipe=recipe_of_parts(changes=changes))


@pytest.mark.parametrize(
    ("changes", "shares", "verdict"),
    [
        ((), "N = 4: 10, 5, 3, 2", "reproduced"),
        (("rbs_per_gbs=2",), "2, 1, 0, 0", "partly"),  # the fourth UAV loses nothing any more, nor do the others
        (("rbs_per_gbs=[10, 2, 2, 10]",), "2, 1, 0, 0; 10, 5, 3, 2", "partly"),
    ],
)
def test_the_rb_share_falls_with_every_uav_that_enters(changes: Sequence[str], shares: str, verdict: str) -> None:
    finding = share_falls(game(*changes))
    assert finding.verdict == verdict
    assert finding.figure.endswith(shares)


def test_one_uav_shares_with_nobody() -> None:
    with pytest.raises(CannotTellError, match="two UAVs"):
        share_falls(game("num_uavs=1"))


def test_moves_of_three_steps_leave_the_voxel_behind() -> None:
    # Of the 63 displacements of L1 norm up to 3, one hovers and six lead one voxel on.
    finding = one_voxel_a_slot(game())
    assert finding.verdict == "impossible as printed"
    assert finding.figure == "56 of the 63 moves of A_i lead further than 1 voxel with v_max = 3"


def test_the_action_space_is_finite() -> None:
    finding = continuous_actions(game())
    assert (finding.verdict, finding.figure) == ("impossible as printed", "A_i has 63 elements")


def test_near_a_gbs_a_voxel_is_not_of_one_rate() -> None:
    # Scenario paper, voxel 5 m above a GBS: of the 27 points one is 5 - 10/3 = 1.67 m above it, and the farthest stand
    # 8.33 m above and 3.33 m aside in x and y, 9.58 m away. 20 lg(9.58 / 1.67) = 15.2 dB of the centre's 97.5 dB.
    finding = voxel_centres(game())
    assert finding.verdict == "partly"
    assert finding.figure.startswith("10 x 10 x 3 voxels: the mean is at most ")
    assert ", the range " in finding.figure
    assert " % on average and 16 % at most, above 8 % in " in finding.figure
    assert finding.why.endswith("4 of 6 do.")


def test_far_from_every_gbs_a_voxel_is_of_one_rate() -> None:
    # 1 km aside, a voxel of 10 m is some 1 % of the way to the GBS, and there is no other GBS.
    far = game("gbs_positions_m=[[5000, 50, 0]]", "rbs_per_gbs=10")
    assert voxel_centres(far).why.endswith("5 of 6 do.")  # the printed grid's range is what does not


def test_another_gbs_may_be_nearer_within_a_voxel() -> None:
    # The middle of GBSs at x = 0 and 52 is x = 26: of the voxels from 20 to 30, a tenth, the last third lies beyond.
    split = game("gbs_positions_m=[[0, 50, 0], [52, 50, 0]]", "rbs_per_gbs=10")
    assert "another GBS is nearer somewhere in 10 %; 100 x" in voxel_centres(split).figure


def test_a_sum_of_rates_grows_with_the_flight_and_does_not_see_fluctuation() -> None:
    finding = sum_rate_inadequate(game())
    assert finding.verdict == "reproduced"  # made "by construction" where all claims are judged
    assert finding.figure == (
        "a steady 30 Mbps adds up to 30 over 1, 300 over 10 and 3000 over 100 slots; 20 and 40 Mbps by turns to 300 "
        "over 10"
    )


@pytest.mark.parametrize(("num_uavs", "share", "verdict"), [(1, "1", "reproduced"), (4, "0.25", "partly")])
def test_the_critic_that_fits_best_has_a_share_of_the_teams_return(num_uavs: int, share: str, verdict: str) -> None:
    finding = critic_team_return(game(f"num_uavs={num_uavs}"))
    assert finding.verdict == verdict
    assert finding.figure == f"N = {num_uavs}: the best V(x) is {share} of the team's return"


def test_fluctuation_as_such_costs_nothing() -> None:
    # Of two neighbouring slots the later weighs 1 and the earlier 0.9: (0.9 * 20 + 40) / 1.9 = 30.53 and 29.47.
    finding = ema_consistency(game())
    assert finding.verdict == "partly"
    assert "give R̂ 30.0; 20 and 40 Mbps by turns give 30.5 or 29.5" in finding.figure
    assert finding.figure.endswith("30.0 on average")


def test_a_longer_flight_at_the_same_rate_is_paid_more() -> None:
    # 1 - 0.9^T of the rate after T slots: 0.1, 0.651, 1.000.
    finding = rate_term_duration(game())
    assert finding.verdict == "partly"
    assert finding.figure.endswith("10 % after 1, 65 % after 10 and 100 % after 100 slots")


def test_the_payoff_is_a_sum_over_slots_once_the_flight_time_is_chosen() -> None:
    finding = payoff_decomposition(game("max_slots=30"))
    assert finding.verdict == "contradicted"
    assert finding.figure.endswith("Mbps over flights of 1 to 30 slots")


@pytest.mark.parametrize(("mean", "verdict"), [(9.1, "impossible as printed"), (9.0, "not testable")])
def test_a_time_below_the_least_flight_time_is_impossible(mean: float, verdict: str) -> None:
    # 200 missions that need mean +- 1 slots: variance 1, so that three errors of the difference between their mean and
    # one of 200 other missions are 3 sqrt(2 / 200) = 0.3. The paper prints 8.7, which may be 8.75.
    finding = table_1_grid(evidence(printed_grid=flown("random", 0, min_slots=[mean - 1, mean + 1] * 100)))
    assert finding.verdict == verdict
    assert finding.figure.startswith(f"100 x 100 x 30 voxels: T_min is {mean} ± 0.1 slots on average")
    assert "took 8.7); Random succeeds in 100.00 % of the missions (paper 22.4 %)" in finding.figure


@pytest.mark.parametrize(("most", "verdict"), [(3.7, "impossible as printed"), (3.4, "not testable")])
def test_a_least_reward_above_the_printed_one_is_impossible(most: float, verdict: str) -> None:
    # Three of four UAVs at 3.1: 3.25 or 3.175 on average; the paper prints 3.19.
    terms = pd.DataFrame({"min_slots": [1, 2], "uavs": [3, 1], "least_mbps": [3.1, most]})
    finding = table_1_reward_unit(evidence(least_reward=terms))
    assert finding.verdict == verdict
    assert "in units of 54.7 Mbps (paper 3.19)" in finding.figure
