"""The claims table: what the paper says, how it was measured, what came out."""

import re

from lawn_sb3.paper.claims import Claim, Finding, Judged, Verdict
from lawn_sb3.paper.claims.evidence import Family
from lawn_sb3.report.sections.verdicts import (
    HEADING,
    claims_headlines,
    claims_summary,
    claims_table,
    section,
    tally,
)
from lawn_sb3.report.table import Table
from tests.handmade import PARTS, flown_by_seed, recipe_of_parts, results_of


def judged(verdict: Verdict, figure: str = "1 of 2") -> Judged:
    finding = Finding(verdict, figure, "It is.")
    values = {"id": "flat", "place": 1, "section": "V-B", "text": "It is flat.", "measure": "range over seeds"}
    return Judged(Claim.model_validate({**values, "rule": lambda evidence: finding}), finding)


def test_a_tally_counts_verdicts_in_a_fixed_order_and_leaves_out_those_without() -> None:
    several = [judged("not testable"), judged("partly"), judged("reproduced"), judged("partly")]
    assert tally(several) == "1 reproduced, 2 partly, 1 not testable with these runs"
    assert tally([judged("impossible as printed")]) == "1 impossible as printed"
    assert tally([]) == ""


def test_the_table_shows_claim_verdict_measure_and_reason() -> None:
    table = claims_table([judged("partly"), judged("not testable", "")])
    said = {"Claim": "flat", "The paper says": "It is flat. (V-B)"}
    assert table.shown.to_dict("records") == [
        {**said, "Verdict": "partly", "Measured": "range over seeds: 1 of 2", "Why": "It is."},
        {**said, "Verdict": "not testable", "Measured": "range over seeds", "Why": "It is."},
    ]
    assert table.caption.startswith("Checkable claims of the paper, 2 of which these runs can test")
    assert "Partly: some of its conditions hold; not testable: runs are missing. Claims on parts" in table.caption


def test_the_caption_says_how_many_differences_were_tested() -> None:
    caption = claims_table([judged("partly")], tests=Family(0.01, {("a",): 0.01, ("b",): 0.02, ("c",): 0.5})).caption
    assert "after Holm's correction over all 3 that these claims need: 1 does; so" in caption
    assert "tested against that bound instead of 0" in caption


PLAYED = [flown_by_seed(role, arrived=[[True] * 6] * 2) for role in ("mappo", "mappo-o", "random")]


def test_only_claims_that_the_runs_can_test_are_shown() -> None:
    shown = section(results_of(recipe_of_parts(), *PLAYED))
    assert shown is not None
    assert shown.heading == HEADING
    claims = shown.shown["claims"]
    assert isinstance(claims, Table)
    assert "perfect-success" in set(claims.numbers["id"])
    assert "row-qmix" not in set(claims.numbers["id"])
    assert "not testable" not in set(claims.numbers["verdict"])
    assert re.search(r"\d+ not testable with these runs\.$", shown.summary[0])


def test_a_game_or_methods_that_are_not_the_papers_are_not_held_to_its_claims() -> None:
    assert section(results_of(recipe_of_parts(changes=["num_uavs=5"]), *PLAYED)) is None
    own = {role: PARTS[role].model_copy(update={"paper_row": None}) for role in ("mappo", "mappo-o", "random")}
    assert section(results_of(recipe_of_parts(own), *PLAYED)) is None


def test_machines_get_every_part_in_a_column_of_its_own() -> None:
    (row,) = claims_table([judged("partly")]).numbers.to_dict("records")
    assert row == {
        "id": "flat", "section": "V-B", "claim": "It is flat.", "measure": "range over seeds", "verdict": "partly",
        "figure": "1 of 2", "why": "It is.",
    }  # fmt: skip


def test_the_summary_names_the_claims_of_each_verdict() -> None:
    table = claims_summary([judged("not testable"), judged("partly"), judged("partly")])
    assert table.shown.to_dict("records") == [
        {"Verdict": "partly", "Which means": "some of its conditions hold", "Claims": "2", "Which": "flat, flat"},
        {"Verdict": "not testable", "Which means": "runs are missing", "Claims": "1", "Which": "flat"},
    ]


def test_headlines_are_the_claims_marked_so_reproduced_ones_first() -> None:
    def headline(verdict: Verdict) -> Judged:
        one = judged(verdict)
        return one._replace(claim=one.claim.model_copy(update={"headline": True}))

    several = [headline("partly"), judged("reproduced"), headline("reproduced")]
    assert claims_headlines(several).shown["Verdict"].tolist() == ["reproduced", "partly"]
