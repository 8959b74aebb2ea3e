"""What rules share: differences with intervals, the verdict on several conditions, and words for the reason."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.paper.claims.claim import Verdict
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.printed_values import TABLE_II, PaperRow
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.statistics import Interval, mean_interval, welch_difference

TINY = 1e-9
"""Files keep nine digits: a smaller difference is none."""


def join(parts: Sequence[str]) -> str:
    """Words as a list: ``a, b and c``."""
    return " and ".join(filter(None, [", ".join(parts[:-1]), parts[-1]]))


def sentence(text: str) -> str:
    """A text with a capital in front and a full stop."""
    return f"{text[0].upper()}{text[1:]}."


def counted(conditions: Sequence[bool]) -> str:
    """How many of several conditions hold, such as ``1 of 2 do``."""
    return f"{sum(conditions)} of {len(conditions)} {'does' if len(conditions) == 1 else 'do'}"


def combine(conditions: Sequence[bool]) -> Verdict:
    """The verdict on several conditions: all, some or none of them hold."""
    if all(conditions):
        return "reproduced"
    return "partly" if any(conditions) else "not reproduced"


def is_positive(value: float) -> bool:
    """Whether a difference, or a bound of one, lies above 0 by more than rounding."""
    return bool(value > TINY)


def known(interval: Interval) -> Interval:
    """The same interval, if a verdict may rest on it.

    :raises CannotTellError: if its bounds are unknown, as one seed leaves them
    """
    if not interval.is_known:
        raise CannotTellError("needs at least two seeds of each method, for an interval")
    return interval


def in_words(quantity: str) -> tuple[str, str, int]:
    """What sentences call a quantity, the unit of its differences with a space in front, and their digits."""
    chosen = QUANTITIES[quantity]
    return chosen.words, chosen.difference_unit, chosen.fine_decimals


def by_seed(evidence: Evidence, role: str, quantity: str) -> Interval:
    """The mean of one of ``QUANTITIES``, with its interval over seeds."""
    return evidence.results.mean(evidence.key(role), quantity)


def difference(evidence: Evidence, quantity: str, role: str, other: str) -> Interval:
    """How much more of one of ``QUANTITIES`` one part gets than another, on the same missions, by Welch's interval.

    :raises CannotTellError: if one of them has a single seed, or they flew different numbers of missions
    """
    own, others = (evidence.scores(part, quantity) for part in (role, other))
    if own.shape[1] != others.shape[1]:
        raise CannotTellError(f"needs {evidence.label(role)} and {evidence.label(other)} on the same missions")
    return seed_difference(own.mean(axis=1), others.mean(axis=1))


def printed_difference(evidence: Evidence, quantity: str, role: str, other: str) -> float | None:
    """The same difference in the paper's Table II; None if a method has no row, or the table no such column."""
    rows = [evidence.method(part).paper_row for part in (role, other)]
    if None in rows or quantity not in PaperRow._fields:
        return None
    own, others = (float(getattr(TABLE_II[str(row)], quantity)) for row in rows)
    return own - others


def seed_difference(own: NDArray[np.float64], others: NDArray[np.float64]) -> Interval:
    """Difference of two means over seeds [S1] and [S2], by Welch's interval: seeds of two methods are no pairs.

    :raises CannotTellError: if one of them has a single seed
    """
    return known(welch_difference(own, others))


def higher(
    evidence: Evidence, values: Mapping[str, NDArray[np.float64]], of: Sequence[str], unit: str, decimals: int
) -> tuple[Verdict, str, str]:
    """Whether a figure is higher for some parts than for each of the others.

    :param evidence: what the runs left
    :param values: the figure by part, one value per seed
    :param of: the parts said to have more than the rest
    :param unit: of the figure, with a space in front
    :param decimals: its digits
    :return: the verdict, the figure of every part, and the reason
    :raises CannotTellError: if a part has a single seed
    """
    than = [role for role in values if role not in of]
    found = [seed_difference(values[role], values[other]) for role in of for other in than]
    held = [is_positive(each.low) for each in found]
    shown = [f"{evidence.label(role)}: {mean_interval(own).text(decimals)}{unit}" for role, own in values.items()]
    differences = ", ".join(each.text(decimals) for each in found)
    why = f"Each difference ({differences}) has to lie above 0 with its whole interval: {counted(held)}."
    return combine(held), "; ".join(shown), why
