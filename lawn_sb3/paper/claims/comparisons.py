"""Claims that hold one method's final figures to another's."""

from lawn_sb3.paper.claims.claim import Condition, Finding, Verdict, claim, shared_rule
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import (
    against_all,
    at_least,
    combine,
    counted,
    difference,
    in_words,
    join,
    known,
    printed_difference,
    seed_means,
)
from lawn_sb3.paper.roles import FORMS
from lawn_sb3.results.statistics import Interval, welch_difference

SMALL = 0.1
"""A difference below this share of the paper's has the right sign but not the size."""


@shared_rule
def better_than(
    evidence: Evidence, quantity: str, of: list[str], over: list[str], lower: bool = False, sizeable: bool = False
) -> Finding:
    """Whether a method beats all others in a figure, on the same missions.

    :param quantity: the figure
    :param of: the parts of the method's forms; of several each has to
    :param over: the parts it is said to beat
    :param lower: less is better
    :param sizeable: leads below a tenth of the paper's make it partly
    """
    symbol, unit, decimals = in_words(quantity)
    sign = -1.0 if lower else 1.0
    figures, small, notes = [], [], []
    best: list[Condition] = []
    for role in of:
        label, parts = evidence.label(role), []
        leads: list[Condition] = []
        for other in over:
            rival, found = evidence.label(other), difference(evidence, quantity, role, other)
            parts.append(f"{found.text(decimals)}{unit} against {rival}")
            leads.append(found.above_0(sign))
            if leads[-1] != "holds":
                notes.append(f"{label} {found.word(sign)} {rival}")
            printed = printed_difference(evidence, quantity, role, other) if sizeable else None
            if leads[-1] == "holds" and printed is not None and sign * found.interval.value < SMALL * sign * printed:
                small.append(f"{label} over {rival} (paper {printed:+.{decimals}f})")
        figures.append(f"{label}: {symbol} {', '.join(parts)}")
        best.append(against_all(leads))
    if small:
        notes.append(f"the lead is below a tenth of the paper's for {join(small)}")
    verdict = combine(*([form] for form in best))
    why = "; ".join(["Every difference has to lie on the claimed side of 0", *notes]) + (
        "." if notes else ", and does."
    )
    return Finding("partly" if small and verdict == "reproduced" else verdict, "; ".join(figures), why)


@claim(
    place=700,
    section="V-B, Table II",
    text="Its corrected rate is comparable to QMIX's, so that efficient navigation does not sacrifice communication.",
    measure="difference in R̂, its 95 % interval within the paper's own difference",
)
def rate_comparable(evidence: Evidence) -> Finding:
    """Whether the rates differ by no more than they do in the paper."""
    symbol, unit, decimals = in_words("rate_mbps")
    rival, margin = evidence.label("qmix"), 0.0
    figures: list[str] = []
    within: list[Condition] = []
    for role in FORMS:
        printed = printed_difference(evidence, "rate_mbps", role, "qmix")
        if printed is None:
            raise CannotTellError("needs methods that have a row in the paper's Table II")
        margin = abs(printed)
        found = _difference(evidence, "rate_mbps", role, "qmix")
        figures.append(f"{evidence.label(role)}: {symbol} {found.text(decimals)}{unit} against {rival}")
        within.append(against_all([at_least(found, -margin), at_least(_negative(found), -margin)]))
    return Finding(
        combine(*([form] for form in within)),
        "; ".join(figures),
        f"The paper calls a difference of {margin:.{decimals}f}{unit} comparable, and "
        f"every interval has to lie within it: {counted(within)}.",
    )


@claim(
    place=360,
    section="I, III-B",
    text="The cell loads are the congestion sufficient statistic: they say all about the others that is of use.",
    measure="mean utility of a learner, in time and undiscounted, that is told how many head for each cell, less that "
    "of the same learner which sees the loads alone; it must not lie above 0",
    needs="ladder",
)
def loads_suffice(evidence: Evidence) -> Finding:
    """Whether being told more than the loads is of no use; how much the loads are worth is told beside."""
    symbol, unit, decimals = in_words("utility_mbps")
    more = difference(evidence, "utility_mbps", "knows-destinations", "knows-loads")
    use = _difference(evidence, "utility_mbps", "knows-loads", "knows-nothing")
    nothing, loads, destinations = map(evidence.label, ("knows-nothing", "knows-loads", "knows-destinations"))
    outcomes: dict[Condition, tuple[Verdict, str]] = {
        "holds": ("contradicted", "it is: what suffices leaves nothing to gain"),
        "open": ("not shown", "these seeds cannot tell whether it is"),
        "fails": ("reproduced", "it is not"),
    }
    verdict, word = outcomes[more.above_0()]
    return Finding(
        verdict,
        f"{destinations}: {symbol} {more.text(decimals)}{unit} against {loads}; "
        f"{loads}: {use.text(decimals)}{unit} against {nothing}",
        f"Being told more must not be of more use; {word}.",
    )


@claim(
    place=440,
    headline=True,
    section="IV-B",
    text="The congestion makes the joint value function non-decomposable, ruling out value decomposition as in QMIX.",
    measure="difference in J̄ between CTDE-MAPPO and QMIX: ruled out is a method that is behind by no less than in the "
    "paper, with its whole 95 % interval",
)
def value_decomposition(evidence: Evidence) -> Finding:
    """Whether QMIX is so far behind as to be ruled out; not if the whole interval lies below the paper's lead."""
    symbol, unit, decimals = in_words("reward")
    rival, printed = evidence.label("qmix"), 0.0
    figures: list[str] = []
    far: list[Condition] = []
    for role in FORMS:
        lead = printed_difference(evidence, "reward", role, "qmix")
        if lead is None:
            raise CannotTellError("needs methods that have a row in the paper's Table II")
        printed = lead
        found = _difference(evidence, "reward", role, "qmix")
        figures.append(f"{evidence.label(role)}: {symbol} {found.text(decimals)}{unit} against {rival}")
        far.append(at_least(found, printed))
    success = evidence.scores("qmix", "success_percent").mean()
    return Finding(
        combine(*([form] for form in far)),
        f"{'; '.join(figures)} (paper {printed:+.2f}); success of {rival} {success:.1f} %",
        f"{rival} has to be behind by {printed:.2f} at least: {counted(far)}.",
    )


@claim(
    place=705,
    section="V-B",
    text="QMIX's lower reward reflects the expressivity limitation of its monotone mixer.",
    measure="difference in J̄ between CTDE-MAPPO and QMIX, and between QMIX and the additive mixer, which can express "
    "less still: if expressivity is what limits, each has to lie above 0",
    needs="ablation",
)
def mixer_limits(evidence: Evidence) -> Finding:
    """Whether QMIX is behind, and a mixer that can express less is further behind."""
    symbol, unit, decimals = in_words("reward")
    pairs = [*((role, "qmix") for role in FORMS), ("qmix", "qmix-additive")]
    found = [difference(evidence, "reward", *pair) for pair in pairs]
    held = [each.above_0() for each in found]
    figures = [
        f"{evidence.label(role)}: {symbol} {each.text(decimals)}{unit} against {evidence.label(other)}"
        for (role, other), each in zip(pairs, found, strict=True)
    ]
    # Each form of CTDE-MAPPO together with the mixers.
    return Finding(
        combine(*([lead, held[-1]] for lead in held[:-1])),
        "; ".join(figures),
        f"Each difference has to lie above 0: {counted(held)}.",
    )


def _difference(evidence: Evidence, quantity: str, role: str, other: str) -> Interval:
    """A difference that no verdict needs apart from 0, so that it is not among the tests."""
    return known(welch_difference(*seed_means(evidence, quantity, role, other)))


def _negative(found: Interval) -> Interval:
    return Interval(-found.value, -found.high, -found.low)
