"""From claims to verdicts: apply each claim's rule, and say so where the evidence is missing."""

from collections.abc import Sequence

from lawn_sb3.errors import UserError
from lawn_sb3.paper.claims.claim import Claim, Finding, Judged
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import sentence


def judge(claim: Claim, evidence: Evidence) -> Finding:
    """Hold one claim to the evidence; it is ``not testable`` where that is missing."""
    tested = dict(evidence.tests.p_values)
    try:
        finding = claim.rule(evidence)
        owed = claim.owed_to if finding.verdict == "reproduced" else None
        return finding._replace(verdict=owed or finding.verdict)
    except (CannotTellError, UserError) as error:  # the latter from runs that do not fit together
        evidence.tests.p_values = tested  # a claim that is not judged raises no bar for the others
        elsewhere = f"; it is judged in the report of runs/{claim.needs}.yaml" if claim.needs is not None else ""
        return Finding("not testable", "", sentence(f"{error}{elsewhere}"))


def judge_all(claims: Sequence[Claim], evidence: Evidence) -> list[Judged]:
    """Hold all claims to the evidence, in order.

    A difference, between two methods or of a figure to a level, counts if it is significant among all that these claims
    test, by Holm's procedure: a first pass collects the tests, a second one judges.
    """
    for claim in claims:
        judge(claim, evidence)
    evidence.tests.correct()
    return [Judged(claim, judge(claim, evidence)) for claim in claims]
