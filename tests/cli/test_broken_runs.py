"""Runs whose files were lost, cut, exchanged or written by hand: each command that reads them says so in one line."""

import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

from lawn_sb3.experiment.train import run_cell
from tests.cli.running import Lawn
from tests.experiment.training import ignore, iql_cell, mappo_cell

Damage = Callable[[Path], object]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a finished run of MAPPO, and one of IQL."""
    folder = tmp_path_factory.mktemp("runs")
    run_cell(mappo_cell(folder / "run"), ignore)
    run_cell(iql_cell(folder / "other"), ignore)
    return folder


@pytest.fixture
def run(whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of them to damage, in the working folder."""
    shutil.copytree(whole, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return Path("run")


def text(name: str, content: str | bytes) -> Damage:
    """Write a file by hand."""
    return lambda run: (run / name).write_bytes(content if isinstance(content, bytes) else content.encode())


def half(name: str) -> Damage:
    """Cut a file."""
    return lambda run: os.truncate(run / name, (run / name).stat().st_size // 2)


def without(*names: str) -> Damage:
    """Lose files."""

    def lose(run: Path) -> None:
        for name in names:
            (run / name).unlink()

    return lose


def folder(name: str) -> Damage:
    """Put a folder in a file's place."""

    def put(run: Path) -> None:
        (run / name).unlink()
        (run / name).mkdir()

    return put


def of_other(name: str) -> Damage:
    """Put another run's file in its place."""
    return lambda run: shutil.copyfile(run.with_name("other") / name, run / name)


def both(*damages: Damage) -> Damage:
    return lambda run: [damage(run) for damage in damages]


def configured(*path: str, value: Any = None) -> Damage:
    """Change a value of the configuration, or lose it."""

    def change(run: Path) -> None:
        content = yaml.safe_load((run / "config.yaml").read_text(encoding="utf-8"))
        inner = content
        for name in path[:-1]:
            inner = inner[name]
        if value is None:
            del inner[path[-1]]
        else:
            inner[path[-1]] = value
        (run / "config.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")

    return change


NO_CONFIGURATION = "'run/config.yaml' is not the configuration of a run: "
CONFIGURATIONS: Mapping[str, tuple[Damage, str]] = {
    "lost": (without("config.yaml"), "'run' holds no run: config.yaml: No such file or directory"),
    "a folder": (folder("config.yaml"), "'run' holds no run: config.yaml: Is a directory"),
    "empty": (text("config.yaml", ""), f"{NO_CONFIGURATION}it holds no keys and values"),
    "a list": (text("config.yaml", "- 1"), f"{NO_CONFIGURATION}it holds no keys and values"),
    "a text": (text("config.yaml", "hello"), f"{NO_CONFIGURATION}it holds no keys and values"),
    "binary": (text("config.yaml", b"\0\1"), f"{NO_CONFIGURATION}unacceptable character"),
    "no Unicode": (text("config.yaml", b"\xff\xfe\0"), f"{NO_CONFIGURATION}'utf-8' codec can't decode"),
    "unclosed": (text("config.yaml", "{"), f"{NO_CONFIGURATION}while parsing a flow node"),
    "code": (text("config.yaml", "!!python/object/apply:os.system ['touch ran']"), f"{NO_CONFIGURATION}could not"),
    "no key": (configured("key"), f"{NO_CONFIGURATION}key is missing"),
    "no seed": (configured("seed"), f"{NO_CONFIGURATION}seed is missing"),
    "no method": (configured("method"), f"{NO_CONFIGURATION}method is missing"),
    "no scenario": (configured("scenario"), f"{NO_CONFIGURATION}scenario is missing"),
    "no evaluation": (configured("evaluation"), f"{NO_CONFIGURATION}evaluation is missing"),
    "true seed": (configured("seed", value=True), f"{NO_CONFIGURATION}seed = True: a whole number from 0 up"),
    "seed below": (configured("seed", value=-1), f"{NO_CONFIGURATION}seed = -1: a whole number from 0 up"),
    "seed 1.5": (configured("seed", value=1.5), f"{NO_CONFIGURATION}seed = 1.5: a whole number from 0 up"),
    "seed in text": (configured("seed", value="x"), f"{NO_CONFIGURATION}seed = 'x': a whole number from 0 up"),
    "key 5": (configured("key", value=5), f"{NO_CONFIGURATION}key = 5: the name of a method"),
    "key in a list": (configured("key", value=["a"]), f"{NO_CONFIGURATION}key = ['a']: the name of a method"),
    "key above": (configured("key", value="../x"), f"{NO_CONFIGURATION}key = '../x': the name of a method"),
    "method in a list": (configured("method", value=[1]), f"{NO_CONFIGURATION}method: must be"),
    "algo": (configured("method", "algo", value="mapo"), "unknown algorithm 'mapo' (did you mean 'mappo'?)"),
    "policy": (configured("method", "policy", value="nobody"), "unknown policy 'nobody'"),
    "policy 5": (configured("method", "policy", value=5), f"{NO_CONFIGURATION}method: policy = 5: must be"),
    "policy of others": (
        configured("method", "policy", value="os:system"),
        "names the policy 'os:system', which does ",
    ),
    "colons": (configured("method", "policy", value="a:b:c"), "--trust a:b:c allows it"),
    "setting": (configured("method", "settings", "gama", value=1), "unknown setting of mappo: 'gama'"),
    "discount": (configured("method", "settings", "gamma", value=7), "gamma = 7: must be less than or equal to 1"),
    "budget": (configured("method", "env_steps", value=-5), "env_steps = -5: must be greater than or equal to 0"),
    "games": (configured("method", "num_games", value=0), "num_games = 0: must be greater than or equal to 1"),
    "slack": (configured("method", "slack", value=-1), "slack = -1: must be greater than or equal to 0"),
    "nobody": (configured("scenario", "num_uavs", value=0), f"{NO_CONFIGURATION}scenario: num_uavs = 0: must be"),
    "true UAVs": (configured("scenario", "num_uavs", value=True), f"{NO_CONFIGURATION}scenario: num_uavs = True"),
    "RBs": (configured("scenario", "rbs_per_gbs", value="x"), f"{NO_CONFIGURATION}scenario: rbs_per_gbs = 'x'"),
    "too wide": (configured("scenario", "width_voxels", value=10**9), f"{NO_CONFIGURATION}scenario: width_voxels"),
    "no number": (configured("scenario", "ema_beta", value=float("nan")), "ema_beta = nan: must be a finite number"),
    "a name": (configured("scenario", value="paper"), f"{NO_CONFIGURATION}scenario: must be"),
    "no episodes": (configured("evaluation", "episodes", value=0), "episodes = 0: must be greater than or equal to 1"),
    "for ever": (configured("evaluation", "episodes", value=10**12), "episodes = 1000000000000: must be less than or"),
    "no marker": (without("finished"), "'run' is not finished, or its policy file has changed since"),
    "half a marker": (half("finished"), "'run' is not finished, or its policy file has changed since"),
    "other's marker": (of_other("finished"), "'run' is not finished, or its policy file has changed since"),
}
"""What ``evaluate`` and ``verify`` refuse alike."""
NO_MODEL = "'run/model.zip' is not a whole model of this method: "
ANEW = "; without 'run/finished' the run is made anew"
MODELS: Mapping[str, tuple[Damage, str]] = {
    "lost": (without("model.zip"), "'run/model.zip' is missing: the run has not finished, or its model was not kept"),
    "half": (half("model.zip"), f"{NO_MODEL}Error: the file run/model.zip wasn't a zip-file{ANEW}"),
    "empty": (text("model.zip", ""), NO_MODEL),
    "text": (text("model.zip", "hello"), NO_MODEL),
    "a folder": (folder("model.zip"), NO_MODEL),
    "other's": (of_other("model.zip"), f"{NO_MODEL}Error(s) in loading state_dict"),
    "weights": (both(without("model.zip"), text("weights.npz", b"PK\3\4")), "'run/weights.npz' is not a whole model"),
}
"""What ``evaluate`` refuses; so does ``verify`` where there is no manifest."""
NOT_LEFT = "not as the run left it, by its manifest.json"
FILES: Mapping[str, tuple[Damage, str]] = {
    **{f"no {name}": (without(name), f"'run': {name} {NOT_LEFT}") for name in ("model.zip", "evaluation.csv")},
    **{f"half of {name}": (half(name), f"'run': {name} {NOT_LEFT}") for name in ("README.md", "provenance.json")},
    **{f"other {name}": (of_other(name), f"'run': {name} {NOT_LEFT}") for name in ("slots.csv", "weights.safetensors")},
    "weights slipped in": (text("weights.npz", b"PK\3\4"), f"'run': weights.npz {NOT_LEFT}"),
    "half a manifest": (half("manifest.json"), "'run/manifest.json' is damaged: nothing vouches for the run's files"),
    "an empty one": (text("manifest.json", ""), "'run/manifest.json' is damaged"),
    "a list": (text("manifest.json", "[]"), "'run/manifest.json' is damaged"),
    "null": (text("manifest.json", "null"), "'run/manifest.json' is damaged"),
    "no files": (text("manifest.json", '{"sha256": "0"}'), "'run/manifest.json' is damaged"),
    "rows": (both(without("manifest.json"), half("evaluation.csv")), "has other rows or columns than an evaluation"),
    "no rows": (both(without("manifest.json", "evaluation.csv")), "'run/evaluation.csv' cannot be read"),
}
"""What ``verify`` refuses."""


@pytest.mark.parametrize("damage", CONFIGURATIONS)
def test_a_run_that_is_none_is_refused(damage: str, run: Path, lawn: Lawn) -> None:
    change, words = CONFIGURATIONS[damage]
    change(run)
    for command in (("evaluate", "--run", run), ("verify", run)):
        assert words in lawn(*command, status=2).err
    assert not Path("ran").exists()


@pytest.mark.parametrize("damage", MODELS)
def test_a_run_without_a_whole_model_is_refused(damage: str, run: Path, lawn: Lawn) -> None:
    change, words = MODELS[damage]
    change(run)
    assert words in lawn("evaluate", "--run", run, status=2).err
    (run / "manifest.json").unlink()
    assert words in lawn("verify", run, status=2).err


@pytest.mark.parametrize("damage", FILES)
def test_a_run_that_is_not_as_it_was_left_is_not_verified(damage: str, run: Path, lawn: Lawn) -> None:
    change, words = FILES[damage]
    change(run)
    assert words in lawn("verify", run, status=2).err


def test_a_whole_run_is_read(run: Path, lawn: Lawn) -> None:
    lawn("evaluate", "--run", run, "--episodes", "2")
    lawn("verify", run)
