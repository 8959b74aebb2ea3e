"""How far from the optimum: the price of anarchy as a bracket, and what each UAV could gain by deviating alone."""

import numpy as np
import pandas as pd

from lawn_sb3.experiment.measures import EQUILIBRIUM_MBPS
from lawn_sb3.report.cdf import distributions, panels_text
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.table import Row, Table, row_of, sample_text, table_of
from lawn_sb3.results.equilibria import Certified, certified_welfares, is_equilibrium, regrets_mbps
from lawn_sb3.results.results import Results, score_matrix
from lawn_sb3.results.statistics import mean_interval

GAIN_MBPS = 1.0
"""A gain worth deviating for."""
SHOWN = 0.995
COLUMNS = {
    "regret_mbps": ("Mean regret (Mbps)", 2),
    "nash_gap_mbps": ("Nash gap (Mbps)", 2),
    "gaining_percent": (f"UAVs with > {GAIN_MBPS:g} Mbps to gain (%)", 1),
    "equilibria_percent": ("Equilibria (%)", 1),
}
"""Column: its heading and its decimals."""
REGRET = (
    "How stable the outcome is. Regret of a UAV: the utility of its best response less the utility it had, never "
    "below 0. The best response is exact, over all trajectories and all flight times up to T_max, against the "
    "trajectories that the other UAVs of the episode flew: these stay as they were, although players who see the "
    "cell loads might have reacted. It avoids collisions, so a UAV that collided may have had more; that counts as "
    "regret 0. Nash gap: largest regret of an episode's UAVs, mean over episodes; largest regret: of all UAVs, "
    "episodes and seeds. Equilibria: episodes without collisions in which no UAV could gain more than "
    f"{EQUILIBRIUM_MBPS:g} Mbps. Means with 95 % bootstrap intervals over seeds; n: seeds × test episodes."
)
"""What the table of regrets shows."""


def section(results: Results) -> Section:
    """The price of anarchy where equilibria were certified, and regrets where they were worked out."""
    parts: dict[str, Table | Picture | None] = {"anarchy": anarchy(results)}
    if len(results.regrets):
        parts |= {"regret": _regret(results), "regret_cdf": _distribution(results)}
    return Section("How far from the optimum", parts)


def anarchy(results: Results) -> Table | None:
    """Bracket what selfishness costs, for the mean over missions and for the mission with the most.

    :param results: what the runs left
    :return: one row per ratio of the largest welfare to that of an equilibrium; none without a certified equilibrium
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
    rows = []
    for name, sides in ratios.items():
        row = Row({"welfare": name}, {"Largest welfare over that of": name})
        with np.errstate(divide="ignore"):  # with more UAVs than RBs in a cell nothing is guaranteed
            means = [float(np.divide(largest.mean(), equilibrium.mean())) for largest, equilibrium in sides]
            most = [float(np.divide(largest, equilibrium).max()) for largest, equilibrium in sides]
        for side, mean, one in zip(("at_least", "at_most"), means, most, strict=True):
            row.numbers |= {side: mean, f"{side}_one_mission": one}
        row.numbers["missions"] = len(bound)
        row.cells |= {"Mean over missions": _bracket(*means), "Mission with the most": _bracket(*most)}
        row.cells["n"] = str(len(bound))
        rows.append(row)
    return table_of(rows, _anarchy_caption(found))


def _bracket(low: float, high: float) -> str:
    return f"{low:.3f} to {high:.3f}" if np.isfinite(high) else f"{low:.3f} or more"


def _anarchy_caption(found: Certified) -> str:
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


def _regret(results: Results) -> Table:
    """Means over episodes and seeds with 95 % intervals over seeds, and the largest regret of each method."""
    found, rows = regrets_mbps(results), []
    for key in results.methods_in(found):
        own = score_matrix(found, key, "regret_mbps", per="uav")  # [S, E, N]
        by_seed = {
            "regret_mbps": own.mean(axis=(-2, -1)),
            "nash_gap_mbps": own.max(axis=-1).mean(axis=-1),
            "gaining_percent": 100.0 * (own > GAIN_MBPS).mean(axis=(-2, -1)),
            "equilibria_percent": 100.0 * is_equilibrium(results, key).mean(axis=-1),
        }
        row = row_of(results, key, seeds=len(own))
        for name, (heading, decimals) in COLUMNS.items():
            row.add(name, heading, mean_interval(by_seed[name]), decimals)
            if name == "nash_gap_mbps":
                row.cells["Largest regret (Mbps)"] = f"{own.max():.1f}"
        row.numbers["largest_mbps"] = own.max()
        row.cells["n"] = sample_text(len(own), results.recipe.evaluation.episodes)
        rows.append(row)
    return table_of(rows, REGRET)


def _distribution(results: Results) -> Picture:
    """The share of the UAVs below each regret."""
    xlabel, ylabel = "regret of a UAV (Mbps): what it could gain by deviating alone", "share of the UAVs"
    rows = regrets_mbps(results)
    figure = distributions(results, rows, "regret_mbps", xlabel, ylabel, shown_mbps(results, rows))
    caption = (
        "Share of the UAVs whose regret is at most the value on the axis, all test episodes and seeds; bands: range "
        "over seeds. Where a curve begins at the left is the share of UAVs that have nothing to gain: in equilibria "
        "all of them, along the upper edge. "
        f"{panels_text(results, results.regrets)}The axis ends where {100 * SHOWN:g} % of the UAVs of each method lie "
        "below, the random player aside."
    )
    return Picture(figure, caption)


def shown_mbps(results: Results, rows: pd.DataFrame) -> float:
    """Where the axis ends: at the regret that 99.5 % of the UAVs of each method stay below, Random aside if it can be.

    Otherwise the few UAVs with the most regret would squeeze all others.
    """
    found = results.methods_in(rows)
    chosen = [key for key, method in found.items() if method.player != "random"] or list(found)
    own = rows[rows["method"].isin(chosen)]
    return max(float(own.groupby("method")["regret_mbps"].quantile(SHOWN).max()), GAIN_MBPS)
