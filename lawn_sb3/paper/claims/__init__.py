"""What the paper claims, and what the runs say about it.

Here are its checkable statements: what it says of its model, its payoff and its method (Sections I to IV), and of its
results (Abstract, Sections V and VI).
"""

from lawn_sb3.paper.claims.claim import Claim, Finding, Judged, Verdict, load_claims
from lawn_sb3.paper.claims.evidence import Evidence
from lawn_sb3.paper.claims.judge import judge, judge_all

__all__ = ["Claim", "Evidence", "Finding", "Judged", "Verdict", "judge", "judge_all", "load_claims"]
