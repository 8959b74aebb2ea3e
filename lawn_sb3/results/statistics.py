"""Statistics over training seeds: values of a method and comparisons of two, each with a bootstrap interval.

Scores are a matrix [S, E]: S training seeds of one method, E test missions. Every method and seed flies the same
missions, so column m is the same mission everywhere. What is resampled are seeds, whole rows with all their missions:
the E scores of one seed come from one trained player, so they are no independent samples of the method, and an interval
that took them for such would show the spread of missions, not of trainings. The missions themselves are held fixed; the
intervals say how much another training would change, not other missions. :func:`crossed_t` alone counts both: what is
said of methods rests on it.

The intervals are percentile bootstraps, which are too narrow for few seeds: with five normally distributed seeds a
95 % interval holds the true mean in about five of six cases (a test measures it), and it never leaves the range of the
seeds. Read them as a spread, not as a test. From one seed no spread can be known: both bounds are then NaN.

Interquartile mean and probability of improvement are meant as in Agarwal et al., "Deep Reinforcement Learning at the
Edge of the Statistical Precipice" (2021).
"""

import warnings
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import bootstrap, trim_mean, ttest_ind, ttest_rel
from scipy.stats import t as student_t

from lawn_sb3.errors import UserError

LEVEL = 0.05
"""Chance that a test, or a family of tests together, finds a difference where none is."""
CONFIDENCE = 1.0 - LEVEL
"""Share of the resamples between the bounds of an interval, or of t intervals that hold the true value."""
RESAMPLES = 2_000
"""Bootstrap resamples of an interval."""
ROUNDING = 1e-8
"""Share of a score by which equal ones may differ: runs keep nine digits, of which the last may be off by one."""
TRIMMED_SHARE = 0.25
"""What an interquartile mean leaves out at each end."""
_BATCH = 100
"""Resamples computed together; bounds the memory of an interquartile mean, which copies every resampled score."""

_Statistic = Callable[..., NDArray[np.float64]]
"""From resampled seeds, one array of indices [..., S] per method, to values [...]."""


class Interval(NamedTuple):
    """A value and bounds around it, which say how far another draw of seeds may move it; NaN if unknown."""

    value: float
    low: float
    high: float

    def text(self, decimals: int = 2) -> str:
        """Write the interval for a table.

        :param decimals: digits after the point
        :return: such as ``3.43 [3.41, 3.45]``, the value alone if its bounds are unknown, a dash if it is
        """
        if np.isnan(self.value):
            return "–"
        value, low, high = (f"{number:z.{decimals}f}" for number in self)
        return f"{value} [{low}, {high}]" if self.is_known else value

    @property
    def is_known(self) -> bool:
        """Whether its bounds are."""
        return not np.isnan([self.low, self.high]).any()


UNKNOWN = Interval(float("nan"), float("nan"), float("nan"))


def mean_interval(by_seed: ArrayLike) -> Interval:
    """Mean over seeds.

    :param by_seed: one score per seed [S]
    :return: the mean in the unit of the scores; one seed gives NaN bounds
    :raises UserError: if there is no score, or one that is not finite
    """
    scores = _checked(by_seed, "by_seed", "[S]")
    return _interval(lambda drawn: np.mean(scores[drawn], axis=-1), [len(scores)])


def mean_t(by_seed: ArrayLike) -> Interval:
    """Mean over seeds with Student's t interval, which five seeds do not make too narrow.

    :param by_seed: one score per seed [S]
    :return: the mean in the unit of the scores; NaN bounds for one seed, equal bounds if all are equal but for
        ``ROUNDING``
    :raises UserError: if there is no score, or one that is not finite
    """
    return paired_t(by_seed, np.zeros(np.shape(by_seed)))


def interquartile_mean(scores: ArrayLike) -> Interval:
    """Mean of the middle half of all scores of all seeds: neither a few crashes nor a few strokes of luck move it.

    :param scores: scores of a method [S, E]
    :return: the interquartile mean in the unit of the scores; one seed gives NaN bounds
    :raises UserError: if there is no score, or one that is not finite
    """
    matrix = _checked(scores, "scores", "[S, E]")

    def middle(drawn: NDArray[np.int64]) -> NDArray[np.float64]:
        pooled = matrix[drawn].reshape(*drawn.shape[:-1], -1)  # [..., S * E]
        return np.asarray(trim_mean(pooled, TRIMMED_SHARE, axis=-1))

    return _interval(middle, [len(matrix)])


def paired_difference(scores: ArrayLike, other: ArrayLike) -> Interval:
    """Mean of score minus other over the same missions, so that what makes a mission hard for both cancels.

    :param scores: scores of a method [S1, E]
    :param other: scores of the method it is compared with, on the same missions [S2, E]
    :return: the difference in the unit of the scores; NaN bounds if either method has one seed
    :raises UserError: if the missions do not fit, there is no score, or one that is not finite
    """
    first, second = _checked_pair(scores, other)
    pairs = first.mean(axis=1)[:, None] - second.mean(axis=1)  # [S1, S2]
    return _over_pairs(pairs)


class Tested(NamedTuple):
    """A difference, and whether chance may have made it."""

    interval: Interval
    """The difference with its 95 % t interval."""
    p_value: float
    """The two-sided p-value; NaN where nothing was drawn that could have come out otherwise, and for one seed."""


def crossed_t(scores: ArrayLike, other: ArrayLike) -> Tested:
    """Mean of score minus other over the same missions, where other seeds and other missions would both change it.

    What verdicts on methods rest on. The variances of three means are added: over the seeds of either method, as in
    Welch's test, and over the missions, of the difference of what a mission gives with both, on average over seeds. The
    degrees of freedom are Satterthwaite's. What seeds and missions do together is in the last of these already, so that
    the interval is rather too wide.

    :param scores: scores of a method [S1, E]
    :param other: scores of the method it is compared with, on the same missions [S2, E]
    :return: the difference in the unit of the scores; a single mission is held fixed. NaN bounds if either method has
        one seed; equal bounds, and no p-value, where neither seeds nor missions differ by more than ``ROUNDING``
    :raises UserError: if the missions do not fit, there is no score, or one that is not finite
    """
    first, second = _checked_pair(scores, other)
    value, rounding = float(first.mean() - second.mean()), _rounding(first.ravel(), second.ravel())
    drawn = [first.mean(axis=1), second.mean(axis=1)]
    if min(map(len, drawn)) < 2:
        return Tested(Interval(value, float("nan"), float("nan")), float("nan"))
    missions = first.mean(axis=0) - second.mean(axis=0)
    drawn = [sample for sample in (*drawn, missions) if np.ptp(sample) > rounding]
    if not drawn:
        value = value if abs(value) > rounding else 0.0
        return Tested(Interval(value, value, value), float("nan"))
    variances = np.array([sample.var(ddof=1) / len(sample) for sample in drawn])
    error = float(np.sqrt(variances.sum()))
    freedoms = np.array([len(sample) - 1.0 for sample in drawn])
    freedom = float(variances.sum() ** 2 / (variances**2 / freedoms).sum())
    half = float(student_t.ppf((1.0 + CONFIDENCE) / 2.0, freedom)) * error
    return Tested(Interval(value, value - half, value + half), float(2.0 * student_t.sf(abs(value) / error, freedom)))


def welch_difference(by_seed: ArrayLike, other: ArrayLike) -> Interval:
    """Difference of two means over seeds with Welch's t interval, which five seeds do not make too narrow.

    For figures that are none of single missions, such as those of a learning curve. It takes seeds for draws of a
    normal distribution, each method with a spread of its own.

    :param by_seed: one score per seed [S1]
    :param other: the same of another method [S2]
    :return: the difference; NaN bounds if either method has one seed, equal bounds if neither has any spread beyond
        ``ROUNDING``
    :raises UserError: if there is no score, or one that is not finite
    """
    return _welch(by_seed, other).interval()


def welch_p(by_seed: ArrayLike, other: ArrayLike) -> float:
    """The two-sided p-value of Welch's test, below 0.05 where the interval of :func:`welch_difference` leaves 0 out.

    :param by_seed: one score per seed [S1]
    :param other: the same of another method [S2]
    :return: the p-value; NaN where no seed differs from another of its method by more than ``ROUNDING``, so that chance
        has no part in it, and for one seed
    :raises UserError: if there is no score, or one that is not finite
    """
    return _welch(by_seed, other).p_value()


def paired_p(by_seed: ArrayLike, other: ArrayLike) -> float:
    """The two-sided p-value of Student's paired test, below 0.05 where the interval of :func:`paired_t` leaves 0 out.

    :param by_seed: one score per seed [S]
    :param other: the same of the other method, in the same order of seeds [S]
    :return: the p-value; NaN where all differences are equal but for ``ROUNDING``, and for one seed
    :raises UserError: if the numbers of seeds differ, there is no score, or one that is not finite
    """
    return _paired(by_seed, other).p_value()


def holm(p_values: Sequence[float], level: float = LEVEL) -> float:
    """The largest p-value that Holm's procedure rejects: of a family of tests, all up to it are significant together.

    The smallest of m p-values has to be at most level / m, the next at most level / (m - 1) and so on, up to the first
    that is not. The chance that any true hypothesis of the family is rejected is then at most the level, whatever the
    tests have to do with each other: Holm, "A Simple Sequentially Rejective Multiple Test Procedure" (1979).

    :param p_values: those of the family [m]; NaN is no test, and not counted
    :param level: chance of one false rejection or more
    :return: the largest rejected one; 0 if none is
    """
    ordered = np.sort([p for p in p_values if not np.isnan(p)])
    passed = ordered <= level / np.arange(len(ordered), 0, -1)
    count = int(np.logical_and.accumulate(passed).sum())
    return float(ordered[count - 1]) if count else 0.0


def paired_t(by_seed: ArrayLike, other: ArrayLike) -> Interval:
    """Mean difference seed by seed with Student's t interval over the S differences; effects of ablations rest on it.

    Seed k of one method is held against seed k of the other. What both have in common, the test missions and what a
    seed settles alike for both, cancels in each difference, and the interval says how much the differences spread.
    It is Student's t and not the percentile bootstrap, because the bootstrap of five seeds holds the true mean in
    about five of six cases only (a test measures it): one effect in six would seem to be there without being so. For
    five seeds t is 1.6 times as wide, and holds the true mean in 95 of 100 cases if differences are normal.

    :param by_seed: one score per seed [S]
    :param other: the same of the other method, in the same order of seeds, on the same missions [S]
    :return: the difference in the unit of the scores; NaN bounds for one seed, equal bounds if all differences are
        equal but for ``ROUNDING``
    :raises UserError: if the numbers of seeds differ, there is no score, or one that is not finite
    """
    return _paired(by_seed, other).interval()


def probability_of_improvement(scores: ArrayLike, other: ArrayLike) -> Interval:
    """P(X > Y) + P(X = Y) / 2: how often a seed of one beats a seed of the other on the same mission.

    :param scores: scores X of a method, greater is better [S1, E]
    :param other: scores Y of the method it is compared with, on the same missions [S2, E]
    :return: the probability, 1/2 for equal methods; NaN bounds if either method has one seed
    :raises UserError: if the missions do not fit, there is no score, or one that is not finite
    """
    first, second = _checked_pair(scores, other)
    wins = np.heaviside(first[:, None] - second, 0.5)  # [S1, S2, E]
    return _over_pairs(wins.mean(axis=-1))


class _Comparison(NamedTuple):
    """Two methods that a t test of SciPy holds against each other."""

    value: float
    """The mean difference."""
    samples: tuple[NDArray[np.float64], ...]
    """The figures whose spread is chance."""
    rounding: float
    """What rounding may add to any of them."""
    test: Callable[[], Any]

    @property
    def has_one_seed(self) -> bool:
        """Whether a spread cannot be known."""
        return min(map(len, self.samples)) < 2

    @property
    def has_spread(self) -> bool:
        """Whether seeds differ by more than rounding."""
        return any(np.ptp(sample) > self.rounding for sample in self.samples)

    def interval(self) -> Interval:
        """The difference with its t interval; its width is 0 without spread, and so is then what rounding left."""
        if self.has_one_seed:
            return Interval(self.value, float("nan"), float("nan"))
        if not self.has_spread:
            value = self.value if abs(self.value) > self.rounding else 0.0
            return Interval(value, value, value)
        bounds = self._tested().confidence_interval(CONFIDENCE)
        return Interval(self.value, min(float(bounds.low), self.value), max(float(bounds.high), self.value))

    def p_value(self) -> float:
        """The two-sided p-value; NaN for one seed, and without spread."""
        return float("nan") if self.has_one_seed or not self.has_spread else float(self._tested().pvalue)

    def _tested(self) -> Any:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Precision loss")  # one of the methods may have no spread
            return self.test()


def _welch(by_seed: ArrayLike, other: ArrayLike) -> _Comparison:
    """Two means over seeds that are no pairs."""
    first, second = _checked(by_seed, "by_seed", "[S]"), _checked(other, "other", "[S]")
    value, test = float(first.mean() - second.mean()), partial(ttest_ind, first, second, equal_var=False)
    return _Comparison(value, (first, second), _rounding(first, second), test)


def _paired(by_seed: ArrayLike, other: ArrayLike) -> _Comparison:
    """Differences seed by seed."""
    first, second = _checked(by_seed, "by_seed", "[S]"), _checked(other, "other", "[S]")
    if len(first) != len(second):
        raise UserError(f"by_seed has {len(first)} seeds, other {len(second)}: seeds in pairs need as many of both")
    differences, test = first - second, partial(ttest_rel, first, second)
    return _Comparison(float(differences.mean()), (differences,), _rounding(first, second), test)


def _rounding(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    return ROUNDING * float(max(np.abs(first).max(), np.abs(second).max()))


def _over_pairs(pairs: NDArray[np.float64]) -> Interval:
    """Mean over all pairs of seeds [S1, S2], the seeds of the two methods resampled independently."""

    def mean(first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.float64]:
        return np.asarray(pairs[first[..., :, None], second[..., None, :]].mean(axis=(-2, -1)))

    return _interval(mean, pairs.shape)


def _interval(statistic: _Statistic, num_seeds: Sequence[int]) -> Interval:
    """Value of a statistic over all seeds, and its percentile bootstrap over resampled seeds."""
    seeds = [np.arange(count) for count in num_seeds]
    value = float(statistic(*seeds))
    if min(num_seeds) < 2:
        return Interval(value, float("nan"), float("nan"))
    bounds = bootstrap(
        seeds,
        lambda *drawn, axis: statistic(*drawn),
        n_resamples=RESAMPLES,
        batch=_BATCH,
        vectorized=True,
        axis=-1,
        confidence_level=CONFIDENCE,
        method="percentile",
        rng=0,  # equal input gives equal bounds
    ).confidence_interval
    # Rounding can put a bound of equal seeds a hair beyond the value, and error bars must not be negative.
    return Interval(value, min(float(bounds.low), value), max(float(bounds.high), value))


def _checked_pair(scores: ArrayLike, other: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    first, second = _checked(scores, "scores", "[S, E]"), _checked(other, "other", "[S, E]")
    if first.shape[1] != second.shape[1]:
        raise UserError(f"scores on {first.shape[1]} missions, other on {second.shape[1]}: both need the same missions")
    return first, second


def _checked(values: ArrayLike, name: str, shape: str) -> NDArray[np.float64]:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != shape.count(",") + 1 or array.size == 0:
        raise UserError(f"{name} has shape {array.shape}: must be {shape}, with at least one score")
    if not np.isfinite(array).all():
        where = np.argwhere(~np.isfinite(array))[0].tolist()
        raise UserError(f"{name}{where} is {array[tuple(where)]}: every score must be a finite number")
    return array
