"""Bounds on J: no method with 100 % success lies outside, whatever it flies."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.game.player import RandomPlayer
from lawn_sb3.game.radio import rate_unit_mbps
from lawn_sb3.paper.identification.bounds import (
    Legs,
    draw_legs,
    rate_ceiling_mbps,
    rate_range_mbps,
    rate_terms_mbps,
    rate_weight,
    rewards,
)
from lawn_sb3.paper.identification.candidates import PAPER
from lawn_sb3.paper.identification.possible import bounds_table
from lawn_sb3.paper.identification.reward import TERMS, reward_terms
from lawn_sb3.scenario import Scenario
from tests.game.wanderer import Wanderer

BETAS = st.floats(0.01, 0.95)
HORIZONS = st.sampled_from(["completion", "deadline"])
EVEN = PAPER.changed(num_uavs=1, path_loss_exponent=1e-12)
"""One UAV has the same rate everywhere: with these the bounds are worked out by hand."""


def reward_bounds(
    scenario: Scenario, legs: Legs, rate_mbps: float, makespan_slots: float, unit_mbps: float
) -> tuple[float, float]:
    """The least and the largest mean J of a method that always arrives and never collides."""
    ends = (rate_terms_mbps(scenario, legs.min_slots, rate_mbps, makespan_slots, largest) for largest in (False, True))
    lower, upper = (float(rewards(legs, terms, scenario.nav_weight, unit_mbps).mean()) for terms in ends)
    return lower, upper


def bounds_of(scenario: Scenario, episodes: int, seed: int, figures: dict[str, float]) -> tuple[float, float]:
    legs = draw_legs(scenario, episodes, seed)
    return reward_bounds(scenario, legs, figures["rate_mbps"], figures["makespan_slots"], rate_unit_mbps(scenario))


@settings(max_examples=25)
@given(
    seed=st.integers(0, 10_000),
    slots=st.integers(0, 40),
    ema_beta=BETAS,
    nav_weight=st.floats(0.0, 2.0),
    collision_penalty=st.floats(0.0, 2.0),
    rate_unit=st.sampled_from(["lone-uav", "mbps"]),
    bias_horizon=HORIZONS,
)
def test_a_player_that_always_arrives_lies_within_the_bounds(seed: int, slots: int, **constants: float | str) -> None:
    scenario = PAPER.changed(**constants)
    figures = summarize(evaluate(Wanderer(slots), scenario, 10, seed))
    assert figures["success_percent"] == 100.0
    lower, upper = bounds_of(scenario, 10, seed, figures)
    assert figures["reward"] <= upper + 1e-6
    assert figures["reward"] + scenario.collision_penalty * figures["collisions"] >= lower - 1e-6


def test_the_shortest_flight_at_an_even_rate_reaches_the_upper_bound() -> None:
    figures = summarize(evaluate(Wanderer(), EVEN, 20, seed=4))
    assert figures["reward"] == pytest.approx(bounds_of(EVEN, 20, 4, figures)[1])


def test_bounds_by_hand() -> None:
    # nav_weight * distance = 0.5 * 5; g(2, 2) = 1 - 0.5^2 + 2/2 = 1.75 at most. At least g(4, 2) = 1 - 0.5^4 + 2/4 =
    # 1.4375, T_max being 4; with a makespan of 3 slots half and half of both, 1.59375, is more than
    # g(3, 2) = 1 - 0.5^3 + 2/3 = 1.541667. All in units of the one rate there is.
    scenario = EVEN.changed(ema_beta=0.5, max_slots=4)
    rate_mbps = rate_range_mbps(scenario)[0]
    legs = Legs(np.array([[5.0]]), np.array([[2]]))
    assert reward_bounds(scenario, legs, rate_mbps, 4.0, rate_mbps) == pytest.approx((2.5 + 1.4375, 2.5 + 1.75))
    assert reward_bounds(scenario, legs, rate_mbps, 3.0, rate_mbps) == pytest.approx((2.5 + 1.541667, 2.5 + 1.75))


def test_bounds_by_hand_where_the_bias_correction_runs_to_the_deadline() -> None:
    # In units of the one rate R there is: with c(T) = 1 - 0.5^T and c(4) = 15/16, R-hat = c(T) / c(4) is 4/5 after 2
    # slots, 14/15 after 3 and 1 after 4. So its mean of 14/15 in 3 slots is 3 slots, or 1/3 and 2/3 of 2 and 4, which
    # take 10/3: too long. J = R-hat * (c(4) + 2/T) is 14/15 * (15/16 + 2/3) = 0.875 + 0.622222 alone.
    scenario = EVEN.changed(ema_beta=0.5, max_slots=4, bias_horizon="deadline")
    rate_mbps = rate_range_mbps(scenario)[0]
    legs = Legs(np.array([[5.0]]), np.array([[2]]))
    only = 2.5 + 0.875 + 0.622222
    assert reward_bounds(scenario, legs, rate_mbps * 14 / 15, 3.0, rate_mbps) == pytest.approx((only, only))
    # With 10/3 slots the mixture may be too: 1/3 * 4/5 * (15/16 + 1) + 2/3 * (15/16 + 1/2) = 1.475, which is less.
    other = 2.5 + 4 / 15 * 31 / 16 + 2 / 3 * 23 / 16
    assert reward_bounds(scenario, legs, rate_mbps * 14 / 15, 10 / 3, rate_mbps) == pytest.approx((other, only))
    with pytest.raises(ValueError, match="no method has a mean rate"):
        reward_bounds(scenario, legs, rate_mbps, 3.0, rate_mbps)  # it takes all 4


def test_large_rates_meet_long_missions_at_the_upper_bound_by_hand() -> None:
    # The mean rate lies in the middle of the range: one of two UAVs has the largest. g(1, 1) = 1 - 0.9 + 1 = 1.1 and
    # g(2, 2) = 1 - 0.81 + 1 = 1.19.
    low, high = rate_range_mbps(PAPER)
    long_and_short = np.array([[1, 2]])
    most = rate_terms_mbps(PAPER, long_and_short, (low + high) / 2, 100.0, largest=True)
    np.testing.assert_allclose(most, [[1.1 * low, 1.19 * high]])


def test_means_that_no_method_can_have_are_refused() -> None:
    legs = np.array([[4]])
    with pytest.raises(ValueError, match="mean rate of 100 Mbps"):
        rate_terms_mbps(PAPER, legs, 100.0, 10.0, largest=True)
    with pytest.raises(ValueError, match="makespan of 3 slots"):
        rate_terms_mbps(PAPER, legs, 30.0, 3.0, largest=True)


@given(ema_beta=BETAS, min_slots=st.integers(1, 40), detour=st.integers(0, 60))
def test_rate_counts_most_on_the_shortest_flight(ema_beta: float, min_slots: int, detour: int) -> None:
    least, slots = np.array([min_slots]), np.array([min_slots + detour])
    scenario = PAPER.changed(ema_beta=ema_beta)
    assert rate_weight(scenario, slots, least)[0] <= rate_weight(scenario, least, least)[0] + 1e-12


def test_every_rate_lies_within_the_range() -> None:
    low, high = rate_range_mbps(PAPER)
    rows = evaluate(RandomPlayer(), PAPER.changed(max_slots=1), 200, seed=4)  # R-hat after one slot is its rate
    assert low - 1e-9 <= rows["rate_mbps"].min() < rows["rate_mbps"].max() <= high + 1e-9


def test_legs_are_those_of_the_evaluation_with_the_same_seed() -> None:
    legs, rows = draw_legs(PAPER, 20, seed=4), evaluate(Wanderer(), PAPER, 20, seed=4)
    assert legs.min_slots.ravel().tolist() == rows["min_slots"].tolist()
    flown = reward_terms(Wanderer(), PAPER, 20, seed=4)["progress_voxels"]
    np.testing.assert_allclose(legs.distance_voxels.ravel(), flown)


@settings(max_examples=15)
@given(slots=st.integers(0, 30), ema_beta=BETAS, bias_horizon=HORIZONS)
def test_no_player_that_arrives_exceeds_the_ceiling_of_the_rate(slots: int, **constants: float | str) -> None:
    scenario = PAPER.changed(**constants)
    figures = summarize(evaluate(Wanderer(slots), scenario, 10, seed=4))
    assert figures["rate_mbps"] <= rate_ceiling_mbps(scenario, figures["makespan_slots"]) + 1e-9


def test_table_gives_weights_that_lead_to_the_paper() -> None:
    legs, terms = draw_legs(PAPER, 50, seed=4), reward_terms(RandomPlayer(), PAPER, 50, seed=4)
    means = {name: float(terms[name].mean()) for name in TERMS}
    row = bounds_table(legs, means).iloc[0]
    assert row["is_preset"]

    def at(nav_weight: float) -> tuple[float, float]:
        return reward_bounds(PAPER.changed(nav_weight=nav_weight), legs, 35.68, 8.75, row["rate_unit_mbps"])

    # 3.19, 35.68 Mbps and 8.7 slots, rounded: CTDE-MAPPO in tab:perf; a collision costs 1.
    assert at(row["nav_weight_from"])[1] == pytest.approx(3.19)
    assert at(row["nav_weight_to_without_collisions"])[0] == pytest.approx(3.19)
    assert at(row["nav_weight_to"])[0] - means["collisions"] == pytest.approx(3.19)
    # The fail_penalty beside it gives the -3.57 of Random.
    fail_penalty = row["fail_penalty_of_random"]
    rows = evaluate(RandomPlayer(), PAPER.changed(fail_penalty=fail_penalty), 50, seed=4)
    assert rows["reward"].mean() == pytest.approx(-3.57)


def test_table_tries_every_beta_with_the_unit_and_weight_of_the_preset() -> None:
    legs = draw_legs(PAPER, 50, seed=4)
    table = bounds_table(legs, dict(zip(TERMS, (1.0, 0.8, 0.77, 37.0), strict=True)))
    row = table[table["ema_beta"] == 0.5].iloc[0]
    expected = reward_bounds(PAPER.changed(ema_beta=0.5), legs, 35.68, 8.75, rate_unit_mbps(PAPER))
    assert (row["lower"], row["upper"]) == pytest.approx(expected)
    assert row["collisions_needed"] == pytest.approx(max(expected[0] - 3.19, 0.0))  # each costs 1


def test_verdicts_of_rate_units() -> None:
    table = bounds_table(draw_legs(PAPER, 200, seed=4), dict(zip(TERMS, (1.0, 0.8, 0.77, 37.0), strict=True)))
    # In Mbps the rates alone give more than 3.19 + 8.7 collisions: g is above 1/2 on average and R-hat is 35.68.
    assert (table.loc[table["rate_unit"] == "1 Mbps", "verdict"] == "ruled out").all()
    # Without reward for progress, 54.7 Mbps give at most 2 * 35.68 / 54.7 = 1.3.
    lone = table[(table["rate_unit"] == "lone UAV one voxel away") & (table["ema_beta"] == 0.1)]
    by_weight = lone.set_index("nav_weight").to_dict("index")
    assert by_weight[0.0]["verdict"] == "ruled out"
    # One for each of the 5.4 voxels on average needs more than 2 collisions a UAV.
    assert by_weight[1.0]["verdict"] == "disfavoured"
    assert by_weight[1.0]["collisions_needed"] > 2.0
