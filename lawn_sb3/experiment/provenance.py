"""Where a run comes from: commit, versions, hardware, command and wall time."""

from __future__ import annotations

import datetime
import json
import os
import platform
import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

from lawn_sb3.experiment.registry import REPOSITORY

PACKAGES = (
    "lawn-sb3",
    "stable-baselines3",
    "sb3-contrib",
    "gymnasium",
    "SuperSuit",
    "PettingZoo",
    "torch",
    "numpy",
    "numba",
    "scipy",
    "pandas",
)


def provenance() -> dict[str, Any]:
    """Describe the code, the machine and the command that are running now.

    :return: commit (with ``+changes`` if files differ from it), versions, hardware, command and time
    """
    return {
        "command": shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]),
        "started": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "commit": _commit(),
        "python": platform.python_version(),
        "versions": {name: version(name) for name in PACKAGES},
        "hardware": {
            "processor": _processor(),
            "cores": os.cpu_count(),
            "system": f"{platform.system()} {platform.machine()}",
        },
    }


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write a JSON file in one go, so that a cut never leaves half of it.

    :param path: the file
    :param content: what it is to hold
    """
    write_text(path, json.dumps(content, indent=2) + "\n")


def write_text(path: Path, text: str) -> None:
    """Write a text file in one go.

    :param path: the file
    :param text: what it is to hold
    """
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Write a file so that it is there whole or not at all, also when the disk is full or the writer is ended.

    :param path: the file
    :return: where to write; moved into place at the end, and removed on failure
    """
    target = path.resolve()  # what a link points to is written, the link stays
    part = target.with_name(f"part-{path.name}")
    try:
        yield part
        part.replace(target)
    except OSError as error:
        error.filename, error.filename2 = str(path), None  # the name that the user knows
        raise
    finally:
        if part.parent.is_dir():
            part.unlink(missing_ok=True)


def _commit() -> str:
    def git(*arguments: str) -> str:
        command = ["git", "-C", str(REPOSITORY), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    try:
        return git("rev-parse", "HEAD") + (
            "+changes" if git("status", "--porcelain", "--untracked-files=normal") else ""
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown: not a git checkout"


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        return platform.processor() or "unknown"
    return platform.processor() or "unknown"
