"""Claims about how utilities are distributed over UAVs, and what makes them low."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import spearmanr

from lawn_sb3.game.fairness import gini
from lawn_sb3.paper.claims.claim import Condition, Finding, claim, shared_rule
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import (
    combine,
    counted,
    difference,
    held_to,
    higher,
    holds_if,
    known,
    seed_difference,
)
from lawn_sb3.paper.roles import FORMS
from lawn_sb3.results.statistics import mean_interval, mean_t


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


@shared_rule
def larger(evidence: Evidence, shape: str, of: list[str], than: list[str]) -> Finding:
    """Whether a figure of the distribution of the utility is larger for a method than for others.

    :param shape: a key of ``SHAPES``
    :param of: the parts of the method's forms
    :param than: the other parts
    """
    name, unit, decimals, figure_of = SHAPES[shape]
    values = {role: figure_of(evidence.utilities_mbps(role)) for role in [*of, *than]}
    verdict, figure, why = higher(evidence, name, values, of, unit, decimals)
    return Finding(verdict, f"{name}: {figure}", why)


@shared_rule
def collapses(evidence: Evidence, of: list[str], below_mbps: float, share_percent: float) -> Finding:
    """Whether nearly all utilities of some methods lie near zero, in every seed.

    :param of: the parts
    :param below_mbps: what counts as near zero
    :param share_percent: how many of the UAVs have to lie there
    """
    figures, names = [], []
    held: list[Condition] = []
    for role in of:
        shares = 100.0 * (evidence.utilities_mbps(role) < below_mbps).mean(axis=(1, 2))
        figures.append(f"{evidence.label(role)}: {mean_interval(shares).text(1)} % of the UAVs")
        held.append(holds_if(bool(shares.min() >= share_percent)))
        names.append(f"{evidence.label(role)} {'does' if held[-1] == 'holds' else 'does not'}")
    return Finding(
        combine(*([each] for each in held)),
        "; ".join(figures),
        f"At least {share_percent:g} % of the UAVs of every seed have to earn less than {below_mbps:g} Mbps: "
        f"{'; '.join(names)}.",
    )


@claim(
    place=230,
    section="II-B, III-A",
    text="The policies satisfy the collision avoidance constraint at all times, as the problem demands.",
    measure="UAVs of the trained players that are in the voxel of another at the end of a slot, test missions",
)
def collision_free(evidence: Evidence) -> Finding:
    """Whether no UAV is ever in the voxel of another: Eq. (4), eq:collision."""
    figures: list[str] = []
    held: list[Condition] = []
    for role in (*FORMS, "straight"):
        collisions = evidence.results.scores(evidence.key(role), "collisions", per="uav")  # [S, E, N]
        share = mean_interval(100.0 * (collisions > 0).mean(axis=(1, 2)))
        figures.append(f"{evidence.label(role)}: {share.text(1)} % of the UAVs collide")
        if role in FORMS:
            held.append(holds_if(not collisions.any()))
    return Finding(
        combine(*([each] for each in held)),
        "; ".join(figures),
        f"No UAV of the trained players may ever collide: {counted(held)} without.",
    )


@claim(
    place=760,
    section="V-C",
    text="The welfare-maximising policy routes some UAVs through more congested cells, with lower rates and longer "
    "completion times, to benefit the collective.",
    measure="flight times by cell load, spread and mean of the utility against UAVs that fly straight; that rates are "
    "lower in loaded cells holds by construction, and does not count",
)
def uneven_by_congestion(evidence: Evidence) -> Finding:
    """Whether UAVs in loaded cells get long flights, utilities are uneven, and that pays for all: three conditions."""
    figures: list[str] = []
    forms: list[list[Condition]] = []
    failed: list[str] = []
    flat, blind = _width(evidence.utilities_mbps("straight")), evidence.label("straight")
    for role in FORMS:
        rows = evidence.results.episodes
        rows = rows[(rows["method"] == evidence.key(role)) & rows["arrived"]]
        if not len(rows):
            raise CannotTellError(f"needs completed missions of {evidence.label(role)}")
        rates, delays = (
            np.array([of_seed(own) for _, own in rows.groupby("seed")])
            for of_seed in (_rate_with_load, _delay_of_the_loaded)
        )
        longer = held_to(evidence, "T/T_min of the loaded", role, delays, 1.0)
        width = SHAPES["width"].name
        wider = seed_difference(evidence, width, role, "straight", _width(evidence.utilities_mbps(role)), flat)
        gain = difference(evidence, "utility_mbps", role, "straight")
        label = evidence.label(role)
        figures.append(
            f"{label}: rank correlation of R̂ with cell load {known(mean_t(rates)).text(2)}; T/T_min of the most loaded "
            f"quarter over that of the least loaded {longer.text(3)}; differences to {blind}: width of U "
            f"{wider.text(1)} Mbps, mean U {gain.text(2)} Mbps"
        )
        conditions: dict[str, Condition] = {
            "longer flights": longer.above(),
            "more unevenness": wider.above(),
            "a gain for all": gain.above(),
        }
        forms.append(list(conditions.values()))
        failed += [f"{name} ({label})" for name, holds in conditions.items() if holds != "holds"]
    why = (
        "Loaded cells have to mean longer flights, and there has to be more unevenness, and a gain for all, than where "
    )
    why += f"nobody heeds anybody ({blind})"
    return Finding(
        combine(*forms), "; ".join(figures), f"{why}; not found: {', '.join(failed)}." if failed else f"{why}."
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
