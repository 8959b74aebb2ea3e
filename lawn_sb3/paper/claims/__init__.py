"""What the paper claims, and what the runs say about it."""

from lawn_sb3.paper.claims.claim import Claim, Evidence, Finding, Judged, Verdict, load_claims
from lawn_sb3.paper.claims.judge import judge, judge_all

__all__ = ["Claim", "Evidence", "Finding", "Judged", "Verdict", "judge", "judge_all", "load_claims"]
