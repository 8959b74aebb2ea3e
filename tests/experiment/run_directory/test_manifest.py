"""What vouches for a run's files: a changed digit, a halved file or one that is gone is named."""

import shutil
from pathlib import Path

import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.run_directory.manifest import (
    altered_files,
    check_unaltered,
    keep_manifest,
    read_manifest,
    vouch_for,
    vouch_late,
    write_manifest,
)


@pytest.fixture
def run(tmp_path: Path) -> Path:
    for name in ("progress.csv", "provenance.json", "config.yaml"):
        (tmp_path / name).write_text(f"{name} 1.25\n")
    (tmp_path / "provenance.json").write_text('{"command": "lawn-sb3 train",\n"seconds": 1.25}\n')
    (tmp_path / "config.yaml").write_text("seed: 1.25\n")
    (tmp_path / "finished").write_text("later")
    write_manifest(tmp_path, {"command": "lawn-sb3 train", "commit": "abc"})
    return tmp_path


def test_a_run_as_it_was_left_passes(run: Path) -> None:
    assert altered_files(run) == []
    manifest = read_manifest(run)
    assert manifest is not None
    assert manifest["made"]["command"] == "lawn-sb3 train"
    assert set(manifest["files"]) == {"progress.csv", "provenance.json", "config.yaml"}


@pytest.mark.parametrize("name", ["progress.csv", "provenance.json", "config.yaml"])
def test_what_was_altered_is_named(run: Path, name: str) -> None:
    content = (run / name).read_text()
    for other in (content.replace("1.25", "1.26"), content[: len(content) // 2], None):
        (run / name).unlink() if other is None else (run / name).write_text(other)
        with pytest.raises(UserError, match=f"{name} not as the run left it"):
            check_unaltered(run)


def test_a_result_that_was_slipped_in_is_named_and_one_that_is_added_in_order_is_not(run: Path) -> None:
    (run / "regret.csv").write_text("1\n")
    assert altered_files(run) == ["regret.csv"]
    vouch_for(run, "regret.csv")
    assert altered_files(run) == []


def test_a_manifest_vouches_for_itself(run: Path) -> None:
    path = run / "manifest.json"
    path.write_text(path.read_text().replace("abc", "abd"))
    with pytest.raises(UserError, match=r"manifest\.json' is damaged"):
        altered_files(run)


def test_a_run_without_a_manifest_stays_without_one(run: Path) -> None:
    (run / "manifest.json").unlink()
    vouch_for(run, "progress.csv")
    assert not (run / "manifest.json").exists()
    assert altered_files(run) == []


def test_a_copy_of_it_that_is_kept_has_one_that_says_since_when(run: Path, tmp_path: Path) -> None:
    (run / "manifest.json").unlink()
    copy = tmp_path / "copy"
    shutil.copytree(run, copy, ignore=shutil.ignore_patterns("copy"))
    keep_manifest(copy, run)
    manifest = read_manifest(copy)
    assert manifest is not None
    assert manifest["made"] == {
        "command": "lawn-sb3 train",
        "seconds": 1.25,
        "configuration": {"seed": 1.25},
        "vouched_for": "as they were kept; whether that is how the run left them is not known",
    }
    (copy / "progress.csv").write_text("progress.csv 1.26\n")
    assert altered_files(copy) == ["progress.csv"]
    (copy / "provenance.json").write_text("{")
    with pytest.raises(UserError, match="does not say how it was made"):
        vouch_late(copy)
