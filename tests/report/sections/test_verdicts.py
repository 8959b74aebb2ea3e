"""The claims table: what the paper says, how it was measured, what came out."""

from lawn_sb3.paper.claims import Claim, Finding, Judged, Verdict
from lawn_sb3.report.sections.verdicts import CAPTION, claims_headlines, claims_summary, claims_table, tally


def judged(verdict: Verdict, figure: str = "1 of 2") -> Judged:
    finding = Finding(verdict, figure, "It is.")
    values = {"id": "flat", "place": 1, "section": "V-B", "text": "It is flat.", "measure": "range over seeds"}
    return Judged(Claim.model_validate({**values, "rule": lambda evidence: finding}), finding)


def test_a_tally_counts_verdicts_in_a_fixed_order_and_leaves_out_those_without() -> None:
    several = [judged("not testable"), judged("partly"), judged("reproduced"), judged("partly")]
    assert tally(several) == "1 reproduced, 2 partly, 1 not testable"
    assert tally([judged("impossible as printed")]) == "1 impossible as printed"
    assert tally([]) == ""


def test_the_table_shows_claim_verdict_measure_and_reason() -> None:
    table = claims_table([judged("partly"), judged("not testable", "")])
    said = {"Claim": "flat", "The paper says": "It is flat. (V-B)"}
    assert table.shown.to_dict("records") == [
        {**said, "Verdict": "partly", "Measured": "range over seeds: 1 of 2", "Why": "It is."},
        {**said, "Verdict": "not testable", "Measured": "range over seeds", "Why": "It is."},
    ]
    assert table.caption == CAPTION.format(count=2)
    assert "There are 2 claims, and verdicts are not corrected for their number." in table.caption


def test_machines_get_every_part_in_a_column_of_its_own() -> None:
    (row,) = claims_table([judged("partly")]).numbers.to_dict("records")
    assert row == {
        "id": "flat", "section": "V-B", "claim": "It is flat.", "measure": "range over seeds", "verdict": "partly",
        "figure": "1 of 2", "why": "It is.",
    }  # fmt: skip


def test_the_summary_names_the_claims_of_each_verdict() -> None:
    table = claims_summary([judged("not testable"), judged("partly"), judged("partly")])
    assert table.shown.to_dict("records") == [
        {"Verdict": "partly", "Claims": "2", "Which": "flat, flat"},
        {"Verdict": "not testable", "Claims": "1", "Which": "flat"},
    ]


def test_headlines_are_the_claims_marked_so_reproduced_ones_first() -> None:
    def headline(verdict: Verdict) -> Judged:
        one = judged(verdict)
        return one._replace(claim=one.claim.model_copy(update={"headline": True}))

    several = [headline("partly"), judged("reproduced"), headline("reproduced")]
    assert claims_headlines(several).shown["Verdict"].tolist() == ["reproduced", "partly"]
