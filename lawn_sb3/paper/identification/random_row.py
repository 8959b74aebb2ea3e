"""The Random row of the paper's Table II under each candidate, and how far it lies from the printed one."""

import numpy as np
import pandas as pd

from lawn_sb3.paper.identification.bounds import rate_ceiling_mbps
from lawn_sb3.paper.identification.candidates import LINK_BUDGET, Candidate, TimeReading, link_budget_db
from lawn_sb3.paper.printed_values import LATEST_SLOTS, ROUNDING, TABLE_II, PaperRow
from lawn_sb3.paper.standard_error import DISFAVOURED_Z, standard_error, verdict

FIGURES = PaperRow._fields
LEAST = "min_slots"
"""Mean T_i^min: whatever T-bar averages, no method can be faster. The bound is tested on the paper's CTDE-MAPPO."""
CEILING = "rate_ceiling_mbps"
"""The rate that no method as fast as the paper's CTDE-MAPPO exceeds; the paper's is tested, without sampling error."""
TESTED = (*FIGURES, LEAST)


def episode_figures(rows: pd.DataFrame, time: TimeReading = "makespan_slots") -> pd.DataFrame:
    """Figures of each joint episode: means over its UAVs.

    :param rows: what :func:`lawn_sb3.experiment.evaluation.evaluate` returned
    :param time: what T-bar averages
    :return: one row per episode, with the columns ``TESTED``; ``makespan_slots`` is T-bar as it is read, NaN where
        nobody arrived and only those who do count
    """
    timed = rows.assign(arrived_slots=rows["slots"].where(rows["arrived"]), arrived=100.0 * rows["arrived"])
    means = timed.groupby("episode")[["reward", "rate_mbps", time, "arrived", LEAST]].mean()
    return means.set_axis(list(TESTED), axis="columns")


def z_scores(own: pd.DataFrame, preset: pd.DataFrame) -> dict[str, float]:
    """How many standard errors our figures lie above the paper's.

    :param own: figures of a candidate's episodes
    :param preset: those of the preset's, whose spread is the least that is assumed
    :return: one number for each of ``TESTED``; that of T_i^min is 0 where the paper's CTDE-MAPPO takes longer
    """
    printed = {**TABLE_II["Random"]._asdict(), LEAST: TABLE_II["CTDE-MAPPO"].makespan_slots}
    rounding = {**ROUNDING._asdict(), LEAST: ROUNDING.makespan_slots}
    z = {
        name: (float(own[name].mean()) - printed[name])
        / standard_error(own[name], rounding[name], float(preset[name].std()))
        for name in TESTED
    }
    return {**z, LEAST: max(z[LEAST], 0.0)}


def random_row(candidate: Candidate, rows: pd.DataFrame, preset_rows: pd.DataFrame) -> dict[str, object]:
    """One row of the table of candidates.

    :param candidate: the candidate
    :param rows: the Random player's evaluation in its scenario
    :param preset_rows: that in the preset
    :return: constant, candidate, whether it is the preset's, ``FIGURE, z_FIGURE`` for each of ``TESTED``, the ceiling
        of the rate, the verdict, and the columns that speak against the candidate
    """
    own = episode_figures(rows, candidate.time)
    z = z_scores(own, episode_figures(preset_rows))
    row: dict[str, object] = {
        "constant": candidate.constant,
        "candidate": candidate.label,
        "is_preset": candidate.is_preset,
        "link_budget_db": link_budget_db(candidate.scenario),
    }
    for name in TESTED:
        row[name], row[f"z_{name}"] = float(own[name].mean()), z[name]
    against = [name for name in TESTED if abs(z[name]) > DISFAVOURED_Z]
    row["verdict"] = verdict(max(map(abs, z.values())))
    printed = TABLE_II["CTDE-MAPPO"]
    ceiling = rate_ceiling_mbps(candidate.scenario, LATEST_SLOTS)
    if ceiling < printed.rate_mbps - ROUNDING.rate_mbps:
        row["verdict"] = "ruled out"
        against.append(CEILING)
    return {**row, CEILING: ceiling, "against": ", ".join(against)}


def link_budget_interval(random: pd.DataFrame) -> tuple[float | None, float | None]:
    """Link budgets P_tx + beta_0 - sigma^2 whose rate of Random agrees with the paper's.

    More power gives more rate, so z grows with the budget and is inverted by linear interpolation between candidates.

    :param random: the table of candidates
    :return: least and largest budget in dB within ``DISFAVOURED_Z`` standard errors; None where the candidates do not
        reach that far
    """
    tried = random[random["constant"] == LINK_BUDGET].sort_values("link_budget_db")
    budgets, z = tried["link_budget_db"].to_numpy(), tried["z_rate_mbps"].to_numpy()
    low, high = np.interp([-DISFAVOURED_Z, DISFAVOURED_Z], z, budgets)
    return float(low) if z[0] <= -DISFAVOURED_Z else None, float(high) if z[-1] >= DISFAVOURED_Z else None
