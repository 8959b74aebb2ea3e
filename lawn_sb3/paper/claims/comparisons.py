"""Claims that hold one method's final figures to another's."""

from lawn_sb3.paper.claims.claim import Finding, claim, shared_rule
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import (
    combine,
    counted,
    difference,
    in_words,
    is_positive,
    join,
    printed_difference,
)
from lawn_sb3.paper.roles import FORMS

SMALL = 0.1
"""A difference below this share of the paper's has the right sign but not the size."""


@shared_rule
def better_than(
    evidence: Evidence, quantity: str, of: list[str], over: list[str], lower: bool = False, sizeable: bool = False
) -> Finding:
    """Whether a method beats all others in a figure, on the same missions, by intervals apart from 0.

    :param quantity: the figure
    :param of: the parts of the method's forms; of several each has to
    :param over: the parts it is said to beat
    :param lower: less is better
    :param sizeable: leads below a tenth of the paper's make it partly
    """
    symbol, unit, decimals = in_words(quantity)
    sign = -1.0 if lower else 1.0
    figures, best, small, notes = [], [], [], []
    for role in of:
        label, leads, parts = evidence.label(role), [], []
        for other in over:
            rival, found = evidence.label(other), difference(evidence, quantity, role, other)
            parts.append(f"{found.text(decimals)}{unit} against {rival}")
            least, most = sorted((sign * found.low, sign * found.high))
            leads.append(is_positive(least))
            if not leads[-1]:
                notes.append(f"{label} {'does worse than' if is_positive(-most) else 'cannot be told from'} {rival}")
            printed = printed_difference(evidence, quantity, role, other) if sizeable else None
            if leads[-1] and printed is not None and sign * found.value < SMALL * sign * printed:
                small.append(f"{label} over {rival} (paper {printed:+.{decimals}f})")
        figures.append(f"{label}: {symbol} {', '.join(parts)}")
        best.append(all(leads))
    if small:
        notes.append(f"the lead is below a tenth of the paper's for {join(small)}")
    why = "; ".join(["Every interval has to lie on the claimed side of 0", *notes]) + ("." if notes else ", and does.")
    return Finding("partly" if small and all(best) else combine(best), "; ".join(figures), why)


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
    figures, within = [], []
    for role in FORMS:
        printed = printed_difference(evidence, "rate_mbps", role, "qmix")
        if printed is None:
            raise CannotTellError("needs methods that have a row in the paper's Table II")
        margin = abs(printed)
        found = difference(evidence, "rate_mbps", role, "qmix")
        figures.append(f"{evidence.label(role)}: {symbol} {found.text(decimals)}{unit} against {rival}")
        within.append(max(abs(found.low), abs(found.high)) <= margin)
    return Finding(
        combine(within),
        "; ".join(figures),
        f"The paper calls a difference of {margin:.{decimals}f}{unit} comparable, and "
        f"every interval has to lie within it: {counted(within)}.",
    )


@claim(
    place=360,
    section="I, III-B",
    text="The cell loads are the congestion sufficient statistic.",
    measure="mean utility with the loads, in time and undiscounted, less that of the same learner without them, and of "
    "the same learner told how many head for each cell less that; 95 % intervals over seeds: the first has to lie "
    "above 0, and the second not",
    needs="ladder",
)
def loads_suffice(evidence: Evidence) -> Finding:
    """Whether being told the loads is of use, and being told more is not; partly if more is of more use."""
    symbol, unit, decimals = in_words("utility_mbps")
    use, more = (
        difference(evidence, "utility_mbps", role, other)
        for role, other in (("knows-loads", "knows-nothing"), ("knows-destinations", "knows-loads"))
    )
    nothing, loads, destinations = map(evidence.label, ("knows-nothing", "knows-loads", "knows-destinations"))
    held = [is_positive(use.low), not is_positive(more.low)]
    return Finding(
        combine(held),
        f"{loads}: {symbol} {use.text(decimals)}{unit} against {nothing}; "
        f"{destinations}: {more.text(decimals)}{unit} against {loads}",
        f"The first difference lies {'' if held[0] else 'not '}above 0, the second {'does not' if held[1] else 'too'}.",
    )
