"""Statistics over seeds: figures on paper, and laws of every comparison."""

import warnings
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from lawn_sb3.errors import UserError
from lawn_sb3.results.statistics import (
    UNKNOWN,
    Interval,
    interquartile_mean,
    mean_interval,
    mean_t,
    paired_difference,
    paired_p,
    paired_t,
    probability_of_improvement,
    welch_difference,
    welch_p,
)

Matrix = NDArray[np.float64]
COMPARISONS = [paired_difference, probability_of_improvement]
MOST_SEEDS = 3
FEW = settings(max_examples=50)


def matrices(missions: int, fewest_seeds: int = 1) -> st.SearchStrategy[Matrix]:
    # Quarters, so that ties are common and sums exact enough to compare.
    numbers = st.integers(-400, 400).map(lambda number: number / 4)
    return st.integers(fewest_seeds, MOST_SEEDS).flatmap(
        lambda seeds: arrays(np.float64, (seeds, missions), elements=numbers)
    )


def pairs(fewest_seeds: int = 1) -> st.SearchStrategy[tuple[Matrix, Matrix]]:
    return st.integers(1, 6).flatmap(
        lambda missions: st.tuples(matrices(missions, fewest_seeds), matrices(missions, fewest_seeds))
    )


def assert_holds_its_value(interval: Interval) -> None:
    assert interval.low <= interval.value <= interval.high


@pytest.mark.parametrize(
    ("interval", "decimals", "text"),
    [
        (Interval(3.4349, 3.41, 3.4501), 2, "3.43 [3.41, 3.45]"),
        (Interval(-0.004, -0.2, 0.1), 1, "0.0 [-0.2, 0.1]"),  # no negative zero
        (Interval(3.434, float("nan"), float("nan")), 1, "3.4"),
        (UNKNOWN, 1, "–"),
    ],
)
def test_an_interval_is_written_with_the_bounds_that_are_known(interval: Interval, decimals: int, text: str) -> None:
    assert interval.text(decimals) == text


def test_bounds_are_percentiles_of_the_resampled_mean() -> None:
    # Resampling {0, 1} gives the mean 0, 1/2, 1 with probability 1/4, 1/2, 1/4:
    # the 2.5th percentile is 0, the 97.5th is 1.
    assert mean_interval([0.0, 1.0]) == (0.5, 0.0, 1.0)


def test_one_seed_has_unknown_bounds_and_warns_of_nothing() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        alone = [
            mean_interval([2.0]),
            interquartile_mean([[1.0, 3.0]]),
            paired_difference([[4.0]], [[1.0], [3.0]]),
            probability_of_improvement([[2.0], [2.0]], [[2.0]]),
            paired_t([3.0], [1.0]),
            welch_difference([2.0], [1.0, 1.0]),
        ]
    assert [interval.value for interval in alone] == [2.0, 2.0, 2.0, 0.5, 2.0, 1.0]
    assert np.isnan([interval[1:] for interval in alone]).all()


@given(score=st.floats(-1e6, 1e6), seeds=st.integers(2, 9))
@example(score=880.1, seeds=5)  # the percentile is rounded up, past the mean
@example(score=177.23, seeds=5)  # and down
@FEW
def test_equal_seeds_give_an_interval_without_width(score: float, seeds: int) -> None:
    interval = mean_interval(np.full(seeds, score))
    assert interval == pytest.approx((score, score, score), rel=1e-12)
    assert_holds_its_value(interval)


@given(scores=st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=9), shift=st.floats(-1e3, 1e3))
@FEW
def test_a_shift_of_all_scores_shifts_the_mean_and_its_bounds(scores: list[float], shift: float) -> None:
    before, after = mean_interval(scores), mean_interval(np.array(scores) + shift)
    assert after == pytest.approx(tuple(bound + shift for bound in before), abs=1e-9)
    assert_holds_its_value(before)


def test_equal_input_gives_equal_bounds() -> None:
    scores = np.random.default_rng(0).normal(size=9)
    assert mean_interval(scores) == mean_interval(scores)


def test_five_seeds_cover_the_true_mean_less_often_than_the_interval_says() -> None:
    # A resampled mean of 5 has the variance (4/5) s^2 / 5, so the bounds lie near 1.96 * sqrt(4/5) = 1.75 standard
    # errors; Student's t with 4 degrees of freedom stays within 1.75 in 85 % of the cases, not in 95 %.
    rng = np.random.default_rng(0)
    intervals = [mean_interval(rng.normal(size=5)) for _ in range(500)]
    covered = np.mean([interval.low <= 0.0 <= interval.high for interval in intervals])
    assert 0.78 < covered < 0.90


def test_interquartile_mean_is_the_mean_of_the_middle_half_of_all_scores() -> None:
    # Eight scores: -100, 0 and 7, 999 go; (1 + 2 + 4 + 5) / 4 = 3
    assert interquartile_mean([[999.0, 1.0, 2.0, 0.0], [4.0, 5.0, 7.0, -100.0]]).value == 3.0


def test_interquartile_mean_resamples_seeds() -> None:
    # Resampled scores are all 0, half 0 and half 1, or all 1, with probability 1/4, 1/2, 1/4.
    assert interquartile_mean([[0.0] * 4, [1.0] * 4]) == (0.5, 0.0, 1.0)


def test_interquartile_mean_keeps_the_missions_of_a_seed_together() -> None:
    # Whatever whole rows are drawn, half of the scores are 0 and half 4; of single scores all four could be 0.
    assert interquartile_mean([[0.0, 4.0], [4.0, 0.0]]) == (2.0, 2.0, 2.0)


@given(scores=st.integers(1, 6).flatmap(lambda missions: matrices(missions, fewest_seeds=2)))
@FEW
def test_interquartile_mean_lies_in_its_interval(scores: Matrix) -> None:
    assert_holds_its_value(interquartile_mean(scores))


def test_difference_is_the_mean_over_seeds_and_missions() -> None:
    # Means of the seeds 3 and 3.5 against 3.5 and 2.5: 3.25 - 3 = 0.25. Resampled it lies between 3 - 3.5 = -0.5 and
    # 3.5 - 2.5 = 1, each with probability 1/4 * 1/4 = 6 %, more than the 2.5 % outside of a bound.
    assert paired_difference([[1.0, 5.0], [2.0, 5.0]], [[1.0, 6.0], [0.0, 5.0]]) == (0.25, -0.5, 1.0)


def test_what_makes_a_mission_hard_for_both_cancels() -> None:
    hardness = np.array([-50.0, 0.0, 80.0])
    assert paired_difference(np.tile(hardness + 1.0, (3, 1)), np.tile(hardness, (2, 1))) == (1.0, 1.0, 1.0)


def test_seeds_of_two_methods_are_resampled_independently() -> None:
    # Drawn together the difference would always be 0; apart it is -1 and 1 with probability 1/16 each.
    assert paired_difference([[0.0], [1.0]], [[0.0], [1.0]]) == (0.0, -1.0, 1.0)


@given(pair=pairs())
@FEW
def test_difference_changes_sign_with_the_order(pair: tuple[Matrix, Matrix]) -> None:
    scores, other = pair
    assert paired_difference(scores, other).value == pytest.approx(-paired_difference(other, scores).value, abs=1e-9)


def test_probability_of_improvement_counts_wins_and_half_the_ties_mission_by_mission() -> None:
    # Mission 0: 1=1, 1>0, 2>1, 2>0: 3.5 of 4. Mission 1: 5<6, 5=5, 5<6, 5=5: 1 of 4. (7/8 + 1/4) / 2 = 9/16.
    # Pairs of seeds: 1/4, 3/4 in the first row and 1/2, 3/4 in the second. The least, 1/4, is drawn alone with
    # probability 1/16; so is 3/4, more often.
    assert probability_of_improvement([[1.0, 5.0], [2.0, 5.0]], [[1.0, 6.0], [0.0, 5.0]]) == (0.5625, 0.25, 0.75)


def test_probability_of_improvement_never_compares_different_missions() -> None:
    # Better on each mission, though 0 on one is worse than 9 on the other.
    assert probability_of_improvement([[0.0, 10.0]], [[-1.0, 9.0]]).value == 1.0


@given(pair=pairs())
@FEW
def test_probabilities_of_improvement_of_both_sides_add_up_to_one(pair: tuple[Matrix, Matrix]) -> None:
    scores, other = pair
    there, back = probability_of_improvement(scores, other).value, probability_of_improvement(other, scores).value
    assert 0.0 <= there <= 1.0
    assert there + back == pytest.approx(1.0)


@pytest.mark.parametrize("compare", COMPARISONS)
@given(pair=pairs(fewest_seeds=2))
@FEW
def test_comparison_lies_in_its_interval(compare: Callable[..., Interval], pair: tuple[Matrix, Matrix]) -> None:
    assert_holds_its_value(compare(*pair))


@pytest.mark.parametrize("compare", COMPARISONS)
@given(pair=pairs(), data=st.data())
@FEW
def test_order_of_missions_and_seeds_changes_no_comparison(
    compare: Callable[..., Interval], pair: tuple[Matrix, Matrix], data: st.DataObject
) -> None:
    scores, other = pair
    missions = data.draw(st.permutations(range(scores.shape[1])))
    seeds = data.draw(st.permutations(range(len(scores))))
    moved = compare(scores[:, missions], other[:, missions])
    assert moved == pytest.approx(tuple(compare(scores, other)), abs=1e-9, nan_ok=True)
    assert compare(scores[seeds], other).value == pytest.approx(compare(scores, other).value, abs=1e-9)


@given(scores=matrices(missions=5), data=st.data())
@FEW
def test_order_of_missions_and_seeds_changes_no_interquartile_mean(scores: Matrix, data: st.DataObject) -> None:
    missions = data.draw(st.permutations(range(5)))
    seeds = data.draw(st.permutations(range(len(scores))))
    moved = interquartile_mean(scores[:, missions])
    assert moved == pytest.approx(tuple(interquartile_mean(scores)), abs=1e-9, nan_ok=True)
    assert interquartile_mean(scores[seeds]).value == pytest.approx(interquartile_mean(scores).value, abs=1e-9)


@pytest.mark.parametrize("compare", COMPARISONS)
def test_different_missions_are_refused(compare: Callable[..., Interval]) -> None:
    with pytest.raises(UserError, match="scores on 2 missions, other on 3"):
        compare(np.ones((2, 2)), np.ones((2, 3)))


@pytest.mark.parametrize("compare", COMPARISONS)
@pytest.mark.parametrize("wrong", [np.ones(3), np.ones((0, 3)), np.ones((3, 0))], ids=["vector", "seeds", "missions"])
def test_scores_that_are_no_filled_matrix_are_refused(compare: Callable[..., Interval], wrong: Matrix) -> None:
    with pytest.raises(UserError, match=r"other has shape .*: must be \[S, E\]"):
        compare(np.ones((2, 3)), wrong)
    with pytest.raises(UserError, match=r"scores has shape .*: must be \[S, E\]"):
        interquartile_mean(wrong)


@pytest.mark.parametrize("wrong", [np.ones(0), np.ones((2, 2))], ids=["none", "matrix"])
def test_no_seeds_or_a_matrix_of_them_are_refused_by_name(wrong: Matrix) -> None:
    with pytest.raises(UserError, match=r"^by_seed has shape .*: must be \[S\], with at least one score$"):
        mean_interval(wrong)
    for compare in (welch_difference, welch_p, paired_t, paired_p):
        for name, values in (("by_seed", (wrong, np.ones(2))), ("other", (np.ones(2), wrong))):
            with pytest.raises(UserError, match=rf"^{name} has shape .*: must be \[S\], with at least one score$"):
                compare(*values)


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_scores_that_are_no_finite_numbers_are_refused(bad: float) -> None:
    with pytest.raises(UserError, match=rf"^by_seed\[1\] is {bad}: every score must be a finite number$"):
        mean_interval([1.0, bad])
    with pytest.raises(UserError, match=rf"^other\[0, 1\] is {bad}: every score"):
        paired_difference([[1.0, 1.0]], [[1.0, bad]])
    for compare in (welch_difference, welch_p, paired_t, paired_p):
        with pytest.raises(UserError, match=rf"^other\[2\] is {bad}: every score"):
            compare([1.0, 2.0, 3.0], [1.0, 2.0, bad])


def test_welch_interval_by_hand() -> None:
    # Means 2 and 0; variances 1 and 1 over three seeds each: standard error sqrt(1/3 + 1/3) = 0.8165, 4 degrees of
    # freedom, whose 97.5 % quantile of t is 2.7764: 2 -+ 2.267.
    found = welch_difference([1.0, 2.0, 3.0], [-1.0, 0.0, 1.0])
    assert found == pytest.approx((2.0, -0.267, 4.267), abs=1e-3)


def test_welch_interval_without_spread() -> None:
    assert welch_difference([2.0, 2.0], [1.0, 1.0, 1.0]) == (1.0, 1.0, 1.0)


def test_welch_intervals_hold_the_true_difference_as_often_as_they_say() -> None:
    rng = np.random.default_rng(0)
    pairs = rng.normal(size=(1_000, 2, 5))
    held = [welch_difference(first, second) for first, second in pairs]
    # 950 of 1,000 expected, standard deviation 7.
    assert 0.925 < np.mean([found.low <= 0.0 <= found.high for found in held]) < 0.985


def test_t_interval_of_a_mean_by_hand() -> None:
    # Standard error 1 with 1 degree of freedom: 12.706 to both sides.
    assert mean_t([1.0, 3.0]) == pytest.approx((2.0, -10.706, 14.706), abs=1e-3)
    assert mean_t([2.5, 2.5]) == (2.5, 2.5, 2.5)
    assert not mean_t([2.0]).is_known


def test_paired_t_interval_by_hand() -> None:
    # Differences 1, 2, 3: mean 2, standard error 1 / sqrt(3) = 0.5774, 2 degrees of freedom, whose 97.5 % quantile of t
    # is 4.3027: 2 -+ 2.4842.
    found = paired_t([11.0, 22.0, 33.0], [10.0, 20.0, 30.0])
    assert found == pytest.approx((2.0, -0.4842, 4.4842), abs=1e-4)


def test_what_a_seed_does_to_both_cancels() -> None:
    assert paired_t([100.5, -3.5, 7.5], [100.0, -4.0, 7.0]) == (0.5, 0.5, 0.5)


@given(pairs=st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=2, max_size=9), data=st.data())
@FEW
def test_paired_t_changes_sign_with_the_order_of_methods_and_not_with_that_of_seeds(
    pairs: list[tuple[float, float]], data: st.DataObject
) -> None:
    first, second = np.array(pairs).T
    found = paired_t(first, second)
    assert_holds_its_value(found)
    back = paired_t(second, first)
    assert (-back.value, -back.high, -back.low) == pytest.approx(tuple(found), abs=1e-9)
    seeds = data.draw(st.permutations(range(len(first))))
    assert paired_t(first[seeds], second[seeds]) == pytest.approx(tuple(found), abs=1e-9)


def test_paired_t_intervals_hold_the_true_difference_as_often_as_they_say() -> None:
    # What a seed does to both has ten times the spread of what it does to one of them.
    rng = np.random.default_rng(0)
    shared, own, other = 10.0 * rng.normal(size=(1_000, 5)), rng.normal(size=(1_000, 5)), rng.normal(size=(1_000, 5))
    held = [paired_t(*seeds) for seeds in zip(shared + own + 1.0, shared + other, strict=True)]
    # 950 of 1,000 expected, standard deviation 7.
    assert 0.925 < np.mean([found.low <= 1.0 <= found.high for found in held]) < 0.975


def test_seeds_that_cannot_be_paired_are_refused() -> None:
    for compare in (paired_t, paired_p):
        for one, other in ((2, 3), (1, 3)):
            with pytest.raises(UserError, match=f"by_seed has {one} seeds, other {other}"):
                compare(np.arange(one), np.arange(other))
