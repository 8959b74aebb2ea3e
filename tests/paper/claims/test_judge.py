"""Judging: whatever the runs lack, every claim gets a verdict and a reason."""

import re
from functools import partial

import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.paper.checks import read_checks
from lawn_sb3.paper.claims import Claim, Evidence, Finding, Verdict, judge, judge_all, load_claims
from lawn_sb3.paper.claims.claim import VERDICTS
from lawn_sb3.paper.claims.comparisons import better_than
from lawn_sb3.paper.claims.evidence import Family
from lawn_sb3.paper.claims.rule_parts import difference
from lawn_sb3.results.results import read_results
from tests.handmade import evidence, measured

CLAIM = Claim(
    id="a", place=1, section="V", text="b", measure="c",
    rule=partial(better_than, quantity="reward", of=["mappo"], over=["qmix"]),
)  # fmt: skip


def test_missing_methods_make_a_claim_not_testable() -> None:
    finding = judge(CLAIM, measured("reward", mappo=[[1.0]] * 2))
    assert finding == (
        "not testable", "", "Needs finished runs of a method with algo qmix, policy monotonic_mixer."
    )  # fmt: skip
    elsewhere = judge(CLAIM.model_copy(update={"needs": "ablation"}), evidence())
    assert elsewhere.why.endswith("state_critic; it is judged in the report of runs/ablation.yaml.")


def test_runs_that_do_not_fit_together_make_it_not_testable_too() -> None:
    # One mission against two.
    finding = judge(CLAIM, measured("reward", mappo=[[1.0]] * 2, qmix=[[1.0, 2.0]] * 2))
    assert finding.verdict == "not testable"
    assert finding.why == "Needs MAPPO and QMIX on the same missions."


def test_claims_are_judged_in_order() -> None:
    judged = judge_all([CLAIM, CLAIM.model_copy(update={"id": "z"})], evidence())
    assert [claim.id for claim, _ in judged] == ["a", "z"]


def test_a_claim_that_owes_its_figures_to_how_the_game_was_made_is_not_reproduced() -> None:
    ahead = measured("reward", mappo=[[2.0]] * 2, qmix=[[1.0]] * 2)
    behind = measured("reward", mappo=[[1.0]] * 2, qmix=[[2.0]] * 2)
    assert judge(CLAIM, ahead).verdict == "reproduced"
    claim = CLAIM.model_copy(update={"owed_to": "by construction"})
    assert judge(claim, ahead).verdict == "by construction"
    assert judge(claim, behind).verdict == "contradicted"


@pytest.mark.parametrize("verdict", ["partly", "not shown", "not testable", "impossible as printed", "contradicted"])
def test_what_is_not_reproduced_is_not_owed_to_how_the_game_was_made(verdict: Verdict) -> None:
    rule = lambda _: Finding(verdict, "1", "It is.")  # noqa: E731
    claim = CLAIM.model_copy(update={"rule": rule, "owed_to": "by construction"})
    assert judge(claim, evidence()).verdict == verdict


def test_a_difference_counts_if_holm_rejects_it_among_all_that_are_tested() -> None:
    # Variance 1/3 over four seeds on both sides: 2 are 2 / sqrt(1/6) = 4.9 standard errors, p = 0.003 with 6
    # degrees of freedom, and below 0.05 / 2.
    near = [[3.0], [4.0], [3.0], [4.0]]
    found = measured("reward", mappo=near, qmix=[[1.0], [2.0], [1.0], [2.0]], iql=[[3.1], [4.1], [3.2], [4.0]])
    rule = partial(better_than, quantity="reward", of=["mappo"], over=["qmix"])
    sure, unsure = (
        CLAIM.model_copy(update={"rule": rule}),
        CLAIM.model_copy(
            update={"id": "z", "rule": partial(better_than, quantity="reward", of=["mappo"], over=["iql"])}
        ),
    )
    assert [judged.finding.verdict for judged in judge_all([sure, unsure], found)] == ["reproduced", "not shown"]
    assert (len(found.tests.p_values), found.tests.num_apart) == (2, 1)
    # The same test in two claims is one test.
    again = Evidence(found.results)
    judge_all([sure, sure.model_copy(update={"id": "y"})], again)
    assert len(again.tests.p_values) == 1


def test_a_claim_that_cannot_be_judged_does_not_raise_the_bar_for_the_others() -> None:
    # p = 0.003 as above; against IQL there is a difference too, but none against Random, of which there is no run.
    near, far = [[3.0], [4.0], [3.0], [4.0]], [[1.0], [2.0], [1.0], [2.0]]
    found = measured("reward", mappo=near, qmix=far, iql=far)
    rule = partial(better_than, quantity="reward", of=["mappo"], over=["qmix", "iql", "random"])
    judged = judge_all([CLAIM, CLAIM.model_copy(update={"id": "z", "rule": rule})], found)
    assert [one.finding.verdict for one in judged] == ["reproduced", "not testable"]
    assert set(found.tests.p_values) == {("reward", "mappo", "qmix", "0")}


def test_a_difference_held_to_a_bound_is_a_test_of_its_own_whichever_way_it_is_taken() -> None:
    found = measured("reward", mappo=[[1.0], [2.0], [3.0]], qmix=[[0.0], [1.0], [0.0]])
    there = [difference(found, "reward", "mappo", "qmix", level) for level in (0.0, 4.0)]
    back = [difference(found, "reward", "qmix", "mappo", level) for level in (0.0, -4.0)]
    assert set(found.tests.p_values) == {("reward", "mappo", "qmix", "0"), ("reward", "mappo", "qmix", "4")}
    assert [one.side for one in (*there, *back)] == [1.0, -1.0, -1.0, 1.0]


def test_what_is_significant_alone_may_not_be_among_many() -> None:
    family = Family()
    assert family.is_apart(("reward", "a", "b"), 0.03)
    assert not family.is_apart(("reward", "a", "c"), 0.5)
    family.correct()  # 0.03 > 0.05 / 2
    assert not family.is_apart(("reward", "a", "b"), 0.03)
    assert family.num_apart == 0
    assert family.is_apart(("reward", "a", "d"), float("nan"))  # no seed differs from another: chance has no part
    assert len(family.p_values) == 2


def test_without_any_run_only_what_the_paper_prints_is_judged() -> None:
    judged = judge_all(load_claims(), evidence())
    told = {claim.id for claim, finding in judged if finding.verdict != "not testable"}
    assert told == {
        "share-falls", "one-voxel-a-slot", "voxel-centres", "sum-rate-inadequate", "ema-consistency",
        "payoff-decomposition", "rate-term-duration", "continuous-actions", "critic-team-return",
    }  # fmt: skip


def test_without_its_check_a_claim_says_what_makes_it() -> None:
    (claim,) = (claim for claim in load_claims() if claim.id == "table-1-grid")
    assert judge(claim, evidence()) == (
        "not testable", "", "Needs checks/printed_grid.csv, which lawn-sb3 reproduce makes."
    )  # fmt: skip


def test_small_runs_give_every_claim_a_verdict_and_a_sentence(recipe: Recipe, small_cells: list[Cell]) -> None:
    results = read_results(recipe, small_cells)
    results.checks = read_checks(recipe, small_cells, results.problems)
    assert not results.problems
    judged = judge_all(load_claims(), Evidence(results))
    assert len(judged) == len(load_claims())
    for claim, (verdict, figure, why) in judged:
        assert verdict in VERDICTS, claim.id
        assert (figure == "") == (verdict == "not testable"), claim.id
        assert why[0].isupper(), claim.id
        assert why.endswith("."), claim.id
        assert not re.search(r"\bnan\b", f"{figure} {why}"), claim.id
    verdicts = {claim.id: finding.verdict for claim, finding in judged}
    assert verdicts["no-communication"] == "not testable"  # QMIX is not there
    for told in ("random-flat", "congestion-game", "iql-rate-artefact", "table-1-grid", "table-1-reward-unit"):
        assert verdicts[told] != "not testable"
