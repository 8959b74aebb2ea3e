"""Claims about how utilities are distributed over UAVs, and what makes them low."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import spearmanr

from lawn_sb3.game.fairness import gini
from lawn_sb3.paper.claims.claim import CannotTellError, Evidence, Finding
from lawn_sb3.paper.claims.comparisons import combine, counted, difference, higher, is_positive, known, seed_difference
from lawn_sb3.results.statistics import mean_interval

UTILITY = "utility_mbps"


def _width(utility: NDArray[np.float64]) -> NDArray[np.float64]:
    low, high = np.quantile(utility, [0.1, 0.9], axis=(1, 2))
    return np.asarray(high - low)


class Shape(NamedTuple):
    """A figure of the distribution of the utility."""

    name: str
    unit: str
    decimals: int
    of: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    """From utilities of every seed, episode and UAV [S, E, N] to the figure of every seed [S]."""


SHAPES = {
    "width": Shape("width from the 10th to the 90th percentile of U", " Mbps", 1, _width),
    "median": Shape("median of U", " Mbps", 1, lambda utility: np.asarray(np.median(utility, axis=(1, 2)))),
    "gini": Shape("Gini coefficient of U within an episode", "", 3, lambda utility: gini(utility).mean(axis=1)),
}


def by_seed(evidence: Evidence, role: str, shape: str) -> NDArray[np.float64]:
    """A figure of the distribution of the utility.

    :param evidence: what the runs left
    :param role: the part
    :param shape: a key of ``SHAPES``
    :return: one value a seed [S]
    """
    return SHAPES[shape].of(evidence.results.scores(evidence.key(role), UTILITY, per="uav"))


def larger(evidence: Evidence, shape: str, of: list[str], than: list[str]) -> Finding:
    """Whether a figure of the distribution of the utility is larger for a method than for others.

    :param evidence: what the runs left
    :param shape: the figure
    :param of: the parts of the method's forms
    :param than: the other parts
    :return: the finding
    """
    name, unit, decimals, _ = SHAPES[shape]
    values = {role: by_seed(evidence, role, shape) for role in [*of, *than]}
    verdict, why = higher(values, of, than, decimals)
    shown = [f"{evidence.label(role)}: {mean_interval(own).text(decimals)}{unit}" for role, own in values.items()]
    return Finding(verdict, f"{name}: {'; '.join(shown)}", why)


def collapses(evidence: Evidence, of: list[str], below_mbps: float, share_percent: float) -> Finding:
    """Whether nearly all utilities of some methods lie near zero, in every seed.

    :param evidence: what the runs left
    :param of: the parts
    :param below_mbps: what counts as near zero
    :param share_percent: how many of the UAVs have to lie there
    :return: the finding
    """
    figures, held, names = [], [], []
    for role in of:
        utility = evidence.results.scores(evidence.key(role), UTILITY, per="uav")
        shares = 100.0 * (utility < below_mbps).mean(axis=(1, 2))
        figures.append(f"{evidence.label(role)}: {mean_interval(shares).text(1)} % of the UAVs")
        held.append(bool(shares.min() >= share_percent))
        names.append(f"{evidence.label(role)} {'does' if held[-1] else 'does not'}")
    return Finding(
        combine(held),
        "; ".join(figures),
        f"At least {share_percent:g} % of the UAVs of every seed have to earn less than {below_mbps:g} Mbps: "
        f"{'; '.join(names)}.",
    )


def never_collide(evidence: Evidence, of: list[str]) -> Finding:
    """Whether no UAV of a method is ever in the voxel of another (eq:collision).

    :param evidence: what the runs left
    :param of: the parts of the method's forms
    :return: the finding
    """
    figures, held = [], []
    for role in of:
        collisions = evidence.results.scores(evidence.key(role), "collisions", per="uav")  # [S, E, N]
        share = mean_interval(100.0 * (collisions > 0).mean(axis=(1, 2)))
        figures.append(f"{evidence.label(role)}: {share.text(1)} % of the UAVs collide")
        held.append(not collisions.any())
    return Finding(combine(held), "; ".join(figures), f"No UAV may ever collide: {counted(held)} without.")


def uneven_through_congestion(evidence: Evidence, of: list[str], straight: str) -> Finding:
    """Whether UAVs in loaded cells get low rates and long flights, and whether that is a policy that pays for all.

    :param evidence: what the runs left
    :param of: the parts of the method's forms
    :param straight: the part of the player whose UAVs heed nobody
    :return: the finding: four conditions a form
    """
    figures: list[str] = []
    held: list[bool] = []
    failed: list[str] = []
    flat, blind = by_seed(evidence, straight, "width"), evidence.label(straight)
    for role in of:
        rows = evidence.results.episodes
        rows = rows[(rows["method"] == evidence.key(role)) & rows["arrived"]]
        if not len(rows):
            raise CannotTellError(f"needs completed missions of {evidence.label(role)}")
        rates, delays = (
            known(mean_interval([of_seed(own) for _, own in rows.groupby("seed")]))
            for of_seed in (_rate_with_load, _delay_of_the_loaded)
        )
        wider = seed_difference(by_seed(evidence, role, "width"), flat)
        gain = difference(evidence, UTILITY, role, straight)
        label = evidence.label(role)
        figures.append(
            f"{label}: rank correlation of R̂ with cell load {rates.text(2)}; T/T_min of the most loaded quarter over "
            f"that of the least loaded {delays.text(3)}; differences to {blind}: width of U {wider.text(1)} Mbps, "
            f"mean U {gain.text(2)} Mbps"
        )
        conditions = {
            "lower rates": is_positive(-rates.high),
            "longer flights": is_positive(delays.low - 1.0),
            "more unevenness": is_positive(wider.low),
            "a gain for all": is_positive(gain.low),
        }
        held += conditions.values()
        failed += [f"{name} ({label})" for name, holds in conditions.items() if not holds]
    why = "Loaded cells have to mean lower rates and longer flights, and there has to be more unevenness, and a gain "
    why += f"for all, than where nobody heeds anybody ({blind})"
    return Finding(
        combine(held), "; ".join(figures), f"{why}; not shown: {', '.join(failed)}." if failed else f"{why}."
    )


def _rate_with_load(rows: pd.DataFrame) -> float:
    """Rank correlation of the rate with the load of the cell; 0 where the rate is always the same."""
    if rows["mean_cell_load"].nunique() < 2:
        raise CannotTellError("needs completed missions in cells of different loads")
    if rows["rate_mbps"].nunique() < 2:
        return 0.0
    return float(spearmanr(rows["mean_cell_load"], rows["rate_mbps"])[0])


def _delay_of_the_loaded(rows: pd.DataFrame) -> float:
    """Flight time over the least, of the quarter in the most loaded cells relative to that in the least loaded."""
    delay, load = rows["slots"] / rows["min_slots"], rows["mean_cell_load"]
    low, high = load.quantile([0.25, 0.75])
    if low == high:
        raise CannotTellError("needs completed missions in cells of different loads")
    return float(delay[load >= high].mean() / delay[load <= low].mean())
