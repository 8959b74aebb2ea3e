"""Claims of the paper: what it says, what was measured, and the verdict."""

from collections import Counter
from collections.abc import Sequence

from lawn_sb3.experiment.knowledge import has_ladder
from lawn_sb3.paper.claims import Evidence, judge_all, load_claims
from lawn_sb3.paper.claims.claim import VERDICTS, Judged
from lawn_sb3.report.section import Section
from lawn_sb3.report.table import Row, Table, table_of
from lawn_sb3.results.pairing import SEARCHED
from lawn_sb3.results.results import Results

HEADING = "Claims of the paper"
CAPTION = (
    "Every checkable claim of the paper, how it is measured, what came out, and the verdict that follows by the rule "
    "stated. Verdicts are computed from the runs, or from what the paper prints. Where CTDE-MAPPO is judged with two "
    "critics, both have to pass; partly: some of several conditions hold. In brackets 95 % intervals over seeds: of "
    "differences between two methods Welch's t intervals, of all else bootstrap intervals, which with five seeds hold "
    "the true value in about five of six cases. There are {count} claims, and verdicts are not corrected for their "
    "number. V(x), IPPO and the actor blind to the loads take the settings that were searched for V(o, x)."
)
"""To be filled with the number of claims."""
ON_PARTS = (
    "Claims of the paper on parts of its method; all others are in the report of runs/paper.yaml. How each is "
    "measured, what came out [95 % bootstrap interval over seeds], and the verdict that follows by the rule stated, "
    f"which rests on Welch's t interval. {SEARCHED}"
)


def section(results: Results) -> Section | None:
    """All claims; in a report of ablations or of a ladder those that need one."""
    needed = "ablation" if results.recipe.is_ablation else "ladder" if has_ladder(results.methods) else None
    claims = [claim for claim in load_claims() if needed is None or claim.needs == needed]
    judged = judge_all(claims, Evidence(results))
    if needed == "ablation":
        testable = any(finding.verdict != "not testable" for _, finding in judged)
        return Section(HEADING, {"claims": claims_table(judged, ON_PARTS)}) if testable else None
    tables = {
        "claims_headlines": claims_headlines(judged),
        "claims_summary": claims_summary(judged),
        "claims": claims_table(judged),
    }
    return Section(HEADING, tables, summary=(f"The paper's claims: {tally(judged)}.",))


def claims_table(judged: Sequence[Judged], caption: str = CAPTION) -> Table:
    """One row a claim with its finding; the caption may tell their ``count``."""
    rows = [
        Row(
            {
                "id": claim.id,
                "section": claim.section,
                "claim": claim.text,
                "measure": claim.measure,
                "verdict": finding.verdict,
                "figure": finding.figure,
                "why": finding.why,
            },
            {
                "Claim": claim.id,
                "The paper says": f"{claim.text} ({claim.section})",
                "Verdict": finding.verdict,
                "Measured": ": ".join(filter(None, [claim.measure, finding.figure])),
                "Why": finding.why,
            },
        )
        for claim, finding in judged
    ]
    return table_of(rows, caption.format(count=len(judged)))


def claims_headlines(judged: Sequence[Judged]) -> Table:
    """The claims that carry the paper, in the order of the verdicts."""
    chosen = [one for verdict in VERDICTS for one in judged if one.claim.headline and one.finding.verdict == verdict]
    full = claims_table(chosen)
    shown = full.shown.drop(columns=["Claim", "Why"], errors="ignore")
    shown["Measured"] = [finding.figure for _, finding in chosen]
    caption = "The claims that carry the paper; all others and the rules are in the next tables."
    return Table(full.numbers, shown, caption)


def claims_summary(judged: Sequence[Judged]) -> Table:
    """Which claims got each verdict."""
    rows = []
    for verdict in VERDICTS:
        names = [claim.id for claim, finding in judged if finding.verdict == verdict]
        if names:
            shown = {"Verdict": verdict, "Claims": str(len(names)), "Which": ", ".join(names)}
            rows.append(Row({"verdict": verdict, "claims": len(names)}, shown))
    return table_of(rows, "The claims by verdict; the next table says what each is about.")


def tally(judged: Sequence[Judged]) -> str:
    """How many claims got each verdict, in one line."""
    counts = Counter(finding.verdict for _, finding in judged)
    return ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict])
