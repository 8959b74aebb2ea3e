"""From claims to verdicts: apply each claim's rule, and say so where the evidence is missing."""

from collections.abc import Sequence

from lawn_sb3.errors import UserError
from lawn_sb3.paper.claims.claim import Claim, Finding, Judged
from lawn_sb3.paper.claims.evidence import CannotTellError, Evidence
from lawn_sb3.paper.claims.rule_parts import sentence


def judge(claim: Claim, evidence: Evidence) -> Finding:
    """Hold one claim to the evidence; it is ``not testable`` where that is missing."""
    try:
        return claim.rule(evidence)
    except (CannotTellError, UserError) as error:  # the latter from runs that do not fit together
        elsewhere = f"; it is judged in the report of runs/{claim.needs}.yaml" if claim.needs is not None else ""
        return Finding("not testable", "", sentence(f"{error}{elsewhere}"))


def judge_all(claims: Sequence[Claim], evidence: Evidence) -> list[Judged]:
    """Hold all claims to the evidence, in order."""
    return [Judged(claim, judge(claim, evidence)) for claim in claims]
