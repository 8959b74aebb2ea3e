"""Parts that methods play in the claims: each is played by its own method alone."""

import re
from pathlib import Path

import pytest

from lawn_sb3.paper.claims import claim
from lawn_sb3.paper.claims.evidence import CannotTellError
from lawn_sb3.paper.roles import FORMS, ROLES
from tests.handmade import PARTS, evidence, flown, method_of, recipe_of_parts


@pytest.mark.parametrize("role", ROLES)
def test_every_part_is_played_by_its_own_method_alone(role: str) -> None:
    backwards = dict(reversed(PARTS.items()))  # methods with a setting of their own stand first
    found = evidence(*(flown(key, 0) for key in PARTS), recipe=recipe_of_parts(backwards))
    assert found.key(role) == role
    assert found.label(role) == PARTS[role].label


def test_the_first_method_of_the_recipe_plays_a_part_that_several_could() -> None:
    both = {"second-best": method_of("qmix", label="A"), "qmix": method_of("qmix", label="B")}
    found = evidence(*(flown(key, 0) for key in both), recipe=recipe_of_parts(both))
    assert found.label("qmix") == "A"


def test_a_part_without_finished_runs_cannot_be_told() -> None:
    with pytest.raises(CannotTellError, match="finished runs of a method with algo qmix, policy monotonic_mixer"):
        evidence(flown("random", 0)).key("qmix")
    with pytest.raises(CannotTellError, match="player random"):
        evidence().key("random")


def test_every_part_is_in_some_claim() -> None:
    folder = Path(claim.__file__).parent
    words = " ".join(path.read_text(encoding="utf-8") for path in (*folder.glob("*.py"), folder / "claims.yaml"))
    assert [role for role in ROLES if role not in FORMS and not re.search(rf"[\"\[ ]{role}[\"\],}}]", words)] == []
