"""Claims that the paper's own constants and equations decide."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from lawn_sb3.paper.claims import printed
from lawn_sb3.paper.claims.claim import CannotTellError, Evidence
from lawn_sb3.paper.claims.printed import (
    continuous_actions,
    duration_pays_nothing,
    fluctuation_costs,
    longest_move,
    printed_grid,
    reward_in_mbps,
    share_falls,
)
from lawn_sb3.paper.printed_values import TABLE_II, PaperRow
from tests.paper.claims.by_hand import evidence, recipe_of


def game(*changes: str, episodes: int = 6) -> Evidence:
    """No runs at all, on a changed game."""
    return evidence(recipe=recipe_of(changes=changes, episodes=episodes))


def other_row(monkeypatch: pytest.MonkeyPatch, **changes: float) -> None:
    """Let the paper print something else of CTDE-MAPPO."""
    row: PaperRow = TABLE_II["CTDE-MAPPO"]._replace(**changes)
    monkeypatch.setattr(printed, "TABLE_II", {**TABLE_II, "CTDE-MAPPO": row})


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
    finding = longest_move(game(), at_most=1)
    assert finding.verdict == "impossible as printed"
    assert finding.figure == "56 of the 63 moves of A_i lead further than 1 voxel with v_max = 3"
    assert longest_move(game(), at_most=3).verdict == "reproduced"


def test_the_action_space_is_finite() -> None:
    finding = continuous_actions(game())
    assert (finding.verdict, finding.figure) == ("impossible as printed", "A_i has 63 elements")


def test_fluctuation_as_such_costs_nothing() -> None:
    # Of two neighbouring slots the later weighs 1 and the earlier 0.9: (0.9 * 20 + 40) / 1.9 = 30.53 and 29.47.
    finding = fluctuation_costs(game())
    assert finding.verdict == "partly"
    assert "give R̂ 30.0; 20 and 40 Mbps by turns give 30.5 or 29.5" in finding.figure
    assert finding.figure.endswith("30.0 on average")


def test_a_longer_flight_at_the_same_rate_is_paid_more() -> None:
    # 1 - 0.9^T of the rate after T slots: 0.1, 0.651, 1.000.
    finding = duration_pays_nothing(game())
    assert finding.verdict == "partly"
    assert finding.figure.endswith("10 % after 1, 65 % after 10 and 100 % after 100 slots")


def test_the_printed_grid_takes_longer_than_the_printed_time() -> None:
    # Mean |x - y| of two draws from n values is (n^2 - 1) / 3n: 33.33 twice and 9.99, over three steps a slot 25.5;
    # rounding up adds a third on average.
    finding = printed_grid(game(episodes=200))
    assert finding.verdict == "impossible as printed"
    assert finding.figure.startswith("100 x 100 x 30 voxels: T_min is 25.")
    assert "took 8.7" in finding.figure


def test_a_printed_time_within_reach_would_leave_the_grid_open(monkeypatch: pytest.MonkeyPatch) -> None:
    other_row(monkeypatch, makespan_slots=40.0)
    assert printed_grid(game()).verdict == "not testable"


def test_the_printed_reward_is_too_small_for_rates_in_mbps() -> None:
    # A UAV that arrives has R-bar + U = R (1 - 0.9^T + T_min/T). If all flew their 2.8 slots at 35.68 Mbps, that were
    # 35.68 * 1.25; somewhat less is possible, but nothing like 3.19.
    finding = reward_in_mbps(game(episodes=50))
    assert finding.verdict == "impossible as printed"
    least = float(finding.figure.split("success: ")[1].split()[0])
    assert 0.5 * 35.68 < least < 1.25 * 35.68
    assert f"{least:.1f} with rates in Mbps, {least / 54.7:.2f} in units of 54.7 Mbps (paper 3.19)" in finding.figure


def test_a_larger_printed_reward_would_leave_the_unit_open(monkeypatch: pytest.MonkeyPatch) -> None:
    other_row(monkeypatch, reward=80.0)
    assert reward_in_mbps(game()).verdict == "not testable"
