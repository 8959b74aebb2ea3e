"""What users write is read as YAML, and what is wrong with it is told in one line: what, where, and what is allowed."""

from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel, ConfigDict, Field

from lawn_sb3.config import parse_overrides, read_yaml_mapping, validated
from lawn_sb3.errors import UserError, unknown_name


class Engine(BaseModel):
    model_config = ConfigDict(extra="forbid")

    power_w: float = Field(1.0, gt=0)


class Fleet(BaseModel):
    model_config = ConfigDict(extra="forbid")

    size: int
    engines: dict[str, Engine] = {}
    spare: Engine | None = None
    speed: float | tuple[float, ...] = 1.0


def test_unknown_name_suggests_the_nearest_and_lists_all_in_order() -> None:
    refusal = unknown_name("algorithm", "mapo", ["qmix", "mappo", "iql"])
    assert isinstance(refusal, ValueError)
    assert str(refusal) == "unknown algorithm 'mapo' (did you mean 'mappo'?); known: iql, mappo, qmix"


def test_unknown_name_suggests_nothing_far_fetched() -> None:
    assert "did you mean" not in str(unknown_name("algorithm", "zzz", ["qmix", "mappo", "iql"]))


@pytest.mark.parametrize(
    ("values", "complaint"),
    [
        ({}, "size is missing"),
        ({"size": 2, "spare": {"power_w": -3}}, "spare.power_w = -3: must be greater than 0"),
        ({"size": 2, "sizes": 2}, "unknown key 'sizes' (did you mean 'size'?); known: engines, size, spare, speed"),
        (
            {"size": 2, "engines": {"left": {"power": 2}}},
            "unknown key 'engines.left.power' (did you mean 'power_w'?); known: power_w",
        ),
        ({"size": 2, "spare": {"power": 2}}, "unknown key 'spare.power' (did you mean 'power_w'?); known: power_w"),
        ({"size": 2, "speed": "fast"}, "speed = 'fast': must be a number, or must be a list"),
        ({"size": "many", "spare": {"power_w": 0}}, "size = 'many': must be a whole number (and 1 more)"),
    ],
    ids=["missing", "bound", "key", "key-in-a-mapping", "key-in-an-optional", "one-of-two-types", "two-mistakes"],
)
def test_the_first_mistake_is_told_with_its_place_value_and_what_is_allowed(
    values: dict[str, Any], complaint: str
) -> None:
    with pytest.raises(UserError) as refusal:
        validated(Fleet, values, "fleet.yaml")
    assert str(refusal.value) == f"fleet.yaml: {complaint}"


def test_overrides_are_yaml_and_the_last_one_counts() -> None:
    given = ["num_uavs=2", " num_uavs = 3", "rbs_per_gbs=[1, 2]", "arrival=fly-through", "bandwidth=360e+3"]
    assert parse_overrides(given) == {
        "num_uavs": 3, "rbs_per_gbs": [1, 2], "arrival": "fly-through", "bandwidth": "360e+3"
    }  # fmt: skip


@pytest.mark.parametrize("override", ["num_uavs", "=8", "num_uavs 8", ""])
def test_override_without_key_and_value_is_refused(override: str) -> None:
    with pytest.raises(UserError) as refusal:
        parse_overrides([override])
    assert str(refusal.value) == f"--set {override!r}: expected key=value"


@pytest.mark.parametrize("value", ["[1, 2", "2020-13-45"])
def test_override_that_is_not_yaml_is_refused(value: str) -> None:
    with pytest.raises(UserError) as refusal:
        parse_overrides([f"key={value}"], "--hyperparams")
    assert str(refusal.value) == f"--hyperparams 'key={value}': the value is not valid YAML"


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"num_uavs: 4\nwidth_voxels: [3\nlength_voxels: 5\n", ", line 3 is not valid YAML"),
        (b"\xff\xfe\x00", " is not valid YAML"),
        (b"day: 2020-13-45\n", " is not valid YAML"),
        (b"- num_uavs\n- 4\n", " must hold keys and values, not list"),
        (b"", " must hold keys and values, not NoneType"),
    ],
    ids=["broken", "binary", "impossible-date", "list", "empty"],
)
def test_unusable_file_is_refused_by_name(content: bytes, complaint: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_bytes(content)
    with pytest.raises(UserError) as refusal:
        read_yaml_mapping(path, "scenario")
    assert str(refusal.value).startswith(f"scenario file {str(path)!r}{complaint}")
    assert "\n" not in str(refusal.value)


def test_missing_file_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"nowhere\.yaml' cannot be read: No such file"):
        read_yaml_mapping(tmp_path / "nowhere.yaml", "scenario")
