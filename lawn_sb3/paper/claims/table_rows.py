"""Claims about the figures of single methods: rows of Table II, and what their times can mean."""

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.paper.claims.claim import Condition, Finding, Verdict, claim, shared_rule
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import (
    against_all,
    combine,
    counted,
    held_to,
    holds_if,
    in_words,
    join,
    known,
)
from lawn_sb3.paper.printed_values import ROUNDING, TABLE_II, TEST_EPISODES, PaperRow
from lawn_sb3.paper.roles import FORMS
from lawn_sb3.paper.standard_error import DISFAVOURED_Z
from lawn_sb3.results.statistics import LEVEL, mean_interval, mean_t

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
def agrees_with_row(evidence: Evidence, role: str, fitted: bool = False) -> Finding:
    """Whether the four figures of a row of Table II come out, within a margin, by two one-sided tests (TOST) each.

    The margin is what rounding and test missions alone may make of it: half a unit of the last printed digit, and two
    standard errors of the difference between two means over 200 episodes. The paper prints no spread: its episodes are
    taken to spread as ours do, in success as much at least as chance has it at the printed share, and so are its seeds,
    five of which make its mean. Noise between seeds widens the
    intervals and not the margin, so that noisy runs leave open whether a figure agrees.

    :param role: the part
    :param fitted: the game's constants were chosen by these figures. That they agree then needs no test, as it says
        nothing; what speaks against one still does, at 5 % for itself
    """
    row, num_uavs = printed_row(evidence, role), evidence.results.recipe.game().num_uavs
    counted_in = Evidence(evidence.results) if fitted else evidence  # it raises no bar for what is no fit
    figures, notes = [], []
    agree: list[Condition] = []
    for quantity, printed in row._asdict().items():
        symbol, own = in_words(quantity)[0], evidence.scores(role, quantity)  # [S, E]
        num_seeds, num_episodes = own.shape
        if num_episodes < TEST_EPISODES:
            raise CannotTellError(f"needs {TEST_EPISODES} test episodes of {evidence.label(role)}, as the paper has")
        chance = _variance_of_success(printed, num_uavs) if quantity == "success_percent" else 0.0
        margin = _margin(own, float(getattr(ROUNDING, quantity)), chance)
        by_seed = own.mean(axis=1)
        mean = by_seed.mean()
        # As far apart as differences between means of so many seeds and of five are wide.
        apart = mean + (by_seed - mean) * np.sqrt(1.0 + num_seeds / PAPER_SEEDS)
        low, high = (
            held_to(counted_in, f"{quantity} as printed", role, apart, printed + side * margin) for side in (-1.0, 1.0)
        )
        agree.append(against_all([low.reaches(), high.reaches(-1.0)]))
        figures.append(f"{symbol} {low.text(2)} (paper {printed:g} ± {margin:.2f})")
        if agree[-1] == "fails":
            notes.append(
                f"{symbol} is {'above' if mean > printed else 'below'} the paper's by {abs(mean - printed):.2f}"
            )
        elif agree[-1] == "open":
            notes.append(f"{symbol} cannot be told")
    return Finding(
        "fitted" if fitted and "fails" not in agree else "contradicted" if fitted else combine(agree),
        "; ".join(figures),
        f"Each figure has to lie within ±: half a unit of the last printed digit and {DISFAVOURED_Z:g} standard errors "
        f"of the difference between two means over {TEST_EPISODES} episodes. In brackets is where a mean over "
        f"{PAPER_SEEDS} other seeds lies: {join(notes) if notes else 'all four agree'}.",
    )


def _margin(own: NDArray[np.float64], rounding: float, least_variance: float = 0.0) -> float:
    """What a mean over the paper's episodes may differ by from one over as many others, by scores [S, E]."""
    variance = max(float(own.var(axis=1, ddof=1).mean()), least_variance)
    return rounding + DISFAVOURED_Z * float(np.sqrt(variance * 2.0 / TEST_EPISODES))


def _variance_of_success(percent: float, num_uavs: int) -> float:
    """Variance of an episode's success in percent, if each of its UAVs arrives with that chance for itself."""
    return percent * (100.0 - percent) / num_uavs


@claim(
    place=660,
    section="V-B, Table II",
    text="T̄ is the average completion time, and Random's is 100.0 slots at 22.4 % success.",
    measure="mean of T over the UAVs of Random, T_max for those that fail; and what those that arrive need to take for "
    "the printed time; by Student's test over seeds against the printed time, less what rounding took",
)
def average_completion(evidence: Evidence) -> Finding:
    """Whether the time printed for Random can be the mean of T_i over the UAVs, or lies above all that it can be."""
    printed = printed_row(evidence, "random")
    last = known(mean_interval(evidence.scores("random", "makespan_slots").mean(axis=1)))
    least = printed.makespan_slots - ROUNDING.makespan_slots
    mean = held_to(evidence, "slots", "random", evidence.scores("random", "slots").mean(axis=1), least)
    reached = mean.reaches()
    # With the share p arriving, the mean is (1 - p) T_max + p T.
    game, share = evidence.results.recipe.game(), printed.success_percent / 100.0
    arrived = evidence.results.episodes
    arrived = arrived[(arrived["method"] == evidence.key("random")) & arrived["arrived"]]
    needed = game.max_slots - (game.max_slots - least) / share
    own = f", and take {arrived['slots'].mean():.1f}" if len(arrived) else ""
    verdicts: dict[Condition, Verdict] = {
        "holds": "reproduced", "fails": "impossible as printed", "open": "not shown"
    }  # fmt: skip
    return Finding(
        verdicts[reached],
        f"{evidence.label('random')}: T {mean.text(1)} slots on average over the UAVs, {last.text(1)} until the last "
        f"of an episode is done (paper: T̄ {printed.makespan_slots:.1f} at {printed.success_percent:g} % success); "
        f"those that arrive would have to take {needed:.1f} slots on average{own}",
        "UAVs that arrive before the deadline bring the mean over UAVs below the printed time. Read as the slots until "
        "the last UAV is done, as T̄ is here, it is possible."
        if reached == "fails"
        else f"The mean over UAVs {'does' if reached == 'holds' else 'may'} not lie below the printed time.",
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
    measure="width of the 95 % interval (Student's t) of its success over seeds; five points count; a player that does "
    "not learn has no curve",
    owed_to="by construction",
)
def random_flat(evidence: Evidence) -> Finding:
    """Whether Random, which does not learn and so has no learning curve, gets much the same with every seed.

    Seeds that get this and that leave open what it gets: they cannot show a curve where there is none.
    """
    within = 5.0
    symbol, unit, decimals = in_words("success_percent")
    found = known(mean_t(evidence.scores("random", "success_percent").mean(axis=1)))
    width = found.high - found.low
    return Finding(
        combine(["holds" if width < within else "open"]),
        f"{evidence.label('random')}: {symbol} {found.text(decimals)}",
        "A player that does not learn has no curve: the interval over its seeds has to be narrower than "
        f"{within:g}{unit}, and is {width:.1f} wide.",
    )


@claim(
    place=610,
    section="V-B",
    text="The task requires deliberate congestion-aware coordination rather than unstructured exploration.",
    measure="success of UAVs that fly straight, blind to all others: a task that requires coordination is one that "
    "they do not always master",
    headline=True,
)
def needs_coordination(evidence: Evidence) -> Finding:
    """Whether UAVs that know nothing of each other fail in some mission."""
    flown = evidence.scores("straight", "success_percent")
    failed = int((flown < 100.0).sum())
    return Finding(
        combine([holds_if(failed > 0)]),
        f"{evidence.label('straight')}: success {flown.mean():.1f} %, {failed:,} of {flown.size:,} missions failed",
        f"Some mission has to be failed: {'one is' if failed == 1 else f'{failed:,} are' if failed else 'none is'}.",
    )


@claim(
    place=680,
    section="V-B, Table II",
    text="CTDE-MAPPO achieves a perfect success rate.",
    measure="success of the trained players on the test missions; by Student's test over seeds against 100 %, less "
    "what rounding takes",
    headline=True,
)
def perfect_success(evidence: Evidence) -> Finding:
    """Whether success is 100 % at the precision of print; seeds that all have it leave a test nothing to say."""
    perfect, least = 100.0, 100.0 - ROUNDING.success_percent
    symbol, _, decimals = in_words("success_percent")
    figures: list[str] = []
    held: list[Condition] = []
    untested = 0
    for role in FORMS:
        own = evidence.scores(role, "success_percent").mean(axis=1)
        found = held_to(evidence, "success_percent", role, own, least)
        figures.append(f"{evidence.label(role)}: {symbol} {found.text(decimals)}")
        held.append(found.reaches())
        if (own == perfect).all():
            untested = max(untested, len(own))
    why = f"Rounded to one decimal the mean has to reach {perfect:g}: {counted(held)}."
    if untested:
        # Should a larger share of trainings fall short, all of these would reach it in less than one case of twenty.
        short = 100.0 * (1.0 - LEVEL ** (1.0 / untested))
        why += f" Where no seed falls short there is no spread to test: of other seeds up to {short:.0f} % still may."
    return Finding(combine(*([each] for each in held)), "; ".join(figures), why)
