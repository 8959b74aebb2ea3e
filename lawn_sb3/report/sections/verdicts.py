"""Claims of the paper: what it says, what was measured, and the verdict."""

from collections import Counter
from collections.abc import Sequence

from lawn_sb3.experiment.knowledge import has_ladder
from lawn_sb3.paper.claims import Evidence, judge_all, load_claims
from lawn_sb3.paper.claims.claim import MEANINGS, VERDICTS, Judged
from lawn_sb3.paper.claims.evidence import Family
from lawn_sb3.paper.comparable import is_papers_game, printed_rows
from lawn_sb3.report.section import Section
from lawn_sb3.report.table import Row, Table, table_of
from lawn_sb3.results.pairing import SEARCHED
from lawn_sb3.results.results import Results

HEADING = "Claims of the paper"
UNTESTABLE = "not testable"
CAPTION = (
    "Checkable claims of the paper, {count} of which these runs can test: how each is measured, what came out, and the "
    "verdict that follows by the rule stated. Verdicts are computed from the runs, or from what the paper prints. "
    "Where CTDE-MAPPO is judged with two critics, both have to pass. In brackets 95 % intervals: of differences of "
    "what two methods have on the same missions t intervals over seeds and missions, of figures of curves and "
    "distributions Welch's over seeds, of figures that are held to a number Student's over seeds, of all else "
    "bootstrap intervals, on which no verdict rests. {tests} {words} Claims on parts of the method are judged in the "
    "reports of runs/ablation.yaml and runs/ladder.yaml."
)
"""To be filled with the number of claims, of the tests, and the meaning of the verdicts."""
ON_PARTS = (
    "Claims of the paper on parts of its method; all others are in the report of runs/paper.yaml. How each is "
    "measured, what came out [95 % intervals: of differences of what two methods have on the same missions t intervals "
    "over seeds and missions, of figures of learning curves Welch's over seeds, of all else bootstrap intervals, on "
    "which no verdict rests], and the verdict that follows by the rule stated. "
    "{tests} {words} " + SEARCHED
)


def section(results: Results) -> Section | None:
    """The claims that these runs can test, where the game is the paper's.

    In a report of ablations or of a ladder those that need one; else there has to be a row of the paper's Table II.
    """
    needed = "ablation" if results.recipe.is_ablation else "ladder" if has_ladder(results.methods) else None
    if not is_papers_game(results.recipe) or (needed is None and not printed_rows(results.recipe)):
        return None
    evidence = Evidence(results)
    asked = [claim for claim in load_claims() if needed is None or claim.needs == needed]
    judged = judge_all(asked, evidence)
    tested = [one for one in judged if one.finding.verdict != UNTESTABLE]
    if not tested:
        return None
    caption = CAPTION if needed is None else ON_PARTS
    tables = {
        "claims_headlines": claims_headlines(tested),
        "claims_summary": claims_summary(tested),
        "claims": claims_table(tested, caption, evidence.tests),
    }
    if needed is not None:
        tables = {"claims": tables["claims"]}
    return Section(HEADING, tables, summary=(f"The paper's claims: {tally(judged)}.",))


def claims_table(judged: Sequence[Judged], caption: str = CAPTION, tests: Family | None = None) -> Table:
    """One row a claim with its finding.

    :param judged: the claims
    :param caption: may tell their ``count``, the ``tests`` and the ``words`` of the verdicts
    :param tests: of differences, that the verdicts rest on
    """
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
    given = {finding.verdict for _, finding in judged}
    words = "; ".join(f"{verdict}: {MEANINGS[verdict]}" for verdict in VERDICTS if verdict in given)
    text = caption.format(count=len(judged), tests=family_text(tests or Family()), words=f"{words}.".capitalize())
    return table_of(rows, " ".join(text.split()))


def family_text(tests: Family) -> str:
    """How differences were told from chance, if any were: by Holm's correction over all of them."""
    if not tests.p_values:
        return ""
    if len(tests.p_values) == 1:
        return "The one difference that they need counts only if a t test finds it at 5 %."
    return (
        "A difference, of two methods or of a figure from a number that it is held to, counts only if a t test finds "
        "it at 5 % after Holm's correction over all "
        f"{len(tests.p_values)} that these claims need: {tests.num_apart} {'does' if tests.num_apart == 1 else 'do'}; "
        "so an interval may leave 0 out, or lie within a margin, and not count. A difference that has to lie beyond or "
        "within a bound is tested against that bound instead of 0; where neither seeds nor missions differ there is "
        "nothing to test, and it counts as it is, but that methods are level says of neither that it leads."
    )


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
            shown = {
                "Verdict": verdict,
                "Which means": MEANINGS[verdict],
                "Claims": str(len(names)),
                "Which": ", ".join(names),
            }
            rows.append(Row({"verdict": verdict, "claims": len(names)}, shown))
    return table_of(rows, "The claims by verdict; the next table says what each is about.")


def tally(judged: Sequence[Judged]) -> str:
    """How many claims got each verdict, in one line."""
    counts = Counter(finding.verdict for _, finding in judged)
    return ", ".join(
        f"{counts[verdict]} {verdict}{' with these runs' if verdict == UNTESTABLE else ''}"
        for verdict in VERDICTS
        if counts[verdict]
    )
