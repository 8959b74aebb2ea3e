"""Errors say in one line what was wrong, where, and what is allowed."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from lawn_sb3.errors import UserError, explain, unknown_name


class Engine(BaseModel):
    model_config = ConfigDict(extra="forbid")

    power_w: float = Field(1.0, gt=0)


class Fleet(BaseModel):
    model_config = ConfigDict(extra="forbid")

    size: int
    engines: dict[str, Engine] = {}
    spare: Engine | None = None


def complaint(**values: Any) -> str:
    with pytest.raises(ValidationError) as refusal:
        Fleet.model_validate(values)
    return str(explain(refusal.value, Fleet, "fleet.yaml"))


def test_user_error_is_a_value_error() -> None:
    assert issubclass(UserError, ValueError)


def test_unknown_name_suggests_the_nearest_and_lists_all_in_order() -> None:
    said = str(unknown_name("algorithm", "mapo", ["qmix", "mappo", "iql"]))
    assert said == "unknown algorithm 'mapo' (did you mean 'mappo'?); known: iql, mappo, qmix"


def test_unknown_name_suggests_nothing_far_fetched() -> None:
    assert "did you mean" not in str(unknown_name("algorithm", "zzz", ["qmix", "mappo", "iql"]))


def test_bad_value_is_named_with_its_place_and_bound() -> None:
    said = complaint(size=2, engines={"left": {"power_w": -3}})
    assert said == "fleet.yaml: engines.left.power_w = -3: Input should be greater than 0"


def test_missing_key_is_named() -> None:
    assert complaint() == "fleet.yaml: size is missing"


def test_further_complaints_are_counted() -> None:
    assert complaint(size="many", spare={"power_w": 0}).endswith("(and 1 more)")


@pytest.mark.parametrize(
    ("values", "key", "known"),
    [
        ({"size": 2, "sizes": 2}, "sizes", "known: engines, size, spare"),
        ({"size": 2, "engines": {"left": {"power": 2}}}, "engines.left.power", "known: power_w"),
        ({"size": 2, "spare": {"power": 2}}, "spare.power", "known: power_w"),
    ],
    ids=["top", "in-a-mapping", "in-an-optional"],
)
def test_misspelt_key_is_answered_with_the_keys_of_its_own_place(values: dict[str, Any], key: str, known: str) -> None:
    said = complaint(**values)
    assert said.startswith("fleet.yaml: unknown key")
    assert key in said
    assert "did you mean" in said
    assert said.endswith(known)
