"""Which differences count: p-values, and Holm's procedure over a family of tests."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import t as student_t

from lawn_sb3.results.statistics import crossed_t, holm, paired_p, paired_t, welch_difference, welch_p


def test_holm_by_hand() -> None:
    # Of four: 0.01 <= 0.05 / 4, 0.015 <= 0.05 / 3, 0.03 > 0.05 / 2; then it stops, though 0.04 <= 0.05 / 1.
    assert holm([0.04, 0.01, 0.03, 0.015]) == 0.015
    assert holm([0.04, 0.01, float("nan"), 0.03, 0.015]) == 0.015  # no test, and not counted
    assert holm([0.02, 0.04, 0.04]) == 0.0  # 0.02 > 0.05 / 3
    assert holm([]) == 0.0
    assert holm([0.04], level=0.01) == 0.0


P_VALUES = st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20)


@given(p_values=P_VALUES, more=P_VALUES)
def test_holm_rejects_no_less_than_bonferroni_and_the_less_the_more_is_tested(
    p_values: list[float], more: list[float]
) -> None:
    largest = holm(p_values)
    assert all(p <= largest for p in p_values if p <= 0.05 / len(p_values))
    assert largest <= 0.05
    assert holm(p_values[::-1]) == largest
    # Tests of which nothing comes only raise the bar.
    assert holm([*p_values, *[1.0] * len(more)]) <= largest
    assert holm([p / 2.0 for p in p_values]) >= largest / 2.0


@given(
    first=st.lists(st.floats(-10, 10), min_size=2, max_size=6),
    second=st.lists(st.floats(-10, 10), min_size=2, max_size=6),
)
def test_a_p_value_is_below_five_percent_where_the_interval_leaves_0_out(
    first: list[float], second: list[float]
) -> None:
    pairs = (first[: len(second)], second[: len(first)])
    for found, p_value in (
        (welch_difference(first, second), welch_p(first, second)),
        (paired_t(*pairs), paired_p(*pairs)),
    ):
        if np.isnan(p_value):
            assert found.low == found.high
        elif abs(p_value - 0.05) > 1e-6:
            assert (p_value < 0.05) == (found.low > 0.0 or found.high < 0.0)


def test_p_values_by_hand() -> None:
    # Differences 1, 2, 3: t = 2 sqrt(3) = 3.464 with 2 degrees of freedom, p = 1 - t / sqrt(2 + t^2).
    expected = 1.0 - math.sqrt(12.0 / 14.0)
    assert paired_p([2.0, 4.0, 6.0], [1.0, 2.0, 3.0]) == pytest.approx(expected)
    assert welch_p([1.0, 2.0, 3.0], [0.0, 0.0, 0.0]) == pytest.approx(expected)
    assert np.isnan([welch_p([1.0, 1.0], [0.0, 0.0]), paired_p([2.0, 1.0], [1.0, 0.0]), paired_p([1.0], [0.0])]).all()


@given(digits=st.integers(10**8, 10**9 - 1), exponent=st.integers(-12, 12), sign=st.sampled_from([-1.0, 1.0]))
def test_seeds_that_differ_by_the_last_digit_that_runs_keep_do_not_differ(
    digits: int, exponent: int, sign: float
) -> None:
    one, next_to_it = (sign * float(f"{number}e{exponent}") for number in (digits, digits + 1))
    for found, p_value in (
        (welch_difference([one, next_to_it], [one, one]), welch_p([one, next_to_it], [one, one])),
        (paired_t([one, next_to_it], [one, one]), paired_p([one, next_to_it], [one, one])),
    ):
        assert found == (0.0, 0.0, 0.0)
        assert np.isnan(p_value)


def test_seeds_that_differ_by_more_do() -> None:
    # Off by 2 in the last of nine digits: mean difference 1e-8, variance 2e-16 over two seeds, so t = 1 with 1 degree
    # of freedom, whose p-value is 1/2.
    for p_value in (welch_p, paired_p):
        assert p_value([1.00000002, 1.0], [1.0, 1.0]) == pytest.approx(0.5, rel=1e-6)


def test_what_rounding_leaves_of_equal_differences_is_no_effect() -> None:
    assert paired_t([0.1 + 0.2, 0.7], [0.3, 0.1 + 0.6]) == (0.0, 0.0, 0.0)
    assert np.isnan(paired_p([0.3, 0.4], [0.1, 0.2]))  # 0.2 both, but for the last bit


def test_a_difference_over_seeds_and_missions_by_hand() -> None:
    # By seed 1 and 3 against 0 and 0: variance of the mean 2 / 2 = 1. By mission 1.5 and 2.5: 0.5 / 2 = 0.25. Together
    # 1.25, with 1.25^2 / (1 / 1 + 0.0625 / 1) = 1.47059 degrees of freedom.
    found = crossed_t([[0.5, 1.5], [2.5, 3.5]], [[0.0, 0.0], [0.0, 0.0]])
    error, freedom = math.sqrt(1.25), 1.5625 / 1.0625
    half = student_t.ppf(0.975, freedom) * error
    assert found.interval == pytest.approx((2.0, 2.0 - half, 2.0 + half))
    assert found.p_value == pytest.approx(2.0 * student_t.sf(2.0 / error, freedom))


def test_without_spread_over_missions_it_is_welchs_test_and_without_any_there_is_none() -> None:
    by_seed, others = [1.0, 2.0, 4.0], [0.0, 1.0]
    for num_missions in (1, 5):  # that all give the same; a single one is held fixed
        found = crossed_t(*(np.repeat(np.array(own)[:, None], num_missions, axis=1) for own in (by_seed, others)))
        assert found.interval == pytest.approx(welch_difference(by_seed, others))
        assert found.p_value == pytest.approx(welch_p(by_seed, others))
    level = crossed_t([[1.0, 2.0], [1.0, 2.0]], [[0.0, 1.0], [0.0, 1.0]])
    assert level.interval == (1.0, 1.0, 1.0)
    assert np.isnan(level.p_value)
    assert not crossed_t([[1.0, 2.0]], [[0.0, 1.0], [0.0, 1.0]]).interval.is_known  # one seed


def test_of_methods_that_are_alike_at_most_one_in_twenty_differs_whatever_seeds_and_missions_were_drawn() -> None:
    rng, rejected, rounds = np.random.default_rng(0), 0, 2_000
    for _ in range(rounds):
        seeds, missions = rng.normal(0.0, 0.3, (2, 5, 1)), rng.normal(0.0, 1.0, (2, 1, 40))
        first, second = seeds + missions + rng.normal(0.0, 1.0, (2, 5, 40))
        rejected += crossed_t(first, second).p_value < 0.05
    assert rejected / rounds < 0.06
