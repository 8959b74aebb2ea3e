"""The claims as data: every one can be judged, and says what the paper prints."""

from __future__ import annotations

import inspect
from pathlib import Path

import pytest
from pydantic import ValidationError

from lawn_sb3.paper.claims import Claim, Evidence, load_claims
from lawn_sb3.paper.claims.claim import ROLES, CannotTellError
from lawn_sb3.paper.claims.distributions import SHAPES
from lawn_sb3.paper.claims.judge import TESTS
from lawn_sb3.paper.printed_values import TABLE_II
from lawn_sb3.results.quantities import QUANTITIES
from tests.paper.claims.by_hand import METHODS, evidence, flown, method, recipe_of

CLAIMS = load_claims()
NAMES = {"of": ROLES, "over": ROLES, "than": ROLES, "to": ROLES, "role": ROLES, "straight": ROLES,
         "quantity": QUANTITIES, "shape": SHAPES, "row": TABLE_II}  # fmt: skip


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.id)
def test_every_claim_names_a_test_that_takes_its_arguments(claim: Claim) -> None:
    assert claim.test in TESTS
    inspect.signature(TESTS[claim.test]).bind(None, **claim.arguments)
    for argument, known in NAMES.items():
        given = claim.arguments.get(argument, [])
        assert set([given] if isinstance(given, str) else given) <= set(known), argument


def test_every_test_and_every_part_is_used_by_a_claim() -> None:
    assert {claim.test for claim in CLAIMS} == set(TESTS)
    named = [value for claim in CLAIMS for value in claim.arguments.values()]
    used = {
        name
        for value in named
        for name in ([value] if isinstance(value, str) else value if isinstance(value, list) else [])
    }
    assert set(ROLES) <= used


def test_no_two_claims_share_a_name_or_a_text() -> None:
    assert len({claim.id for claim in CLAIMS}) == len(CLAIMS)
    assert len({claim.text for claim in CLAIMS}) == len(CLAIMS)


@pytest.mark.parametrize("role", ["random", "iql", "qmix", "mappo"])
def test_a_row_is_claimed_as_table_two_prints_it(role: str) -> None:
    (claim,) = (claim for claim in CLAIMS if claim.test == "agrees_with_row" and claim.arguments["role"] == role)
    name = METHODS[role].paper_row
    assert name is not None
    row = TABLE_II[name]
    assert claim.text == (
        f"{name}: J̄ {row.reward:.2f}, R̂ {row.rate_mbps:.2f} Mbps, T̄ {row.makespan_slots:.1f} slots, "
        f"success {row.success_percent:.1f} %."
    )


def test_a_claim_with_an_unknown_field_is_refused(tmp_path: Path) -> None:
    (tmp_path / "odd.yaml").write_text("- {id: a, section: I, text: b, measure: c, test: reaches, verdict: partly}")
    with pytest.raises(ValidationError, match="verdict"):
        load_claims([tmp_path / "odd.yaml"])


@pytest.mark.parametrize("role", ROLES)
def test_every_part_is_played_by_its_own_method_alone(role: str) -> None:
    backwards = dict(reversed(METHODS.items()))  # methods with a setting of their own stand first
    found = evidence(*(flown(key, reward=[[1.0]]) for key in METHODS), recipe=recipe_of(backwards))
    assert found.key(role) == role
    assert found.label(role) == METHODS[role].label


def test_the_first_method_of_the_recipe_plays_a_part_that_several_could() -> None:
    both = {"second-best": method("qmix", label="A"), "qmix": method("qmix", label="B")}
    found = evidence(*(flown(key, reward=[[1.0]]) for key in both), recipe=recipe_of(both))
    assert found.label("qmix") == "A"


def test_a_part_without_finished_runs_cannot_be_told() -> None:
    found = evidence(flown("random", reward=[[1.0]]))
    with pytest.raises(CannotTellError, match="finished runs of a method with algo qmix, policy monotonic_mixer"):
        found.key("qmix")
    nothing: Evidence = evidence()
    with pytest.raises(CannotTellError, match="player random"):
        nothing.key("random")
