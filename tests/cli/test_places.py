"""Places that outputs go to: disks that are full, folders that are read-only, gone, links, or have odd names."""

import errno
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from lawn_sb3.experiment import checkpoint
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.experiment.run_directory import files
from tests.cli.running import MAPPO, Lawn, exit_status, recipe

TRAIN = ["train", "--method", "mappo", "--no-progress", "--recipe"]
FULL, READ_ONLY, GONE = "No space left on device", "Read-only file system", "No such file or directory"


@pytest.fixture(scope="module")
def train(tmp_path_factory: pytest.TempPathFactory) -> list[str | Path]:
    """A command that trains in a moment; ``--out`` is to follow."""
    return [*TRAIN, recipe(tmp_path_factory.mktemp("recipe"), methods={"mappo": {**MAPPO, "env_steps": 192}})]


@pytest.fixture(scope="module")
def undisturbed(train: list[str | Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """What it leaves if nothing goes wrong."""
    out = tmp_path_factory.mktemp("undisturbed") / "run"
    assert exit_status(*train, "--out", out) == 0
    return contents(out)


def contents(run: Path) -> dict[str, bytes]:
    """The files of a run whose bytes depend on nothing else."""
    varying = {files.PROVENANCE_FILE, files.MANIFEST_FILE, files.CARD_FILE}  # which name the folder
    return {path.name: path.read_bytes() for path in run.iterdir() if path.is_file() and path.name not in varying}


REFUSING = """
def refusing(self, target):
    if target.name == name:
        raise OSError(number, os.strerror(number), str(self))
    return replace(self, target)
"""
OF_KIT = str(REPOSITORY / "lawn_sb3" / "of_no_file.py")
"""A line of a test would pass for one of the user's, in which a training failed."""


@pytest.fixture
def refuse(monkeypatch: pytest.MonkeyPatch) -> Callable[[str, int], None]:
    """Let files of a name not be put in their place from now on."""

    def begin(name: str, number: int) -> None:
        names = {"name": name, "number": number, "replace": Path.replace, "os": os}
        exec(compile(REFUSING, OF_KIT, "exec"), names)
        monkeypatch.setattr(Path, "replace", names["refusing"])

    return begin


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize(
    "name",
    [
        "config.yaml", "checkpoint.bin", "checkpoint_before.bin", "model.zip", "evaluation.csv", "slots.csv",
        "paths.csv", "evaluation_sampled.csv", "provenance.json", "manifest.json", "finished", "weights.safetensors",
        "README.md",
    ],
)  # fmt: skip
def test_a_disk_that_is_full_ends_a_training_in_one_line_and_the_same_command_goes_on(
    name: str,
    lawn: Lawn,
    tmp_path: Path,
    train: list[str | Path],
    refuse: Callable[[str, int], None],
    monkeypatch: pytest.MonkeyPatch,
    undisturbed: dict[str, bytes],
) -> None:
    out = tmp_path / "run"
    refuse(name, errno.ENOSPC)
    said = lawn(*train, "--out", out, status=1).err
    named = name.replace("_before", "")  # it is moved there as the next one is written
    assert said == f"lawn-sb3: {FULL}: {out / named}; what is finished is kept\n"
    assert not list(out.glob("part-*"))
    assert not (out / "finished").exists()
    monkeypatch.undo()
    lawn(*train, "--out", out)
    assert contents(out) == undisturbed


WRITING = {
    "rows": (["evaluate", "--player", "random", "--episodes", "2", "--rows"], "rows.csv"),
    "plans": (["plan", "--player", "shortest-path", "--episodes", "2", "--rows"], "rows.csv"),
    "paths": (["plan", "--player", "shortest-path", "--episodes", "2", "--paths"], "paths.csv"),
    "picture": (["scenario", "tiny", "--picture"], "tiny.png"),
}
"""Commands that end in the name of a file to write."""


@pytest.mark.parametrize("output", WRITING)
@pytest.mark.parametrize(("number", "words"), [(errno.ENOSPC, FULL), (errno.EROFS, READ_ONLY)])
def test_an_output_that_cannot_be_written_is_named_in_one_line_and_the_one_before_stays(
    output: str, number: int, words: str, lawn: Lawn, tmp_path: Path, refuse: Callable[[str, int], None]
) -> None:
    command, name = WRITING[output]
    (tmp_path / name).write_text("of before")
    refuse(name, number)
    said = lawn(*command, tmp_path / name, status=1).err
    assert said.splitlines()[-1] == f"lawn-sb3: {words}: {tmp_path / name}; what is finished is kept"
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [(name, "of before")]


@pytest.mark.parametrize("output", WRITING)
def test_a_file_in_place_of_a_folder_is_named_in_one_line(output: str, lawn: Lawn, tmp_path: Path) -> None:
    command, name = WRITING[output]
    (tmp_path / "file").write_text("mine")
    path = tmp_path / "file" / name
    said = lawn(*command, path, status=2 if command[0] == "plan" else 1).err.splitlines()
    assert said[-1].startswith("lawn-sb3: ")
    assert str(path) in said[-1]
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("file", "mine")]


NAMES = ["two words", "Ölüberflug – 2", "行", "-dash", "a'b\"c", "[50%]{x}", ":rocket:", "run.1"]


@pytest.mark.parametrize("name", NAMES)
def test_a_run_may_have_any_name(
    name: str,
    lawn: Lawn,
    tmp_path: Path,
    train: list[str | Path],
    monkeypatch: pytest.MonkeyPatch,
    undisturbed: dict[str, bytes],
) -> None:
    monkeypatch.chdir(tmp_path)
    said = lawn(*train, f"--out={name}")
    assert f"the run is in {name}; evaluate it: lawn-sb3 evaluate --run {name}" in said.err
    lawn("evaluate", f"--run={name}", "--episodes", "2", f"--rows={name}.csv")
    lawn("verify", "--", name)
    kept = contents(tmp_path / name)
    assert kept.keys() == undisturbed.keys()
    assert kept["model.zip"] == undisturbed["model.zip"]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([name, f"{name}.csv"])


def test_a_run_may_lie_behind_a_link(
    lawn: Lawn, tmp_path: Path, train: list[str | Path], undisturbed: dict[str, bytes]
) -> None:
    (tmp_path / "disk").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "disk", target_is_directory=True)
    lawn(*train, "--out", tmp_path / "link" / "run")
    assert (tmp_path / "link").is_symlink()
    assert contents(tmp_path / "disk" / "run") == undisturbed
    lawn("verify", tmp_path / "link" / "run")


def test_a_link_to_nowhere_is_named_in_one_line(lawn: Lawn, tmp_path: Path, train: list[str | Path]) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "gone")
    said = lawn(*train, "--out", tmp_path / "link", status=1).err
    assert said == f"lawn-sb3: File exists: {tmp_path / 'link'}; what is finished is kept\n"


VANISHING = """
def vanishing(cell, model, watch):
    shutil.rmtree(cell.directory)
    save(cell, model, watch)
"""


@pytest.mark.usefixtures("often")
def test_a_folder_that_vanishes_in_training_is_named_in_one_line(
    lawn: Lawn, tmp_path: Path, train: list[str | Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    names = {"save": checkpoint.save_checkpoint, "shutil": shutil}
    exec(compile(VANISHING, OF_KIT, "exec"), names)
    monkeypatch.setattr(checkpoint, "save_checkpoint", names["vanishing"])
    out = tmp_path / "run"
    said = lawn(*train, "--out", out, status=1).err
    assert said == f"lawn-sb3: {GONE}: {out / 'progress.csv'}; what is finished is kept\n"
    assert not list(tmp_path.iterdir())
