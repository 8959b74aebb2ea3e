"""Files of models hold no code, and none that somebody planted in one is run when it is loaded."""

import base64
import io
import json
import pickle
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
