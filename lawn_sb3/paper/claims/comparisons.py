"""Claims that hold one method's final figures to another's."""

from lawn_sb3.game.radio import rate_unit_mbps
from lawn_sb3.paper.claims.claim import Condition, Finding, Verdict, claim, shared_rule
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import (
    against_all,
    combine,
    counted,
    difference,
    equivalence,
    flown_scores,
    held_to,
    in_words,
    join,
    known,
    printed_difference,
)
from lawn_sb3.paper.roles import FORMS
from lawn_sb3.results.statistics import crossed_t
from lawn_sb3.scenario import PRESETS

SMALL = 0.1
"""A difference below this share of the paper's has the right sign but not the size."""
PUNCTUAL = 0.9
"""Least mean T_min/T of UAVs that are said to be efficient in time."""
RB_MBPS = rate_unit_mbps(PRESETS["paper"]) / float(PRESETS["paper"].num_rbs.max())
"""What an RB gives one voxel from its GBS. RBs are whole, so no entry into a cell that costs at all costs less."""


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
            leads.append(found.above(sign))
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
    place=675,
    section="V-B",
    text="CTDE-MAPPO's high J̄ reflects simultaneous achievement of both factors of the payoff.",
    measure="the factor of time, T_min/T, mean over the UAVs, which has to reach nine tenths; the factor of rate, R̂, "
    "which has to lie above that of UAVs which fly straight and heed nobody. Their J̄ is told beside",
)
def both_factors(evidence: Evidence) -> Finding:
    """Whether CTDE-MAPPO achieves both factors of the utility, Eq. (9), eq:utility, and not one alone."""
    symbol, unit, decimals = in_words("rate_mbps")
    straight = evidence.label("straight")
    figures, forms = [], []
    for role in FORMS:
        least, taken = (evidence.results.scores(evidence.key(role), name, per="uav") for name in ("min_slots", "slots"))
        time = held_to(evidence, "T_min/T", role, (least / taken).mean(axis=(1, 2)), PUNCTUAL)
        rate = difference(evidence, "rate_mbps", role, "straight")
        figures.append(
            f"{evidence.label(role)}: T_min/T {time.text(3)}, {symbol} {rate.text(decimals)}{unit} against {straight}"
        )
        forms.append([time.reaches(), rate.above()])
    reward = float(evidence.scores("straight", "reward").mean())
    return Finding(
        combine(*forms),
        f"{'; '.join(figures)}, whose J̄ is {reward:.2f}",
        "T_min/T has to reach nine tenths, and R̂ to lie above what comes by itself: "
        f"{counted([condition for form in forms for condition in form])}.",
    )


@claim(
    place=700,
    section="V-B, Table II",
    text="Its corrected rate is comparable to QMIX's, so that efficient navigation does not sacrifice communication.",
    measure="difference in R̂, which has to lie within the paper's own difference on either side: a t test against each "
    "of these bounds",
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
        same, found = equivalence(evidence, "rate_mbps", role, "qmix", margin)
        figures.append(f"{evidence.label(role)}: {symbol} {found.text(decimals)}{unit} against {rival}")
        within.append(same)
    return Finding(
        combine(*([form] for form in within)),
        "; ".join(figures),
        f"The paper calls a difference of {margin:.{decimals}f}{unit} comparable, and "
        f"every difference has to lie within it: {counted(within)}.",
    )


@claim(
    place=360,
    section="I, III-B",
    text="The cell loads are the congestion sufficient statistic: they say all about the others that is of use.",
    measure="mean utility of a learner, in time and undiscounted, that is told how many head for each cell, less that "
    "of the same learner which sees the loads alone. What the loads are to tell is how the rate falls on entering a "
    f"cell, by no less than one RB, {RB_MBPS:.1f} Mbps near its GBS: it has to lie within a tenth of that, "
    f"{SMALL * RB_MBPS:.2f} Mbps on either side, and contradicts if above",
    needs="ladder",
)
def loads_suffice(evidence: Evidence) -> Finding:
    """Whether being told more than the loads is of no use; how much the loads are worth is told beside.

    Less than without being told shows a learner that makes nothing of what it is told, and says nothing of the loads.
    """
    symbol, unit, decimals = in_words("utility_mbps")
    same, more = equivalence(evidence, "utility_mbps", "knows-destinations", "knows-loads", SMALL * RB_MBPS)
    use = known(crossed_t(*flown_scores(evidence, "utility_mbps", "knows-loads", "knows-nothing")).interval)
    nothing, loads, destinations = map(evidence.label, ("knows-nothing", "knows-loads", "knows-destinations"))
    verdict: Verdict = "reproduced" if same == "holds" else "contradicted" if more.above() == "holds" else "not shown"
    words: dict[Verdict, str] = {
        "reproduced": "it is not",
        "contradicted": "it is: what suffices leaves nothing to gain",
        "not shown": "whether it is, these runs cannot tell",
    }
    return Finding(
        verdict,
        f"{destinations}: {symbol} {more.text(decimals)}{unit} against {loads}; "
        f"{loads}: {use.text(decimals)}{unit} against {nothing}",
        f"Being told more must not be of {SMALL * RB_MBPS:.2f}{unit} more use; {words[verdict]}.",
    )


@claim(
    place=440,
    headline=True,
    section="IV-B",
    text="The congestion, which makes the joint value function non-decomposable, rules out value decomposition as in "
    "QMIX.",
    measure="difference in J̄ between CTDE-MAPPO and QMIX: ruled out is a method that is behind by no less than in the "
    "paper, by a t test against that; whether the value function is decomposable is not tested",
)
def value_decomposition(evidence: Evidence) -> Finding:
    """Whether QMIX is so far behind as to be ruled out; not if it is behind by less than in the paper."""
    symbol, unit, decimals = in_words("reward")
    rival, printed = evidence.label("qmix"), 0.0
    figures: list[str] = []
    far: list[Condition] = []
    for role in FORMS:
        lead = printed_difference(evidence, "reward", role, "qmix")
        if lead is None:
            raise CannotTellError("needs methods that have a row in the paper's Table II")
        printed = lead
        found = difference(evidence, "reward", role, "qmix", printed)
        figures.append(f"{evidence.label(role)}: {symbol} {found.text(decimals)}{unit} against {rival}")
        far.append(found.reaches())
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
    held = [each.above() for each in found]
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
