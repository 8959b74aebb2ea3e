"""Where a run comes from: the checkout that tracks the code, and no other."""

import os
import subprocess
from pathlib import Path

import pytest

from lawn_sb3.experiment import provenance as module


@pytest.fixture
def checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Somebody's repository with one commit, in which the code lies as in an environment, untracked."""
    for name in ("AUTHOR", "COMMITTER"):
        monkeypatch.setenv(f"GIT_{name}_NAME", "A user")
        monkeypatch.setenv(f"GIT_{name}_EMAIL", "user@example.org")
    (tmp_path / "notes.txt").write_text("theirs", encoding="utf-8")
    code = tmp_path / ".venv" / "lib" / "provenance.py"
    code.parent.mkdir(parents=True)
    code.write_text("", encoding="utf-8")
    monkeypatch.setattr(module, "__file__", str(code))
    for command in ("init", "add notes.txt", "commit -m theirs"):
        git(tmp_path, command)
    return tmp_path


def git(folder: Path, command: str) -> str:
    done = subprocess.run(["git", *command.split()], cwd=folder, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_a_repository_that_only_holds_the_environment_is_not_named(checkout: Path) -> None:
    assert module.provenance()["commit"] == "unknown: not a git checkout"


def test_the_checkout_that_tracks_the_code_is_named_with_changes_anywhere_in_it(checkout: Path) -> None:
    git(checkout, "add .venv")
    git(checkout, "commit -m code")
    head = git(checkout, "rev-parse HEAD")
    assert module.provenance()["commit"] == head
    (checkout / "notes.txt").write_text("changed", encoding="utf-8")
    assert module.provenance()["commit"] == f"{head}+changes"


def test_the_checkout_is_only_read(checkout: Path) -> None:
    git(checkout, "add .venv")
    git(checkout, "commit -m code")
    os.utime(checkout / "notes.txt", (0, 0))  # git would write down that it holds the same
    index = (checkout / ".git" / "index").read_bytes()
    module.provenance()
    assert (checkout / ".git" / "index").read_bytes() == index
    git(checkout, "status")
    assert (checkout / ".git" / "index").read_bytes() != index
