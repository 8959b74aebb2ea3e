"""The price of anarchy, as a bracket: neither the largest welfare nor all equilibria of a mission are known."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.game.payoff import welfare
from lawn_sb3.report.section import Section
from lawn_sb3.report.sections.stability import HEADING, is_equilibrium
from lawn_sb3.report.table import Table
from lawn_sb3.results.attainable import attainable
from lawn_sb3.results.results import EQUILIBRIA, Results, score_matrix

Floats = NDArray[np.float64]


def section(results: Results) -> Section:
    """The price of anarchy, where equilibria were certified."""
    return Section(HEADING, {"anarchy": anarchy(results)})


class Welfares(NamedTuple):
    """What is known of the welfare of the missions that have a certified equilibrium, in Mbps [E]."""

    bound_mbps: Floats
    best_known_mbps: Floats
    best_equilibrium_mbps: Floats
    """Of those found."""
    worst_equilibrium_mbps: Floats
    """Of those found."""
    guaranteed_mbps: Floats
    """What no equilibrium is below."""


class Certified(NamedTuple):
    """Equilibria that were found and certified."""

    welfares: Welfares
    missions: int
    """Missions of the evaluation, with a certified equilibrium or without."""
    searches: int
    """Joint trajectories that players who look for equilibria have flown."""
    certified: int
    """Those of them that are equilibria."""


def certified_welfares(results: Results) -> Certified | None:
    """Gather the welfare of the equilibria, and what it is held against.

    :param results: what the runs left
    :return: welfares by mission; none without results of the bound, what is guaranteed, or any certified equilibrium
    """
    limits, guaranteed = attainable(results), results.checks.get("guaranteed")
    keys = [key for key, method in results.methods_in(results.regrets).items() if method.player in EQUILIBRIA]
    if limits is None or not keys or not isinstance(guaranteed, pd.DataFrame):
        return None
    holds = np.concatenate([is_equilibrium(results, key) for key in keys])  # [R, E]
    found = np.concatenate([welfare(score_matrix(results.regrets, key, "utility_mbps", per="uav")) for key in keys])
    known = holds.any(axis=0)
    if not known.any():
        return None
    best, worst = np.where(holds, found, -np.inf).max(axis=0), np.where(holds, found, np.inf).min(axis=0)
    least = guaranteed.groupby("episode")["guaranteed_mbps"].sum().to_numpy()
    parts = (limits.bound_mbps, limits.best_known_mbps, best, worst, least)
    return Certified(Welfares(*(part[known] for part in parts)), known.size, holds.size, int(holds.sum()))


def anarchy(results: Results) -> Table | None:
    """Bracket what selfishness costs.

    :param results: what the runs left
    :return: one row a ratio of the largest welfare to that of an equilibrium, at least and at most so much: the ratio
        of means over missions, and the largest of a single mission; none without a certified equilibrium
    """
    found = certified_welfares(results)
    if found is None:
        return None
    bound, best, best_eq, worst_eq, guaranteed = found.welfares
    ratios = {
        "Price of anarchy: the worst equilibrium there is": ((best, worst_eq), (bound, guaranteed)),
        "The worst equilibrium found": ((best, worst_eq), (bound, worst_eq)),
        "The best equilibrium found": ((best, best_eq), (bound, best_eq)),
        "Price of stability: the best equilibrium there is": ((best_eq, best_eq), (bound, best_eq)),
    }
    numbers: list[dict[str, Any]] = []
    for name, sides in ratios.items():
        row: dict[str, Any] = {"welfare": name}
        for side, (largest, equilibrium) in zip(("at_least", "at_most"), sides, strict=True):
            with np.errstate(divide="ignore"):  # with more UAVs than RBs in a cell nothing is guaranteed
                row[side] = float(np.divide(largest.mean(), equilibrium.mean()))
                row[f"{side}_one_mission"] = float(np.divide(largest, equilibrium).max())
        numbers.append({**row, "missions": len(bound)})
    shown = pd.DataFrame({"Largest welfare over that of": list(ratios)})
    for side, heading in {"": "Mean over missions", "_one_mission": "Mission with the most"}.items():
        shown[heading] = [_bracket(row[f"at_least{side}"], row[f"at_most{side}"]) for row in numbers]
    shown["n"] = str(len(bound))
    return Table(pd.DataFrame(numbers), shown, caption(found))


def _bracket(low: float, high: float) -> str:
    return f"{low:.3f} to {high:.3f}" if np.isfinite(high) else f"{low:.3f} or more"


def caption(found: Certified) -> str:
    """What the table of the price of anarchy shows, and what it takes for granted.

    :param found: the certified equilibria
    :return: one paragraph
    """
    return (
        "What selfishness costs: the largest welfare of a mission over that of an equilibrium, in which no UAV gains "
        "by changing its own trajectory alone. Neither the largest welfare nor every equilibrium is known, so each "
        "ratio is a bracket. The largest welfare lies between the best that any method here has flown and that of the "
        "UAVs if each were alone in the network. The worst equilibrium there is lies between the worst that was found "
        "and what is guaranteed: in an equilibrium every UAV has at least what its best flight gives if all others "
        "are in its own cell all the time, provided they do not block that flight by collisions; with more UAVs than "
        "RBs that is nothing. Taken for granted: "
        "every UAV chooses one whole trajectory in advance, not at random, knows those of all others, wants its own "
        "utility alone, may take up to T_max slots, and collides with nobody. Mean over missions: ratio of the means; "
        "mission with the most: the largest ratio of a single one. Equilibria: the regrets certify "
        f"{found.certified:,} of the {found.searches:,} results of the searches (all seeds); "
        f"{found.missions - len(found.welfares.bound_mbps)} of {found.missions} missions have none and are left out. "
        "n: missions."
    )
