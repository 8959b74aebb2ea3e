"""Where a run comes from: commit, versions, hardware, command and wall time."""

import datetime
import os
import platform
import shlex
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

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
        "versions": versions(),
        "hardware": {
            "processor": _processor(),
            "cores": os.cpu_count(),
            "system": f"{platform.system()} {platform.machine()}",
        },
    }


def versions() -> dict[str, str]:
    """The versions of this kit and of all that its results may depend on.

    :return: by name
    """
    return {name: version(name) for name in PACKAGES}


def _commit() -> str:
    """The commit of the checkout that tracks this file: one in which an environment only lies says nothing of it."""

    def git(*arguments: str) -> str:
        command = ["git", "--no-optional-locks", "-C", str(Path(__file__).parent), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    try:
        git("ls-files", "--error-unmatch", Path(__file__).name)
        return git("rev-parse", "HEAD") + (
            "+changes" if git("status", "--porcelain", "--untracked-files=normal", ":/") else ""
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
