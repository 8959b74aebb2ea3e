"""Claims about the figures of single methods: rows of Table II, and what their times can mean."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.paper.claims.claim import CannotTellError, Evidence, Finding
from lawn_sb3.paper.claims.comparisons import combine, counted, in_words, join, known, sentence
from lawn_sb3.paper.printed_values import ROUNDING, TABLE_II, TEST_EPISODES, PaperRow
from lawn_sb3.results.statistics import mean_interval

FAR = 3.0
"""Standard errors from which on a figure does not agree with the paper's."""

PAPER_SEEDS = 5
"""Seeds that a figure of Table II is averaged over."""


def agrees_with_row(evidence: Evidence, role: str) -> Finding:
    """Whether the four figures of a row of Table II come out, within three standard errors.

    The paper prints no spread: its episodes and seeds are taken to spread as ours do.

    :param evidence: what the runs left
    :param role: the part
    :return: the finding
    :raises CannotTellError: if the method has no row, or a single seed
    """
    row = evidence.method(role).paper_row
    if row is None:
        raise CannotTellError(f"needs a row of {evidence.label(role)} in the paper's Table II")
    figures, agree, far = [], [], []
    for quantity in PaperRow._fields:
        symbol = in_words(quantity)[0]
        printed = float(getattr(TABLE_II[row], quantity))
        own = evidence.scores(role, quantity)  # [S, E]
        found = known(mean_interval(own.mean(axis=1)))
        away = found.value - printed
        figures.append(f"{symbol} {found.text(2)} (paper {printed:g})")
        agree.append(abs(away) <= FAR * _standard_error(own, float(getattr(ROUNDING, quantity))))
        if not agree[-1]:
            far.append(f"{symbol} {'above' if away > 0 else 'below'} the paper's by {abs(away):.2f}")
    why = "All four figures agree within three standard errors." if not far else sentence(join(far))
    return Finding(combine(agree), "; ".join(figures), why)


def _standard_error(own: NDArray[np.float64], rounding: float) -> float:
    """Standard error of the difference between our mean and a printed one: missions, seeds and rounding of both."""
    num_seeds, num_episodes = own.shape
    missions = own.var(axis=1, ddof=1).mean() * (1 / num_episodes + 1 / TEST_EPISODES) if num_episodes > 1 else 0.0
    seeds = own.mean(axis=1).var(ddof=1) * (1 / num_seeds + 1 / PAPER_SEEDS)
    return float(np.sqrt(missions + seeds + rounding**2))


def average_completion(evidence: Evidence, role: str) -> Finding:
    """Whether the printed time of a row can be the mean of T_i over the UAVs.

    :param evidence: what the runs left
    :param role: the part
    :return: the finding; impossible if the mean over UAVs lies below the printed time
    :raises CannotTellError: if the method has no row, or a single seed
    """
    row = evidence.method(role).paper_row
    if row is None:
        raise CannotTellError(f"needs a row of {evidence.label(role)} in the paper's Table II")
    printed = TABLE_II[row]
    mean = known(mean_interval(evidence.scores(role, "slots").mean(axis=1)))
    last = known(mean_interval(evidence.scores(role, "makespan_slots").mean(axis=1)))
    below = mean.high < printed.makespan_slots - ROUNDING.makespan_slots
    return Finding(
        "impossible as printed" if below else "reproduced",
        f"{evidence.label(role)}: T {mean.text(1)} slots on average over the UAVs, {last.text(1)} until the last of "
        f"an episode is done (paper: T̄ {printed.makespan_slots:.1f} at {printed.success_percent:g} % success)",
        "UAVs that arrive before the deadline bring the mean over UAVs below the printed time; T̄ is held to the slots "
        "until the last UAV is done."
        if below
        else "The mean over UAVs does not lie below the printed time.",
    )


def time_ratio(evidence: Evidence, straight: str) -> Finding:
    """Whether T_i^min / T_i lies in (0, 1] for every completed mission, and is 1 for UAVs that fly straight.

    :param evidence: what the runs left
    :param straight: the part of the player that flies straight
    :return: the finding
    """
    key, flown = evidence.key(straight), evidence.results.episodes
    flown = flown[flown["arrived"]]
    ratio = flown["min_slots"] / flown["slots"]
    shortest = ratio[flown["method"] == key]
    if not len(shortest):
        raise CannotTellError(f"needs completed missions of {evidence.label(straight)}")
    held = [bool(ratio.between(0.0, 1.0, inclusive="right").all()), bool((shortest == 1.0).all())]
    return Finding(
        combine(held),
        f"T_min/T from {ratio.min():.3f} to {ratio.max():.3f} in {len(ratio):,} completed missions of all methods; "
        f"{evidence.label(straight)}: from {shortest.min():.3f} to {shortest.max():.3f}",
        "It has to lie above 0 and at most at 1 always, and at 1 on a shortest path.",
    )


def varies_little(evidence: Evidence, quantity: str, role: str, within: float) -> Finding:
    """Whether a player that does not learn, and so has no learning curve, gets much the same with every seed.

    :param evidence: what the runs left
    :param quantity: the figure
    :param role: the part
    :param within: how wide the interval over seeds may be
    :return: the finding
    """
    symbol, unit, decimals = in_words(quantity)
    found = known(mean_interval(evidence.scores(role, quantity).mean(axis=1)))
    width = found.high - found.low
    return Finding(
        "reproduced" if width < within else "not reproduced",
        f"{evidence.label(role)}: {symbol} {found.text(decimals)}",
        "A player that does not learn has no curve: the interval over its seeds has to be narrower than "
        f"{within:g}{unit}, and is {width:.1f} wide.",
    )


def reaches(evidence: Evidence, quantity: str, of: list[str], at_least: float) -> Finding:
    """Whether a method's final figure is as high as claimed, at the precision of print.

    :param evidence: what the runs left
    :param quantity: the figure
    :param of: the parts of the method's forms
    :param at_least: the claim, rounded as printed
    :return: the finding
    """
    symbol, _, decimals = in_words(quantity)
    figures, held = [], []
    for role in of:
        found = mean_interval(evidence.scores(role, quantity).mean(axis=1))
        figures.append(f"{evidence.label(role)}: {symbol} {found.text(decimals)}")
        held.append(bool(round(found.value, 1) >= at_least))
    why = f"Rounded to one decimal the mean has to reach {at_least:g}: {counted(held)}."
    return Finding(combine(held), "; ".join(figures), why)
