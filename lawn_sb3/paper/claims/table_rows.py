"""Claims about the figures of single methods: rows of Table II, and what their times can mean."""

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.paper.claims.claim import Condition, Finding, claim, shared_rule
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import (
    at_least,
    by_seed,
    combine,
    counted,
    holds_if,
    in_words,
    join,
    known,
    sentence,
)
from lawn_sb3.paper.printed_values import ROUNDING, TABLE_II, TEST_EPISODES, PaperRow
from lawn_sb3.paper.roles import FORMS
from lawn_sb3.paper.standard_error import RULED_OUT_Z
from lawn_sb3.results.statistics import mean_interval

PAPER_SEEDS = 5
"""Seeds that a figure of Table II is averaged over."""


def printed_row(evidence: Evidence, role: str) -> PaperRow:
    """The row of Table II that is about the method of a part.

    :raises CannotTellError: if it has none
    """
    row = evidence.method(role).paper_row
    if row is None:
        raise CannotTellError(f"needs a row of {evidence.label(role)} in the paper's Table II")
    return TABLE_II[row]


@shared_rule
def agrees_with_row(evidence: Evidence, role: str) -> Finding:
    """Whether the four figures of a row of Table II come out, within three standard errors.

    The paper prints no spread: its episodes and seeds are taken to spread as ours do.

    :param role: the part
    """
    row = printed_row(evidence, role)
    figures, far = [], []
    agree: list[Condition] = []
    for quantity, printed in row._asdict().items():
        symbol, own = in_words(quantity)[0], evidence.scores(role, quantity)  # [S, E]
        found = known(mean_interval(own.mean(axis=1)))
        away = found.value - printed
        figures.append(f"{symbol} {found.text(2)} (paper {printed:g})")
        error = _standard_error(own, float(getattr(ROUNDING, quantity)))
        agree.append(holds_if(abs(away) <= RULED_OUT_Z * error))
        if agree[-1] == "fails":
            far.append(f"{symbol} {'above' if away > 0 else 'below'} the paper's by {abs(away):.2f}")
    why = "All four figures agree within three standard errors." if not far else sentence(join(far))
    return Finding(combine(agree), "; ".join(figures), why)


def _standard_error(own: NDArray[np.float64], rounding: float) -> float:
    """Standard error of the difference between our mean and a printed one: missions, seeds and rounding of both."""
    num_seeds, num_episodes = own.shape
    missions = own.var(axis=1, ddof=1).mean() * (1 / num_episodes + 1 / TEST_EPISODES) if num_episodes > 1 else 0.0
    seeds = own.mean(axis=1).var(ddof=1) * (1 / num_seeds + 1 / PAPER_SEEDS)
    return float(np.sqrt(missions + seeds + rounding**2))


@claim(
    place=660,
    section="V-B, Table II",
    text="T̄ is the average completion time, and Random's is 100.0 slots at 22.4 % success.",
    measure="mean of T over the UAVs of Random, T_max for those that fail; and what those that arrive need to take for "
    "the printed time",
)
def average_completion(evidence: Evidence) -> Finding:
    """Whether the time printed for Random can be the mean of T_i over the UAVs, or lies above all that it can be."""
    printed = printed_row(evidence, "random")
    mean = known(mean_interval(evidence.scores("random", "slots").mean(axis=1)))
    last = known(by_seed(evidence, "random", "makespan_slots"))
    least = printed.makespan_slots - ROUNDING.makespan_slots
    below = mean.high < least
    # With the share p arriving, the mean is (1 - p) T_max + p T.
    game, share = evidence.results.recipe.game(), printed.success_percent / 100.0
    arrived = evidence.results.episodes
    arrived = arrived[(arrived["method"] == evidence.key("random")) & arrived["arrived"]]
    needed = game.max_slots - (game.max_slots - least) / share
    own = f", and take {arrived['slots'].mean():.1f}" if len(arrived) else ""
    return Finding(
        "impossible as printed" if below else "reproduced",
        f"{evidence.label('random')}: T {mean.text(1)} slots on average over the UAVs, {last.text(1)} until the last "
        f"of an episode is done (paper: T̄ {printed.makespan_slots:.1f} at {printed.success_percent:g} % success); "
        f"those that arrive would have to take {needed:.1f} slots on average{own}",
        "UAVs that arrive before the deadline bring the mean over UAVs below the printed time; T̄ is held to the slots "
        "until the last UAV is done."
        if below
        else "The mean over UAVs does not lie below the printed time.",
    )


@claim(
    place=340,
    section="III-A",
    text="The ratio T_min/T lies in (0, 1] and equals 1 on the time-optimal path.",
    measure="the ratio in all completed test missions",
    owed_to="by construction",
)
def time_ratio(evidence: Evidence) -> Finding:
    """Whether the ratio lies in (0, 1] for every completed mission, and is 1 for UAVs that fly straight."""
    key, flown = evidence.key("straight"), evidence.results.episodes
    flown = flown[flown["arrived"]]
    ratio = flown["min_slots"] / flown["slots"]
    shortest = ratio[flown["method"] == key]
    if not len(shortest):
        raise CannotTellError(f"needs completed missions of {evidence.label('straight')}")
    within = bool(ratio.between(0.0, 1.0, inclusive="right").all())
    held = [holds_if(within), holds_if(bool((shortest == 1.0).all()))]
    return Finding(
        combine(held),
        f"T_min/T from {ratio.min():.3f} to {ratio.max():.3f} in {len(ratio):,} completed missions of all methods; "
        f"{evidence.label('straight')}: from {shortest.min():.3f} to {shortest.max():.3f}",
        "It has to lie above 0 and at most at 1 always, and at 1 on a shortest path.",
    )


@claim(
    place=600,
    section="V-B, Fig. 2",
    text="The random baseline remains almost flat.",
    measure="width of the 95 % interval of its success over seeds; five points count; a player that does not learn has "
    "no curve",
    owed_to="by construction",
)
def random_flat(evidence: Evidence) -> Finding:
    """Whether Random, which does not learn and so has no learning curve, gets much the same with every seed.

    Seeds that get this and that leave open what it gets: they cannot show a curve where there is none.
    """
    within = 5.0
    symbol, unit, decimals = in_words("success_percent")
    found = known(by_seed(evidence, "random", "success_percent"))
    width = found.high - found.low
    return Finding(
        combine(["holds" if width < within else "open"]),
        f"{evidence.label('random')}: {symbol} {found.text(decimals)}",
        "A player that does not learn has no curve: the interval over its seeds has to be narrower than "
        f"{within:g}{unit}, and is {width:.1f} wide.",
    )


@claim(
    place=680,
    section="V-B, Table II",
    text="CTDE-MAPPO achieves a perfect success rate.",
    measure="success of the trained players on the test missions",
    headline=True,
)
def perfect_success(evidence: Evidence) -> Finding:
    """Whether success is 100 % at the precision of print; it fails only if its whole interval lies below."""
    perfect = 100.0
    symbol, _, decimals = in_words("success_percent")
    figures: list[str] = []
    held: list[Condition] = []
    for role in FORMS:
        found = by_seed(evidence, role, "success_percent")
        figures.append(f"{evidence.label(role)}: {symbol} {found.text(decimals)}")
        reached = round(found.value, 1) >= perfect
        held.append("holds" if reached else at_least(found, perfect) if found.is_known else "open")
    why = f"Rounded to one decimal the mean has to reach {perfect:g}: {counted(held)}."
    return Finding(combine(*([each] for each in held)), "; ".join(figures), why)
