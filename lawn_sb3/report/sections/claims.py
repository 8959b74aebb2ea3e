"""The claims table: what the paper says, what was measured, and the verdict."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import pandas as pd

from lawn_sb3.paper.claims.claim import VERDICTS, Judged
from lawn_sb3.report.table import Table

CAPTION = (
    "Every checkable claim of the paper, how it is measured, what came out, and the verdict that follows by the rule "
    "stated. Verdicts are computed from the runs, or from what the paper prints. Where CTDE-MAPPO is judged with two "
    "critics, both have to pass; partly: some of several conditions hold. In brackets 95 % intervals over seeds: of "
    "differences between two methods Welch's t intervals, of all else bootstrap intervals, which with five seeds hold "
    "the true value in about five of six cases. There are {count} claims, and verdicts are not corrected for their "
    "number. V(x), IPPO and the actor blind to the loads take the settings that were searched for V(o, x)."
)
"""To be filled with the number of claims."""


def claims_table(judged: Sequence[Judged], caption: str = CAPTION) -> Table:
    """All claims with their findings.

    :param judged: the claims and what was found
    :param caption: what to say of them, perhaps with their ``count``
    :return: one row a claim
    """
    numbers = pd.DataFrame(
        [
            {
                "id": claim.id,
                "section": claim.section,
                "claim": claim.text,
                "measure": claim.measure,
                "verdict": finding.verdict,
                "figure": finding.figure,
                "why": finding.why,
            }
            for claim, finding in judged
        ]
    )
    shown = pd.DataFrame(
        {
            "Claim": [claim.id for claim, _ in judged],
            "The paper says": [f"{claim.text} ({claim.section})" for claim, _ in judged],
            "Verdict": [finding.verdict for _, finding in judged],
            "Measured": [": ".join(filter(None, [claim.measure, finding.figure])) for claim, finding in judged],
            "Why": [finding.why for _, finding in judged],
        }
    )
    return Table(numbers, shown, caption.format(count=len(judged)))


def claims_headlines(judged: Sequence[Judged]) -> Table:
    """The claims that carry the paper.

    :param judged: the claims and what was found
    :return: one row a claim, in the order of the verdicts
    """
    chosen = [one for verdict in VERDICTS for one in judged if one.claim.headline and one.finding.verdict == verdict]
    full = claims_table(chosen)
    shown = pd.DataFrame(
        {
            "The paper says": [f"{claim.text} ({claim.section})" for claim, _ in chosen],
            "Verdict": [finding.verdict for _, finding in chosen],
            "Measured": [finding.figure for _, finding in chosen],
        }
    )
    return Table(
        full.numbers, shown, "The claims that carry the paper; all others and the rules are in the next tables."
    )


def claims_summary(judged: Sequence[Judged]) -> Table:
    """Which claims got each verdict.

    :param judged: the claims and what was found
    :return: one row a verdict
    """
    by_verdict = {
        verdict: [claim.id for claim, finding in judged if finding.verdict == verdict] for verdict in VERDICTS
    }
    found = {verdict: names for verdict, names in by_verdict.items() if names}
    numbers = pd.DataFrame({"verdict": found.keys(), "claims": [len(names) for names in found.values()]})
    which = [", ".join(names) for names in found.values()]
    shown = pd.DataFrame({"Verdict": found.keys(), "Claims": numbers["claims"].astype(str), "Which": which})
    return Table(numbers, shown, "The claims by verdict; the next table says what each is about.")


def tally(judged: Sequence[Judged]) -> str:
    """How many claims got each verdict.

    :param judged: the claims and what was found
    :return: one line
    """
    counts = Counter(finding.verdict for _, finding in judged)
    return ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict])
