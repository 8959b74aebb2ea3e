"""Disks that fill up: what writes there has to end in one line, lose nothing, and go on once there is room.

Each command is begun on file systems of growing sizes, from nothing to what it needs, and begun again after the file
system was made larger. Has to be allowed to mount them: root on Linux, as a rule. ``python -m tests.torture.full_disks
[NUMBER]``: how many for each command, 12 by default.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import yaml

from lawn_sb3.experiment.run_directory.files import MANIFEST_FILE, PROVENANCE_FILE
from tests.torture.kills import ENVIRONMENT, OFTEN

FULL = "lawn-sb3: No space left on device: "
SMALLEST, LARGEST = 4_096, 64_000_000
"""Bytes of a file system: one page, and more than all that is written."""
METHOD = {
    "label": "MAPPO",
    "algo": "mappo",
    "env_steps": 3_000,
    "num_games": 8,
    "settings": {"n_steps": 32, "batch_size": 256, "n_epochs": 1, "policy_kwargs": {"net_arch": [16]}},
}
RECIPE = {
    "seeds": [0],
    "evaluation": {"episodes": 50, "record_every": 200, "watch_every": 1_000, "watch_episodes": 5},
    "methods": {"mappo": METHOD, "random": {"label": "Random", "player": "random"}},
}
VARYING = (PROVENANCE_FILE, MANIFEST_FILE)
"""Files that hold times."""


class Result(NamedTuple):
    """What came of a command."""

    full: int
    """How often the disk was full."""
    fitted: int
    """How often all had room."""


@contextmanager
def disk(folder: Path, size: int) -> Iterator[None]:
    """A file system of its own.

    :param folder: where
    :param size: bytes
    :raises OSError: if there is nothing that mounts
    :raises subprocess.CalledProcessError: if that is not allowed
    """
    folder.mkdir(exist_ok=True)
    mount("-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder))
    try:
        yield
    finally:
        subprocess.run(["umount", folder], check=True)


def mount(*arguments: str) -> None:
    """Mount something; it says nothing."""
    subprocess.run(["mount", *arguments], check=True, capture_output=True)


def lawn(command: Sequence[str | Path]) -> subprocess.CompletedProcess[str]:
    """``lawn-sb3``, with a checkpoint after every 1,000 env steps."""
    return subprocess.run([*OFTEN, *command], env=ENVIRONMENT, capture_output=True, text=True)


def contents(folder: Path) -> dict[str, bytes]:
    """All files below a folder that depend on nothing but the command; TensorBoard's hold times."""
    paths = [path for path in folder.rglob("*") if path.is_file() and path.parent.name != "tensorboard"]
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths if path.name not in VARYING}


def sizes(needed: int, number: int) -> list[int]:
    """Sizes from a page to what is needed and somewhat more, closest where most files begin."""
    return [int(SMALLEST * (1.2 * needed / SMALLEST) ** (k / (number - 1))) for k in range(number)]


def torture(command: Sequence[str | Path], folder: Path, number: int) -> Result:
    """Let a command fill disks.

    :param command: arguments of ``lawn-sb3`` that write below the folder
    :param folder: where disks are to be
    :param number: how many
    :return: what came of it
    :raises AssertionError: if it does not end in one line, or leaves something else than on a disk with room
    """
    with disk(folder, LARGEST):
        done = lawn(command)
        assert done.returncode == 0, done.stderr
        expected = contents(folder)
        system = os.statvfs(folder)
        needed = (system.f_blocks - system.f_bfree) * system.f_frsize
    full = 0
    for size in sizes(needed, number):
        with disk(folder, size):
            done = lawn(command)
            if done.returncode != 0:
                full += 1
                check_said(done)
                assert not list(folder.rglob("part-*")), size
                mount("-o", f"remount,size={LARGEST}", str(folder))
                done = lawn(command)
                assert done.returncode == 0, done.stderr
            check_same(contents(folder), expected)
    return Result(full, number - full)


def check_said(done: subprocess.CompletedProcess[str]) -> None:
    """Hold what a command said of a full disk to one line, after what it says of how far it is."""
    *before, last = done.stderr.splitlines()
    assert (done.returncode, last[: len(FULL)]) == (1, FULL), done.stderr
    assert last.startswith(f"{FULL}/"), f"it does not name what was written: {last}"
    assert not [line for line in before if "lawn-sb3:" in line or "Error" in line or "Traceback" in line], done.stderr


def check_same(found: Mapping[str, bytes], expected: Mapping[str, bytes]) -> None:
    """Hold files against others."""
    different = [name for name in {**expected, **found} if found.get(name) != expected.get(name)]
    assert expected
    assert not different, f"different: {different}"


def main(number: int = 12) -> str:
    """Fill disks by a training, an evaluation and a report, and print what came of it.

    :param number: how many by each
    :return: a line on all
    :raises AssertionError: if a command does not end in one line, or anything is lost
    """
    with tempfile.TemporaryDirectory() as made:
        folder, recipe = Path(made) / "disk", Path(made) / "full.yaml"
        try:
            with disk(folder, SMALLEST):
                pass
        except (OSError, subprocess.CalledProcessError):
            return "full disks: not tried, as mounting one is not allowed here"
        recipe.write_text(yaml.safe_dump(RECIPE), encoding="utf-8")
        done = lawn(["reproduce", recipe])
        assert done.returncode == 0, done.stderr
        commands: dict[str, list[str | Path]] = {
            "train": ["train", "--no-progress", "--recipe", recipe, "--method", "mappo", "--out", folder / "run"],
            "evaluate": ["evaluate", "--player", "shortest-path", "--rows", folder / "rows.csv"],
            "report": ["report", recipe, "--out", folder / "report"],
        }
        results = {name: torture(command, folder, number) for name, command in commands.items()}
    told = ", ".join(f"{name} {one.full} times full and {one.fitted} not" for name, one in results.items())
    return f"full disks: {told}; each ended in one line, and left the same files once there was room; 0 part files"


if __name__ == "__main__":
    print(main(*map(int, sys.argv[1:])))
