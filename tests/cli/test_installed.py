"""The kit installed from a wheel and used in an empty folder."""

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from lawn_sb3.experiment.registry import REPOSITORY

SOURCES = ("lawn_sb3", "policies", "runs", "setup.cfg", "pyproject.toml", "README.md", "LICENSE")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The kit as it is installed, apart from the checkout; what it depends on is there already."""
    folder = tmp_path_factory.mktemp("wheel")
    for name in SOURCES:
        source, ignored = REPOSITORY / name, shutil.ignore_patterns("__pycache__", "reference", "*.egg-info", "seed-*")
        if source.is_dir():
            shutil.copytree(source, folder / "source" / name, ignore=ignored)
        else:
            shutil.copy(source, folder / "source" / name)
    pip = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-index",
        "--no-deps",
        "--no-build-isolation",
        "--ignore-installed",
    ]
    subprocess.run([*pip, "--prefix", str(folder / "env"), str(folder / "source")], check=True, capture_output=True)
    return Path(sysconfig.get_path("purelib", vars={"base": str(folder / "env")}))


@pytest.mark.parametrize(
    ("command", "left"),
    [
        ("train --out mine --env-steps 64 --num-games 2 -params n_steps=32 -params n_epochs=1", "mine/evaluation.csv"),
        ("train --recipe runs/tiny.yaml --method nobody --out mine", None),
        ("report", None),
        ("replay --player shortest-path --episodes 1 --out page.html", "page.html"),
    ],
)
def test_what_is_shipped_is_found_from_anywhere(
    installed: Path, tmp_path: Path, command: str, left: str | None
) -> None:
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    arguments = [sys.executable, "-m", "lawn_sb3", *command.split()]
    done = subprocess.run(arguments, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    if left is None:  # the recipe is read, and what is wrong is something else
        assert done.returncode == 2
        assert "unknown method 'nobody'" in done.stderr or "no runs in 'runs/paper'" in done.stderr
    else:
        assert done.returncode == 0, done.stderr
        assert (tmp_path / left).exists()
