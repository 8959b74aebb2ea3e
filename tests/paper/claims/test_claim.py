"""The claims as data: every one can be judged, and says what the paper prints."""

import inspect
from functools import partial
from pathlib import Path

import pytest
from pydantic import ValidationError

from lawn_sb3.paper.claims import load_claims
from lawn_sb3.paper.claims.claim import SHARED_RULES
from lawn_sb3.paper.claims.distributions import SHAPES
from lawn_sb3.paper.printed_values import TABLE_II
from lawn_sb3.paper.roles import ROLES
from lawn_sb3.results.quantities import QUANTITIES
from tests.handmade import PARTS

CLAIMS = load_claims()
SHARED = {claim.id: claim.rule for claim in CLAIMS if isinstance(claim.rule, partial)}
"""The claims of the YAML file: their rules with arguments."""
NAMES = {
    **{argument: set(ROLES) for argument in ("of", "over", "than", "role")},
    "quantity": set(QUANTITIES),
    "shape": set(SHAPES),
}
"""What the arguments may name."""


@pytest.mark.parametrize("rule", SHARED.values(), ids=SHARED)
def test_a_shared_rule_is_given_arguments_that_it_takes(rule: partial[object]) -> None:
    inspect.signature(rule.func).bind(None, **rule.keywords)
    for argument, known in NAMES.items():
        given = rule.keywords.get(argument, [])
        assert {given} if isinstance(given, str) else set(given) <= known, argument


def test_every_shared_rule_serves_several_claims() -> None:
    used = [rule.func for rule in SHARED.values()]
    assert set(used) == set(SHARED_RULES.values())
    assert min(map(used.count, used)) > 1


def test_no_two_claims_share_a_name_a_text_or_a_place() -> None:
    for field in ("id", "text", "place"):
        assert len({getattr(claim, field) for claim in CLAIMS}) == len(CLAIMS), field


def test_claims_come_by_their_place_which_follows_the_paper() -> None:
    places = [claim.place for claim in CLAIMS]
    assert places == sorted(places)
    premises = [claim.id for claim in CLAIMS if claim.place < 500]
    assert premises[:4] == ["share-falls", "one-voxel-a-slot", "voxel-centres", "table-1-grid"]
    assert (CLAIMS[len(premises)].id, CLAIMS[-1].id) == ("aggregate-utility", "cdf-awareness")


@pytest.mark.parametrize("role", ["random", "iql", "qmix", "mappo"])
def test_a_row_is_claimed_as_table_two_prints_it(role: str) -> None:
    (claim,) = (claim for claim in CLAIMS if claim.id == f"row-{role}")
    assert SHARED[claim.id].keywords["role"] == role
    name = PARTS[role].paper_row
    assert name is not None
    row = TABLE_II[name]
    assert claim.text == (
        f"{name}: J̄ {row.reward:.2f}, R̂ {row.rate_mbps:.2f} Mbps, T̄ {row.makespan_slots:.1f} slots, "
        f"success {row.success_percent:.1f} %."
    )


def test_a_claim_with_an_unknown_field_is_refused(tmp_path: Path) -> None:
    odd = "- {id: a, place: 1, section: I, text: b, measure: c, rule: collapses, arguments: {}, verdict: partly}"
    (tmp_path / "odd.yaml").write_text(odd, encoding="utf-8")
    with pytest.raises(ValidationError, match="verdict"):
        load_claims(tmp_path / "odd.yaml")
