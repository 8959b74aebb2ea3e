"""Claims that hold one method's final figures to another's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.paper.claims.claim import CannotTellError, Evidence, Finding, Verdict
from lawn_sb3.paper.printed_values import TABLE_II, PaperRow
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.statistics import Interval, welch_difference

TINY = 1e-9
"""Files keep nine digits: a smaller difference is none."""

SMALL = 0.1
"""A difference below this share of the paper's has the right sign but not the size."""


def join(parts: Sequence[str]) -> str:
    """Words of a list.

    :param parts: the words
    :return: ``a, b and c``
    """
    return " and ".join(filter(None, [", ".join(parts[:-1]), parts[-1]]))


def sentence(text: str) -> str:
    """A text as a sentence.

    :param text: the text
    :return: with a capital in front and a full stop
    """
    return f"{text[0].upper()}{text[1:]}."


def counted(conditions: Sequence[bool]) -> str:
    """How many of several conditions hold.

    :param conditions: which of them hold
    :return: such as ``1 of 2 do``
    """
    return f"{sum(conditions)} of {len(conditions)} {'does' if len(conditions) == 1 else 'do'}"


def combine(conditions: Sequence[bool]) -> Verdict:
    """The verdict on several conditions.

    :param conditions: which of them hold
    :return: all, some or none
    """
    if all(conditions):
        return "reproduced"
    return "partly" if any(conditions) else "not reproduced"


def is_positive(value: float) -> bool:
    """Whether a difference, or a bound of one, lies above 0 by more than rounding.

    :param value: the difference
    :return: true if it does
    """
    return bool(value > TINY)


def known(interval: Interval) -> Interval:
    """An interval that a verdict may rest on.

    :param interval: the interval
    :return: the same
    :raises CannotTellError: if its bounds are unknown, as one seed leaves them
    """
    if not interval.is_known:
        raise CannotTellError("needs at least two seeds of each method, for an interval")
    return interval


def in_words(quantity: str) -> tuple[str, str, int]:
    """What sentences call a quantity, the unit of its differences with a space in front, and their digits."""
    chosen = QUANTITIES[quantity]
    return chosen.words, chosen.difference_unit, chosen.fine_decimals


def difference(evidence: Evidence, quantity: str, role: str, other: str) -> Interval:
    """How much more of a figure one part gets than another, on the same missions.

    :param evidence: what the runs left
    :param quantity: a key of ``QUANTITIES``
    :param role: the part
    :param other: the other part
    :return: the mean difference and Welch's interval over seeds
    :raises CannotTellError: if one of them has a single seed, or they flew different numbers of missions
    """
    own, others = (evidence.scores(part, quantity) for part in (role, other))
    if own.shape[1] != others.shape[1]:
        raise CannotTellError(f"needs {evidence.label(role)} and {evidence.label(other)} on the same missions")
    return seed_difference(own.mean(axis=1), others.mean(axis=1))


def seed_difference(own: NDArray[np.float64], others: NDArray[np.float64]) -> Interval:
    """Difference of two means over seeds; seeds of two methods are no pairs, and need not be as many.

    :param own: one figure a seed [S1]
    :param others: the same of another method [S2]
    :return: the difference and Welch's interval
    :raises CannotTellError: if one of them has a single seed
    """
    return known(welch_difference(own, others))


def higher(
    values: Mapping[str, NDArray[np.float64]], of: Sequence[str], than: Sequence[str], decimals: int
) -> tuple[Verdict, str]:
    """Whether a figure is higher for some parts than for each of the others.

    :param values: the figure by part, one value a seed
    :param of: the parts said to have more
    :param than: the others
    :param decimals: digits of the differences
    :return: the verdict and its reason
    :raises CannotTellError: if a part has a single seed
    """
    found = [seed_difference(values[role], values[other]) for role in of for other in than]
    held = [is_positive(each.low) for each in found]
    shown = ", ".join(each.text(decimals) for each in found)
    return combine(held), f"Each difference ({shown}) has to lie above 0 with its whole interval: {counted(held)}."


def better_than(
    evidence: Evidence, quantity: str, of: list[str], over: list[str], lower: bool = False, sizeable: bool = False
) -> Finding:
    """Whether a method beats all others in a figure, on the same missions, by intervals apart from 0.

    :param evidence: what the runs left
    :param quantity: the figure
    :param of: the parts of the method's forms; of several each has to
    :param over: the parts it is said to beat
    :param lower: less is better
    :param sizeable: leads below a tenth of the paper's make it partly
    :return: the finding
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


def printed_difference(evidence: Evidence, quantity: str, role: str, other: str) -> float | None:
    """The difference of two methods in the paper's Table II.

    :param evidence: what the runs left
    :param quantity: a key of ``QUANTITIES``
    :param role: the part
    :param other: the other part
    :return: the difference; None if a method has no row, or the table no such column
    """
    rows = [evidence.method(part).paper_row for part in (role, other)]
    if None in rows or quantity not in PaperRow._fields:
        return None
    own, others = (float(getattr(TABLE_II[str(row)], quantity)) for row in rows)
    return own - others


def comparable(evidence: Evidence, quantity: str, of: list[str], to: str) -> Finding:
    """Whether a figure of two methods differs by no more than it does in the paper.

    :param evidence: what the runs left
    :param quantity: the figure
    :param of: the parts of the method's forms
    :param to: the other part
    :return: the finding
    """
    symbol, unit, decimals = in_words(quantity)
    figures, within = [], []
    margin = 0.0
    for role in of:
        printed = printed_difference(evidence, quantity, role, to)
        if printed is None:
            raise CannotTellError("needs methods that have a row in the paper's Table II")
        margin = abs(printed)
        found = difference(evidence, quantity, role, to)
        figures.append(f"{evidence.label(role)}: {symbol} {found.text(decimals)}{unit} against {evidence.label(to)}")
        within.append(max(abs(found.low), abs(found.high)) <= margin)
    return Finding(
        combine(within),
        "; ".join(figures),
        f"The paper calls a difference of {margin:.{decimals}f}{unit} comparable, and "
        f"every interval has to lie within it: {counted(within)}.",
    )


def suffices(evidence: Evidence, quantity: str, of: str, without: str, told: str) -> Finding:
    """Whether what a method sees is of use, and being told more is not.

    :param evidence: what the runs left
    :param quantity: the figure
    :param of: the part that sees what is said to suffice
    :param without: the same without it
    :param told: the same, told more
    :return: the finding; partly if it is of use, but more is of more use
    """
    symbol, unit, decimals = in_words(quantity)
    use, more = difference(evidence, quantity, of, without), difference(evidence, quantity, told, of)
    held = [is_positive(use.low), not is_positive(more.low)]
    figure = (
        f"{evidence.label(of)}: {symbol} {use.text(decimals)}{unit} against {evidence.label(without)}; "
        f"{evidence.label(told)}: {more.text(decimals)}{unit} against {evidence.label(of)}"
    )
    why = (
        f"The first difference lies {'' if held[0] else 'not '}above 0, the second {'does not' if held[1] else 'too'}."
    )
    return Finding(combine(held), figure, why)
