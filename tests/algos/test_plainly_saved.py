"""Files of models hold no code, and none that somebody planted in one is run when it is loaded."""

import base64
import io
import json
import pickle
import re
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lawn_sb3.algos.iql import IQL
from lawn_sb3.algos.qmix import QMIX
from tests.algos.small import independent, learner, small_env, team
from tests.experiment.payload import Payload

BUILDERS = {"mappo": learner, "iql": independent, "qmix": team}


@pytest.fixture(scope="module", params=BUILDERS)
def model(request: pytest.FixtureRequest) -> Any:
    return BUILDERS[request.param]()


def replaced(path: Path, member: str, content: bytes) -> None:
    """Replace one member of an archive."""
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, old in members.items():
            archive.writestr(name, content if name == member else old)


def as_sb3_does(trace: Path) -> bytes:
    serialized = base64.b64encode(pickle.dumps(Payload(trace))).decode()
    return json.dumps({"policy_class": {":type:": "<class 'abc.ABCMeta'>", ":serialized:": serialized}}).encode()


def as_array(trace: Path) -> bytes:
    content = io.BytesIO()
    np.savez(content, np.array([Payload(trace)], dtype=object), allow_pickle=True)
    return content.getvalue()


@pytest.mark.parametrize(
    ("member", "planted"),
    [
        ("data", as_sb3_does),
        ("data", lambda trace: pickle.dumps(Payload(trace))),
        ("arrays.npz", as_array),
        ("policy.pth", lambda trace: pickle.dumps(Payload(trace))),
    ],
)
def test_nothing_planted_in_a_models_file_is_run(
    model: Any, tmp_path: Path, member: str, planted: Callable[[Path], bytes]
) -> None:
    path, trace = tmp_path / "model.zip", tmp_path / "ran"
    model.save(path)
    replaced(path, member, planted(trace))
    with pytest.raises(ValueError, match="cannot be loaded") as refusal:
        type(model).load(path, device="cpu")
    assert "\n" not in str(refusal.value)
    assert not trace.exists()


@pytest.mark.parametrize(
    "name", ["subprocess:Popen", "evil:Policy", "policies.evil:Policy", "os:system", "lawn_sb3.config:validated", "nn"]
)
def test_a_file_names_no_class_but_of_networks_optimisers_and_buffers(
    model: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    (tmp_path / "policies").mkdir()
    for path in (tmp_path / "evil.py", tmp_path / "policies" / "evil.py"):
        path.write_text("from pathlib import Path\nPath('ran').touch()\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    model.save(tmp_path / "model.zip")
    with zipfile.ZipFile(tmp_path / "model.zip") as archive:
        settings = json.loads(archive.read("data"))
    settings["policy_class"] = {"class": name}
    replaced(tmp_path / "model.zip", "data", json.dumps(settings).encode())
    with pytest.raises(ValueError, match=name):
        type(model).load(tmp_path / "model.zip", device="cpu")
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("name", BUILDERS)
def test_equal_models_leave_equal_bytes(name: str, tmp_path: Path) -> None:
    for path in (tmp_path / "one.zip", tmp_path / "other.zip"):
        BUILDERS[name]().save(path)
    assert (tmp_path / "one.zip").read_bytes() == (tmp_path / "other.zip").read_bytes()


def changed(**changes: Any) -> Callable[[bytes], bytes]:
    """The settings of a model with some changed."""
    return lambda data: json.dumps(json.loads(data) | changes).encode()


def without(name: str) -> Callable[[bytes], bytes]:
    """The settings of a model without one of them."""
    return lambda data: json.dumps({key: value for key, value in json.loads(data).items() if key != name}).encode()


SETTINGS: dict[str, tuple[Callable[[bytes], bytes], str]] = {
    "empty": (lambda data: b"", "cannot be loaded"),
    "half": (lambda data: data[: len(data) // 2], "cannot be loaded"),
    "no text": (lambda data: b"\xff\xfe\x00", "cannot be loaded"),
    "a list": (lambda data: b"[1]", "cannot be loaded"),
    "a number": (lambda data: b"5", "cannot be loaded"),
    "nothing": (lambda data: b"{}", "it was written by SB3 or by an earlier version"),
    "no format": (without("format"), "it was written by SB3 or by an earlier version"),
    "an empty format": (changed(format=[]), "its format is [], this version reads lawn-sb3 1 alone"),
    "a later format": (changed(format=["lawn-sb3 9", "MAPPO"]), "its format is ['lawn-sb3 9', 'MAPPO'], this version"),
    "no policy": (without("policy_class"), "by its settings: KeyError: 'policy_class'"),
    "no networks": (without("policy_kwargs"), "by its settings: KeyError: 'policy_kwargs'"),
    "networks in text": (changed(policy_kwargs="large"), "by its settings: AttributeError"),
    "no policy at all": (changed(policy_class=None), "by its settings: TypeError"),
    "no observations": (without("observation_space"), "by its settings: AttributeError"),
    "no moves": (changed(action_space=None), "by its settings: AttributeError"),
    "a rate in text": (changed(learning_rate="high"), "by its settings: AssertionError"),
    "an array that is not there": (changed(gamma={"array": "999"}), "is damaged: gamma cannot be read"),
}


@pytest.mark.parametrize("damage", SETTINGS)
def test_settings_that_make_no_model_are_named_in_one_line(model: Any, tmp_path: Path, damage: str) -> None:
    path, (change, words) = tmp_path / "model.zip", SETTINGS[damage]
    model.save(path)
    with zipfile.ZipFile(path) as archive:
        data = archive.read("data")
    replaced(path, "data", change(data))
    with pytest.raises(ValueError, match=re.escape(words)) as refusal:
        type(model).load(path, device="cpu")
    assert str(refusal.value).startswith(repr(str(path)))
    assert "\n" not in str(refusal.value)


FILES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda content: b"",
    "one byte": lambda content: content[:1],
    "a third": lambda content: content[: len(content) // 3],
    "all but one byte": lambda content: content[:-1],
    "text": lambda content: b"a model " * 100,
    "another archive": lambda content: b"PK\x05\x06" + bytes(18),
}


@pytest.mark.parametrize("damage", FILES)
def test_a_file_that_is_no_model_is_named_in_one_line(model: Any, tmp_path: Path, damage: str) -> None:
    path = tmp_path / "model.zip"
    model.save(path)
    path.write_bytes(FILES[damage](path.read_bytes()))
    with pytest.raises(ValueError, match="cannot be loaded") as refusal:
        type(model).load(path, device="cpu")
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("member", ["data", "arrays.npz", "policy.pth"])
def test_a_part_that_is_missing_is_named_in_one_line(model: Any, tmp_path: Path, member: str) -> None:
    path = tmp_path / "model.zip"
    model.save(path)
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist() if name != member}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    with pytest.raises(ValueError, match=r"policy|data|arrays") as refusal:
        type(model).load(path, device="cpu")
    assert "\n" not in str(refusal.value)


def test_no_flipped_bit_passes_unnoticed(model: Any, tmp_path: Path) -> None:
    path, chance = tmp_path / "model.zip", np.random.default_rng(0)
    model.save(path)
    content = path.read_bytes()
    for at in chance.integers(len(content), size=25):
        path.write_bytes(content[:at] + bytes([content[at] ^ 1 << int(chance.integers(8))]) + content[at + 1 :])
        with pytest.raises(ValueError, match=r"model\.zip") as refusal:
            type(model).load(path, device="cpu")
        assert "\n" not in str(refusal.value)


def test_a_model_that_is_not_there_is_named(model: Any, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"nowhere\.zip"):
        type(model).load(tmp_path / "nowhere", device="cpu")
    with pytest.raises(ValueError, match="cannot be loaded"):
        type(model).load(tmp_path, device="cpu")


def test_another_algorithms_model_is_refused(model: Any, tmp_path: Path) -> None:
    model.save(tmp_path / "model.zip")
    other = QMIX if isinstance(model, IQL) else IQL
    with pytest.raises(ValueError, match=f"is a {type(model).__name__}, not a {other.__name__}"):
        other.load(tmp_path / "model.zip", device="cpu")


def test_what_cannot_be_kept_is_asked_for(tmp_path: Path) -> None:
    learner(learning_rate=lambda left: 1e-3 * left).save(tmp_path / "model.zip")
    mappo = type(learner())
    with pytest.raises(ValueError, match="lacks its learning_rate: a function cannot be kept"):
        mappo.load(tmp_path / "model.zip", device="cpu")
    loaded = mappo.load(tmp_path / "model.zip", small_env(), "cpu", custom_objects={"learning_rate": 1e-3})
    assert loaded.lr_schedule(0.5) == 1e-3
