"""Ablations beside their defaults, seed by seed: what all tables and figures of effects are made of."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import Interval, holm, paired_p, paired_t, probability_of_improvement

SORTED_BY = "reward"
MARK, SURE_MARK = " †", " ‡"
"""Beside an effect whose interval leaves 0 out, and beside one that also passes Holm's correction."""
EFFECTS = ("reward", "success_percent", "makespan_slots", "utility_mbps", "collisions")
"""The quantities whose change is an effect."""
SEARCHED = (
    "All settings were searched for the defaults and for none of their ablations, which a search of their own might "
    "improve; some change more than their name says, see runs/ablation.yaml."
)
"""What captions say of the settings that they compare."""


@dataclass(frozen=True)
class Pair:
    """A method and its default on the seeds that both have.

    :param key: the method
    :param baseline: the method that it is an ablation of
    :param own: means of the method's evaluations, one row per seed, with the columns of ``EFFECTS``
    :param other: the same of the default, with the same seeds in the same order
    """

    key: str
    baseline: str
    own: pd.DataFrame
    other: pd.DataFrame

    @property
    def seeds(self) -> list[int]:
        """The seeds that both have."""
        return [int(seed) for seed in self.own.index]

    def differences(self, quantity: str) -> pd.Series:
        """Method minus default, seed by seed, of one of ``EFFECTS``."""
        return self.own[quantity] - self.other[quantity]

    def effect(self, quantity: str) -> Interval:
        """The mean of these differences, with Student's t interval over seeds."""
        return paired_t(self.own[quantity], self.other[quantity])

    def p_value(self, quantity: str) -> float:
        """That of Student's paired test; NaN for one seed, and where chance has no part: all differences are equal."""
        return paired_p(self.own[quantity], self.other[quantity])

    def improvement(self, results: Results, column: str) -> Interval:
        """How often a seed of the method beats a seed of the default on the same test episode.

        :param results: what the runs left
        :param column: column of the raw rows of which more is better
        :return: the probability, ties counted half, with a bootstrap interval over seeds
        """
        own, other = (
            results.scores(key, column)[np.isin(results.seeds(key), self.seeds)] for key in (self.key, self.baseline)
        )
        return probability_of_improvement(own, other)


def significant(effect: Interval) -> bool:
    """Whether an interval leaves 0 out; not if its bounds are unknown."""
    return effect.low > 0.0 or effect.high < 0.0


class Marks:
    """Which of several effects are there: by themselves, and among all of them.

    :param effects: intervals, each with its p-value, in any order; NaN where chance has no part
    """

    def __init__(self, effects: Sequence[tuple[Interval, float]]) -> None:
        tested = [p for effect, p in effects if effect.is_known and not np.isnan(p)]
        self.level = holm(tested)
        self.num_tested = len(tested)
        self.num_marked = sum(significant(effect) for effect, p in effects if not np.isnan(p))
        self.num_sure = sum(p <= self.level for p in tested)

    def is_sure(self, effect: Interval, p_value: float) -> bool:
        """Whether an effect passes Holm's correction; one in which all seeds agree to the last digit needs none."""
        return significant(effect) and (bool(np.isnan(p_value)) or p_value <= self.level)

    def mark(self, effect: Interval, p_value: float) -> str:
        """What stands beside it in a table."""
        return SURE_MARK if self.is_sure(effect, p_value) else MARK if significant(effect) else ""


def marks_of(groups: Mapping[str, Sequence[Pair]]) -> Marks:
    """Those of all effects of all pairs."""
    pairs = [pair for own in groups.values() for pair in own]
    return Marks([(pair.effect(name), pair.p_value(name)) for pair in pairs for name in EFFECTS])


def pair_up(results: Results) -> dict[str, list[Pair]]:
    """Every method that is an ablation of another one, by its default, where both have results.

    Ablations go from the best effect on J to the worst; defaults that are MAPPO come first, others as in the recipe.
    """
    if not len(results.episodes):
        return {}
    by_seed = results.by_seed().set_index("seed")
    figures = {key: rows[[*EFFECTS]] for key, rows in by_seed.groupby("method")}
    methods = results.recipe.methods
    groups: dict[str, list[Pair]] = {key: [] for key in sorted(methods, key=lambda key: methods[key].algo != "mappo")}
    for key, baseline in _ablations(results).items():
        common = _common_seeds(results, key, baseline)
        if common:
            groups[baseline].append(Pair(key, baseline, figures[key].loc[common], figures[baseline].loc[common]))
    return {
        baseline: sorted(pairs, key=lambda pair: pair.effect(SORTED_BY).value, reverse=True)
        for baseline, pairs in groups.items()
        if pairs
    }


def left_out(results: Results) -> list[str]:
    """One line for each ablation that has no effect to show."""
    problems = []
    for key, baseline in _ablations(results).items():
        missing = [name for name in (key, baseline) if name not in results.methods]
        if missing:
            problems.append(f"{key}: not among the effects, as there is no whole run of {' and of '.join(missing)}")
        elif not _common_seeds(results, key, baseline):
            problems.append(f"{key}: not among the effects, as no seed has whole runs of both {key} and {baseline}")
    return problems


def _ablations(results: Results) -> dict[str, str]:
    """The recipe's ablations, and what each is an ablation of."""
    methods = results.recipe.methods
    return {key: method.baseline for key, method in methods.items() if method.baseline is not None}


def _common_seeds(results: Results, key: str, baseline: str) -> list[int]:
    return sorted(set(results.seeds(key)) & set(results.seeds(baseline)))
