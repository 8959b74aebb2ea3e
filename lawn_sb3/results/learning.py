"""How methods learn: smoothed curves, when greedy success is first high, and how much there is on average."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pandas as pd

from lawn_sb3.results.pairing import Pair, pair_up
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import UNKNOWN, Interval, paired_p, paired_t

WINDOW = 30
"""Points a smoothed curve averages over, as in the paper."""
GREEDY = "greedy/success_percent"
THRESHOLD = 95.0
"""Success in percent that the paper's Fig. 2 is said to reach and to keep."""


class Crossing(NamedTuple):
    """When greedy success is first high."""

    env_steps: float
    """Median of the seeds; infinite if half of them never get there, NaN if it was not measured."""
    by_seed: tuple[float, ...]
    """Of each seed, fastest first; infinite if it never gets there."""
    first: float
    """The first evaluation there is."""
    budget: int

    @property
    def if_reached(self) -> float:
        """The median; NaN where half of the seeds never get there, as machines read no infinity."""
        return self.env_steps if np.isfinite(self.env_steps) else np.nan

    def text(self) -> str:
        """The median for a table, such as ``26,624``, ``at most 2,048`` or ``> 150,000``."""
        return "–" if np.isnan(self.env_steps) else self._text(self.env_steps)

    def text_with_range(self) -> str:
        """The median with the fastest and the slowest seed, such as ``26,624 [20,480 to > 150,000]``."""
        if len(self.by_seed) < 2:
            return self.text()
        return f"{self.text()} [{self._text(self.by_seed[0])} to {self._text(self.by_seed[-1])}]"

    def _text(self, value: float) -> str:
        if np.isinf(value):
            return f"> {self.budget:,}"
        return f"{'at most ' if value <= self.first else ''}{value:,.0f}"


def smoothed(curves: pd.DataFrame, column: str, window: int) -> pd.DataFrame:
    """Rolling mean of a curve, seed by seed.

    :param curves: rows of ``progress.csv`` with the columns ``method`` and ``seed``
    :param column: what to smooth; rows without it are left out
    :param window: points to average over, fewer at the start
    :return: the columns ``method, seed, env_steps, value``
    """
    rows = curves.dropna(subset=[column])
    value = rows.groupby(["method", "seed"])[column].transform(lambda own: own.rolling(window, min_periods=1).mean())
    return rows[["method", "seed"]].assign(env_steps=rows["time/env_steps"], value=value)


def side_by_side(curves: pd.DataFrame, column: str = "time/env_steps") -> pd.DataFrame:
    """Curves in which the k-th point of all seeds of a method lies at one place, the mean of theirs.

    A batch of whole games ends at other env steps in every seed.

    :param curves: rows with the columns ``method`` and ``seed``
    :param column: where a point lies
    :return: the same with that place in the column ``env_steps``
    """
    nth = curves.groupby(["method", "seed"]).cumcount()
    return curves.assign(env_steps=curves[column].groupby([curves["method"], nth]).transform("mean"))


def greedy_curves(results: Results, method: str, seeds: Iterable[int]) -> dict[int, pd.Series]:
    """The greedy success of a method in training, by seed: percent by env steps, of those seeds that were watched."""
    curves = results.curves
    if not len(curves) or GREEDY not in curves:
        return {}
    own = curves[curves["method"] == method].dropna(subset=[GREEDY]).set_index("time/env_steps")
    found = {seed: own.loc[own["seed"] == seed, GREEDY] for seed in seeds}
    return {seed: curve for seed, curve in found.items() if len(curve)}


def has_curves(results: Results) -> bool:
    """Whether any ablation was watched together with its default."""
    return any(watched(results, pair) for pairs in pair_up(results).values() for pair in pairs)


def median_crossing(results: Results, method: str, seeds: Iterable[int]) -> Crossing:
    """When the greedy success of a method is first at 95 %, of some of its seeds."""
    budget = results.recipe.methods[method].env_steps
    curves = greedy_curves(results, method, seeds).values()
    if not curves:
        return Crossing(np.nan, (), np.nan, budget)
    found = sorted(float(min(own.index[own >= THRESHOLD], default=np.inf)) for own in curves)
    half = len(found) // 2
    # Not np.median, which makes NaN of two infinite values in the middle.
    middle = found[half] if len(found) % 2 or np.isinf(found[half]) else (found[half - 1] + found[half]) / 2
    return Crossing(middle, tuple(found), float(max(own.index[0] for own in curves)), budget)


def mean_success(curve: pd.Series, begin: float, end: float) -> float:
    """Success on average over a part of the training: the area under the curve, divided by its width.

    :param curve: success in percent by env steps
    :param begin: env steps at which the part begins
    :param end: env steps at which it ends, later; both within the curve
    :return: percent
    """
    steps = curve.index.to_numpy(dtype=np.float64)
    at = np.unique([begin, *steps[(steps > begin) & (steps < end)], end])
    return float(np.trapezoid(np.interp(at, steps, curve.to_numpy()), at) / (end - begin))


def learning_effect(results: Results, pair: Pair) -> tuple[Interval, float]:
    """How much more success a method has during training than its default, in points, and the p-value.

    The difference of the means over the part of the training that both were watched in, with Student's t interval over
    seeds and the p-value of his test; NaN if they have no such part.
    """
    found = []
    for own, other in watched(results, pair):
        begin, end = max(own.index[0], other.index[0]), min(own.index[-1], other.index[-1])
        if begin < end:
            found.append((mean_success(own, begin, end), mean_success(other, begin, end)))
    if not found:
        return UNKNOWN, float("nan")
    own_means, other_means = zip(*found, strict=True)
    return paired_t(own_means, other_means), paired_p(own_means, other_means)


def watched(results: Results, pair: Pair) -> list[tuple[pd.Series, pd.Series]]:
    """The curves of a method and its default, of each seed that has both."""
    own, other = (greedy_curves(results, key, pair.seeds) for key in (pair.key, pair.baseline))
    return [(own[seed], other[seed]) for seed in pair.seeds if seed in own and seed in other]
