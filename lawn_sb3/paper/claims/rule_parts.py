"""What rules share: tests of differences and figures, the verdict on several conditions, and words for the reason."""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.paper.claims.claim import Condition, Verdict
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.printed_values import TABLE_II, PaperRow
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.statistics import (
    Interval,
    Tested,
    crossed_t,
    mean_interval,
    mean_t,
    paired_p,
    paired_t,
    welch_difference,
    welch_p,
)

TINY = 1e-9
"""Files keep nine digits: a smaller difference is none."""


class Difference(NamedTuple):
    """A difference of two methods, or a figure of one, that a claim needs to lie on one side of a level."""

    interval: Interval
    """The 95 % t interval."""
    apart: bool
    """Whether it is significantly other than the level, among all that the claims test."""
    side: float
    """On which side of the level it lies: 1 above, -1 below, 0 if in every seed and mission just there."""

    def above(self, sign: float = 1.0) -> Condition:
        """Whether it lies above the level, or with the sign -1 below: open if these seeds cannot tell.

        It fails if it lies on the other side. Just there in every seed and mission is open too: of methods that are
        level, as at 100 % success, these flights do not say which leads.
        """
        if not self.apart or self.side == 0.0:
            return "open"
        return "holds" if sign * self.side > 0.0 else "fails"

    def reaches(self, sign: float = 1.0) -> Condition:
        """The same, but that it holds too if in every seed just there."""
        return "holds" if self.apart and self.side == 0.0 else self.above(sign)

    def word(self, sign: float = 1.0) -> str:
        """What one method does beside the other, such as ``does worse than``; with the sign -1 less is better."""
        if self.apart and self.side == 0.0:
            return "is level with"
        return {"holds": "does better than", "fails": "does worse than", "open": "cannot be told from"}[
            self.above(sign)
        ]

    def text(self, decimals: int) -> str:
        """The interval for a sentence."""
        return self.interval.text(decimals)


def join(parts: Sequence[str]) -> str:
    """Words as a list: ``a, b and c``."""
    return " and ".join(filter(None, [", ".join(parts[:-1]), parts[-1]]))


def sentence(text: str) -> str:
    """A text with a capital in front and a full stop."""
    return f"{text[0].upper()}{text[1:]}."


def counted(conditions: Sequence[Condition]) -> str:
    """How many of several conditions hold, and how many are open, such as ``1 of 3 does, 1 cannot be told``."""
    held, unsure = conditions.count("holds"), conditions.count("open")
    does = "does" if held == 1 else "do"
    return f"{held} of {len(conditions)} {does}" + (f", {unsure} cannot be told" if unsure else "")


def holds_if(truth: bool) -> Condition:
    """A condition that the data always decide."""
    return "holds" if truth else "fails"


def against_all(conditions: Sequence[Condition]) -> Condition:
    """Whether something holds against every rival: it fails with the first that it fails against."""
    if "fails" in conditions:
        return "fails"
    return "holds" if all(each == "holds" for each in conditions) else "open"


def combine(*forms: Iterable[Condition]) -> Verdict:
    """The verdict on the conditions of a claim.

    All hold: reproduced; some: partly. None holds, and in every form something fails: contradicted. Otherwise the data
    cannot tell: not shown.

    :param forms: the conditions of each form of the method that the claim is about, or of the claim as a whole
    """
    listed = [list(form) for form in forms]
    every = [condition for form in listed for condition in form]
    if all(condition == "holds" for condition in every):
        return "reproduced"
    if "holds" in every:
        return "partly"
    return "contradicted" if all("fails" in form for form in listed) else "not shown"


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


def flown_scores(evidence: Evidence, quantity: str, role: str, other: str) -> tuple[NDArray[np.float64], ...]:
    """One of ``QUANTITIES`` of two parts by seed and mission, [S1, E] and [S2, E], on the same missions.

    :raises CannotTellError: if they flew different numbers of missions
    """
    own, others = (evidence.scores(part, quantity) for part in (role, other))
    if own.shape[1] != others.shape[1]:
        raise CannotTellError(f"needs {evidence.label(role)} and {evidence.label(other)} on the same missions")
    return own, others


def difference(evidence: Evidence, quantity: str, role: str, other: str, level: float = 0.0) -> Difference:
    """How much more of one of ``QUANTITIES`` one part gets than another, of seeds and missions that might be others.

    :param level: what it is held to
    :raises CannotTellError: if one of them has a single seed, or they flew different numbers of missions
    """
    own, others = flown_scores(evidence, quantity, role, other)
    found, beyond = crossed_t(own, others), crossed_t(own - level, others)
    return _counted(evidence, quantity, role, other, known(found.interval), beyond, level)


def equivalence(
    evidence: Evidence, quantity: str, role: str, other: str, margin: float
) -> tuple[Condition, Difference]:
    """Whether two parts get the same of one of ``QUANTITIES``, but for a margin, by two one-sided tests (TOST).

    That no difference is found shows nothing; this shows that there is none beyond the margin. Each bound is tested for
    itself, on either side, so that the same tests can show that the difference lies beyond.

    :param margin: what a difference may amount to on either side
    :return: whether it lies within, and the difference as it is held to the upper bound
    :raises CannotTellError: if one of them has a single seed, or they flew different numbers of missions
    """
    low, high = (difference(evidence, quantity, role, other, level) for level in (-margin, margin))
    return against_all([low.reaches(), high.reaches(-1.0)]), high


def printed_difference(evidence: Evidence, quantity: str, role: str, other: str) -> float | None:
    """The same difference in the paper's Table II; None if a method has no row, or the table no such column."""
    rows = [evidence.method(part).paper_row for part in (role, other)]
    if None in rows or quantity not in PaperRow._fields:
        return None
    own, others = (float(getattr(TABLE_II[str(row)], quantity)) for row in rows)
    return own - others


def seed_difference(
    evidence: Evidence,
    figure: str,
    role: str,
    other: str,
    own: NDArray[np.float64],
    others: NDArray[np.float64],
    level: float = 0.0,
) -> Difference:
    """Difference of two means over seeds, by Welch's interval: seeds of two methods are no pairs.

    It is one of the differences that the claims test, and counted once, however many of them do.

    :param evidence: keeps count
    :param figure: what differs
    :param role: the one part
    :param other: the other
    :param own: the figure of the one, by seed [S1]
    :param others: the same of the other [S2]
    :param level: what the difference is held to
    :raises CannotTellError: if one of them has a single seed
    """
    beyond = own - level
    tested = Tested(welch_difference(beyond, others), welch_p(beyond, others))
    return _counted(evidence, figure, role, other, known(welch_difference(own, others)), tested, level)


def _counted(
    evidence: Evidence, figure: str, role: str, other: str, interval: Interval, beyond: Tested, level: float
) -> Difference:
    """A difference with its interval and what it is beyond its level, as one of the differences that claims test."""
    first, second = sorted((role, other))
    tested = (figure, first, second, f"{level if role == first else -level:z.9g}")
    return Difference(interval, evidence.tests.is_apart(tested, beyond.p_value), float(np.sign(beyond.interval.value)))


def held_to(evidence: Evidence, figure: str, role: str, own: NDArray[np.float64], level: float) -> Difference:
    """A figure of one part beside a level, by Student's t test over seeds, counted as differences are.

    :param evidence: keeps count
    :param figure: what it is called among the tests
    :param role: the part
    :param own: the figure, by seed [S]
    :param level: what it is held to
    :raises CannotTellError: if there is a single seed
    """
    interval, there = known(mean_t(own)), np.full_like(own, level)
    apart = evidence.tests.is_apart((figure, role, f"{level:z.9g}"), paired_p(own, there))
    return Difference(interval, apart, float(np.sign(paired_t(own, there).value)))


def higher(
    evidence: Evidence,
    figure: str,
    values: Mapping[str, NDArray[np.float64]],
    of: Sequence[str],
    unit: str,
    decimals: int,
) -> tuple[Verdict, str, str]:
    """Whether a figure is higher for some parts than for each of the others: pairs of them are the forms of the claim.

    :param evidence: what the runs left
    :param figure: what it is called among the differences that the claims test
    :param values: the figure by part, one value per seed
    :param of: the parts said to have more than the rest
    :param unit: of the figure, with a space in front
    :param decimals: its digits
    :return: the verdict, the figure of every part, and the reason
    :raises CannotTellError: if a part has a single seed
    """
    than = [role for role in values if role not in of]
    found = [
        seed_difference(evidence, figure, role, other, values[role], values[other]) for role in of for other in than
    ]
    conditions = [each.above() for each in found]
    shown = [f"{evidence.label(role)}: {mean_interval(own).text(decimals)}{unit}" for role, own in values.items()]
    differences = ", ".join(each.text(decimals) for each in found)
    why = f"Each difference ({differences}) has to lie above 0: {counted(conditions)}."
    return combine(*([condition] for condition in conditions)), "; ".join(shown), why
