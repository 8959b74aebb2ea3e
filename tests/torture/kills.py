"""Recipes killed at random, as a group, by their parent alone, or by one worker, and begun again each time.

What they leave in the end has to be what they leave when nobody kills them. ``python -m tests.torture.kills [NUMBER]``:
how many kills of each learner, 20 by default. Looks at ``/proc``: Linux alone.
"""

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml

from lawn_sb3.experiment.registry import REPOSITORY

METHODS = {
    "mappo": {"algo": "mappo", "num_games": 8, "settings": {"n_steps": 32, "batch_size": 256, "n_epochs": 2}},
    "iql": {"algo": "iql", "num_games": 8, "settings": {"buffer_size": 20_000, "learning_starts": 500}},
    "qmix": {"algo": "qmix", "num_games": 8, "settings": {"buffer_size": 10_000, "learning_starts": 2_000}},
}
ENV_STEPS = 50_000
"""Five checkpoints."""
COMPARED = ("*.csv", "model.zip", "config.yaml")
SECONDS = 2.0
"""How long a process may outlive the one that started it."""


def begin(recipe: Path) -> subprocess.Popen[bytes]:
    """Start a recipe, in a process group of its own."""
    command = [sys.executable, "-m", "lawn_sb3", "reproduce", str(recipe)]
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY), "OMP_NUM_THREADS": "1"}
    with (recipe.parent / "said").open("ab") as said:
        return subprocess.Popen(command, env=environment, stdout=said, stderr=said, start_new_session=True)


def states() -> dict[int, tuple[int, str]]:
    """Parent and state of each process."""
    found = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, parent = path.read_text().rpartition(")")[2].split()[:2]
        except OSError:  # has ended meanwhile
            continue
        found[int(path.parent.name)] = int(parent), state
    return found


def workers(parent: int) -> list[int]:
    """The processes in which a recipe's runs are made."""
    own = [pid for pid, (above, _) in states().items() if above == parent]
    return [pid for pid in own if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()]


def seconds_until_gone(pids: list[int]) -> float:
    """How long it takes until processes have ended."""
    began = time.monotonic()
    while any(state != "Z" for _, state in (states().get(pid, (0, "Z")) for pid in pids)):
        if time.monotonic() - began > 60.0:
            raise AssertionError(f"still there after a minute: {pids}")
        time.sleep(0.02)
    return time.monotonic() - began


def left(folder: Path) -> dict[str, bytes]:
    """The files that runs left which have to be equal."""
    paths = [path for pattern in COMPARED for path in folder.glob(f"*/seed-*/{pattern}")]
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def torture(learner: str, number: int, folder: Path) -> str:
    """Kill the runs of a learner.

    :param learner: its name
    :param number: how many kills
    :param folder: where recipes and runs may go
    :return: a line that says what came of it
    """
    evaluation = {"episodes": 20, "record_every": 2_000, "watch_every": 10_000, "watch_episodes": 5}
    method = {"label": learner, "env_steps": ENV_STEPS, **METHODS[learner]}
    content = yaml.safe_dump({"seeds": [0, 1], "evaluation": evaluation, "methods": {learner: method}})
    recipes = [folder / f"{name}.yaml" for name in ("whole", "killed")]
    for recipe in recipes:
        recipe.write_text(content, encoding="utf-8")
    began = time.monotonic()
    assert begin(recipes[0]).wait() == 0
    lasts = time.monotonic() - began
    expected = left(folder / "whole")
    chance, slowest, kinds = random.Random(0), 0.0, {"group": 0, "parent": 0, "worker": 0}
    killed = recipes[1]
    while sum(kinds.values()) < number:
        process = begin(killed)
        time.sleep(chance.uniform(0.1, 0.8) * lasts)
        pids = workers(process.pid)
        if process.poll() is not None or not pids:  # done already, or not begun
            process.wait()
            if left(folder / "killed") == expected:
                subprocess.run(["rm", "-r", folder / "killed"], check=True)
            continue
        kind = list(kinds)[sum(kinds.values()) % len(kinds)]
        kinds[kind] += 1
        if kind == "worker":
            os.kill(chance.choice(pids), signal.SIGKILL)
            assert process.wait() == 0  # it is begun once more by itself
        elif kind == "parent":
            process.kill()
        else:
            os.killpg(process.pid, signal.SIGKILL)
        slowest = max(slowest, seconds_until_gone(pids if kind != "worker" else []))
        process.wait()
    assert begin(killed).wait() == 0
    found = left(folder / "killed")
    different = [name for name in expected if found.get(name) != expected[name]]
    parts = list((folder / "killed").rglob("part-*"))
    assert not different, different
    assert not parts, parts
    assert slowest <= SECONDS, slowest
    return (
        f"{learner}: {kinds}, {len(expected)} files equal, no part file, no orphan: the slowest worker ended "
        f"{slowest:.2f} s after its parent"
    )


if __name__ == "__main__":
    for name in METHODS:
        with tempfile.TemporaryDirectory() as made:
            print(torture(name, int(sys.argv[1]) if len(sys.argv) > 1 else 20, Path(made)), flush=True)
