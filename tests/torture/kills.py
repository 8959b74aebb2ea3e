"""Recipes killed at random, as a group, by their parent alone, or by one worker, and begun again each time.

What they leave in the end has to be what they leave when nobody kills them. Half of the kills may fall before the first
checkpoint, the others wait for one. ``python -m tests.torture.kills [NUMBER [LEARNER ...]]``: how many kills of each
learner, 20 by default, and of which, by default all. Looks at ``/proc``: Linux alone.
"""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import torch as th
import yaml
from stable_baselines3.common.save_util import load_from_zip_file

from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.experiment.run_directory.files import (
    CHECKPOINT_FILE,
    LOCK_FILE,
    MODEL_FILE,
    PROVENANCE_FILE,
    TENSORS_FILE,
)

METHODS: dict[str, dict[str, Any]] = {
    "mappo": {"algo": "mappo", "settings": {"n_steps": 32, "batch_size": 256, "n_epochs": 2}},
    "iql": {"algo": "iql", "settings": {"buffer_size": 20_000, "learning_starts": 500, "train_freq": 8}},
    "qmix": {"algo": "qmix", "settings": {"buffer_size": 10_000, "learning_starts": 2_000}},
}
ENV_STEPS = 8_000
EVALUATION = {"episodes": 5, "record_every": 1_000, "watch_every": 4_000, "watch_episodes": 3}
KINDS = ("group", "parent", "worker")
"""In turns, as a run whose worker is killed twice by one and the same parent is given up."""
RAW = ("*.csv", "config.yaml")
EARLY_EVERY = 2
"""One in so many of each kind of kill is early: it does not wait for a checkpoint."""
SECONDS = 2.0
"""How long a process may outlive the one that started it,"""
CPU_SECONDS = 0.2
"""or how long it may compute after that, where it waits for a core: it cannot be ended by Linux before it has asked for
that, which it does as soon as Python has started."""


OFTEN = (sys.executable, "-m", "tests.torture.often")
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(REPOSITORY), "OMP_NUM_THREADS": "1"}
"""With what, and in what environment, ``lawn-sb3`` is started."""


class Pace(NamedTuple):
    """How long an undisturbed recipe takes from the start of its workers."""

    first_checkpoint: float
    """Seconds until a run has a checkpoint."""
    after: float
    """Seconds from then until the last run is done."""


class Result(NamedTuple):
    """What came of the kills of a learner."""

    kills: Counter[str]
    later: int
    """Kills of a run in training that had a checkpoint."""
    rounds: int
    """How often all runs were finished, and compared."""
    raw_files: int
    """That were compared, and equal."""
    resumed: int
    """Runs that went on from a checkpoint the last time that they were begun."""
    models: int
    """Whose weights and bytes were compared, and equal."""
    slowest: float
    """How many seconds a worker outlived its parent at most,"""
    busiest: float
    """and how many seconds it computed meanwhile."""

    def line(self, name: str) -> str:
        """Say it in one line."""
        kinds = ", ".join(f"{self.kills[kind]} {kind}" for kind in KINDS)
        return (
            f"{name}: {self.kills.total()} kills ({kinds}), {self.later} of them after the first checkpoint; "
            f"{self.rounds} times finished, {self.resumed} runs from a checkpoint: {self.raw_files} raw files and "
            f"{self.models} models equal to the byte; 0 orphans (workers ended within {self.slowest:.2f} s, and "
            f"{self.busiest:.2f} s of CPU time, after their parent); 0 part files"
        )


def begin(command: Sequence[str | Path], folder: Path) -> subprocess.Popen[bytes]:
    """Start ``lawn-sb3``, in a process group of its own.

    :param command: its arguments
    :param folder: that of the runs, beside which goes what it says
    :return: the process
    """
    with folder.with_suffix(".said").open("ab") as said:
        return subprocess.Popen([*OFTEN, *command], env=ENVIRONMENT, stdout=said, stderr=said, process_group=0)


class State(NamedTuple):
    """What Linux says of a process."""

    parent: int
    ended: bool
    cpu_seconds: float


def states() -> dict[int, State]:
    """All processes."""
    found = {}
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            values = path.read_text().rpartition(")")[2].split()
        except OSError:  # has ended meanwhile
            continue
        ticks = int(values[11]) + int(values[12])
        found[int(path.parent.name)] = State(int(values[1]), values[0] == "Z", ticks / os.sysconf("SC_CLK_TCK"))
    return found


def workers(parent: int) -> list[int]:
    """The processes in which a recipe's runs are made."""
    found = []
    for pid in [pid for pid, state in states().items() if state.parent == parent]:
        try:
            command = Path(f"/proc/{pid}/cmdline").read_bytes()
        except OSError:  # has ended meanwhile
            continue
        if b"spawn_main" in command:
            found.append(pid)
    return found


def wait_for_workers(process: subprocess.Popen[bytes]) -> bool:
    """Wait until a recipe's runs are being made, or all is done; return which."""
    while process.poll() is None:
        if workers(process.pid):
            return True
        time.sleep(0.1)
    return False


def being_made(folder: Path, pids: list[int]) -> list[Path]:
    """The runs that processes are making, or were when they were killed."""
    runs = []
    for path in folder.glob(f"*/seed-*/{LOCK_FILE}"):
        try:
            if json.loads(path.read_text("utf-8"))["pid"] in pids:
                runs.append(path.parent)
        except (OSError, ValueError):  # has ended meanwhile, or is about to begin
            continue
    return runs


def have_checkpoints(runs: list[Path]) -> list[Path]:
    """Those of some runs that could go on from a checkpoint."""
    return [run for run in runs if (run / CHECKPOINT_FILE).exists()]


def wait_for_a_checkpoint(process: subprocess.Popen[bytes], folder: Path) -> None:
    """Wait until a run that is being made has a checkpoint, or no run is being made."""
    while pids := workers(process.pid):
        if have_checkpoints(being_made(folder, pids)):
            return
        time.sleep(0.05)


def seconds_until_gone(pids: list[int]) -> tuple[float, float]:
    """How long it takes until processes have ended, and how long one of them computes meanwhile at most."""
    began, before = time.monotonic(), states()
    most = 0.0
    while left := [(pid, state) for pid, state in states().items() if pid in pids and not state.ended]:
        most = max(most, *(state.cpu_seconds - before[pid].cpu_seconds for pid, state in left))
        if time.monotonic() - began > 60.0:
            raise AssertionError(f"still there after a minute: {pids}")
        time.sleep(0.02)
    return time.monotonic() - began, most


def raw_files(folder: Path) -> dict[str, bytes]:
    """The files that runs left which have to be equal."""
    paths = [path for pattern in RAW for path in folder.glob(f"*/seed-*/{pattern}")]
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def weights(model: Path) -> dict[str, th.Tensor]:
    """The weights that a model file holds."""
    return dict(load_from_zip_file(model, load_data=False)[1]["policy"])


def check_resumed(folder: Path, had_checkpoint: set[Path]) -> int:
    """Count the finished runs that went on from a checkpoint the last time that they were begun.

    :param folder: all runs
    :param had_checkpoint: those that had one when they were killed last
    :return: how many went on from one
    :raises AssertionError: naming those that had one and began anew
    """
    records = {path.parent: json.loads(path.read_text("utf-8")) for path in folder.glob(f"*/seed-*/{PROVENANCE_FILE}")}
    gone_on = {run for run, record in records.items() if record["resumed_at_env_steps"] > 0}
    assert had_checkpoint <= gone_on, f"begun anew: {sorted(map(str, had_checkpoint - gone_on))}"
    return len(gone_on)


def compare(whole: Path, killed: Path) -> tuple[int, int]:
    """Hold what killed runs left against what others did.

    :param whole: the runs that nobody killed
    :param killed: the others, finished too
    :return: how many raw files and how many models are equal: all
    :raises AssertionError: naming what differs, is missing, or should not be there
    """
    expected, found = raw_files(whole), raw_files(killed)
    different = [name for name in {**expected, **found} if found.get(name) != expected.get(name)]
    assert expected, f"nothing in {whole}"
    assert not different, f"different: {different}"
    models = sorted(path.relative_to(whole) for path in whole.glob(f"*/seed-*/{MODEL_FILE}"))
    for model in models:
        for path in (model, model.with_name(TENSORS_FILE)):
            assert (killed / path).read_bytes() == (whole / path).read_bytes(), f"different: {path}"
        one, other = (weights(folder / model) for folder in (whole, killed))
        assert one.keys() == other.keys(), f"different weights: {model}"
        assert all(th.equal(values, other[name]) for name, values in one.items()), f"different weights: {model}"
    left = [path for pattern in ("part-*", LOCK_FILE, "checkpoint*") for path in killed.rglob(pattern)]
    assert not left, f"left over: {left}"
    return len(expected), len(models)


def torture(learner: str, number: int, folder: Path, env_steps: int = ENV_STEPS) -> Result:
    """Kill the runs of a learner.

    :param learner: its name
    :param number: how many kills
    :param folder: where recipes and runs may go
    :param env_steps: how long each run is
    :return: what came of it
    :raises AssertionError: if anything is lost, different, or left over
    """
    method = {"label": learner, "env_steps": env_steps, "num_games": 8, **METHODS[learner]}
    content = yaml.safe_dump({"seeds": [0, 1], "evaluation": EVALUATION, "methods": {learner: method}})
    whole, killed = folder / "whole", folder / "killed"
    for path in (whole, killed):
        path.with_suffix(".yaml").write_text(content, encoding="utf-8")
    process = begin(["reproduce", whole.with_suffix(".yaml")], whole)
    assert wait_for_workers(process), whole.with_suffix(".said").read_text()
    began = time.monotonic()
    wait_for_a_checkpoint(process, whole)
    first = time.monotonic() - began
    while workers(process.pid):
        time.sleep(0.05)
    pace = Pace(first, time.monotonic() - began - first)
    assert process.wait() == 0, whole.with_suffix(".said").read_text()
    return kill(["reproduce", killed.with_suffix(".yaml")], whole, killed, number, pace)


def kill(
    command: Sequence[str | Path], whole: Path, killed: Path, number: int, pace: Pace, early_every: int = EARLY_EVERY
) -> Result:
    """Kill the runs of a command, begin them again, and hold them against others whenever they are finished.

    :param command: the arguments of ``lawn-sb3`` that make them, in processes of their own
    :param whole: the runs that nobody kills
    :param killed: where the others go
    :param number: how many kills
    :param pace: how long the runs take that nobody kills
    :param early_every: one in so many of each kind of kill does not wait for a checkpoint; 0: all wait
    :return: what came of it
    :raises AssertionError: if anything is lost, different, or left over
    """
    said = killed.with_suffix(".said")
    chance, kills, slowest, busiest = random.Random(0), Counter[str](), 0.0, 0.0
    rounds = files = models = gone_on = later = 0
    had_checkpoint: set[Path] = set()
    share = 1.0  # of the pace: less where runs are done before they could be killed, as the machine is faster by now
    process = begin(command, killed)
    while True:
        if kills.total() == number:
            process.wait()
        elif wait_for_workers(process):
            if early_every and kills.total() // len(KINDS) % early_every == 0:
                time.sleep(chance.uniform(0.0, share * pace.first_checkpoint))
            else:
                wait_for_a_checkpoint(process, killed)
                time.sleep(chance.uniform(0.0, share * pace.after))
        pids = workers(process.pid)
        if process.poll() is not None:
            assert process.returncode == 0, said.read_text()
            equal = compare(whole, killed)
            rounds, files, models = rounds + 1, files + equal[0], models + equal[1]
            gone_on += check_resumed(killed, had_checkpoint)
            if kills.total() == number:
                return Result(kills, later, rounds, files, gone_on, models, slowest, busiest)
            share /= 2.0
            shutil.rmtree(killed)
            had_checkpoint.clear()
            process = begin(command, killed)
        elif pids:  # else it is writing its report
            share = min(1.0, 1.2 * share)
            kind = KINDS[kills.total() % len(KINDS)]
            kills[kind] += 1
            victims = [chance.choice(pids)] if kind == "worker" else pids
            if kind == "worker":
                os.kill(victims[0], signal.SIGKILL)  # its run is begun once more by itself
            elif kind == "parent":
                process.kill()
            else:
                os.killpg(process.pid, signal.SIGKILL)
            seconds, computed = seconds_until_gone(victims)
            runs = being_made(killed, victims)
            had_checkpoint = had_checkpoint - set(runs) | set(have_checkpoints(runs))
            later += bool(have_checkpoints(runs))
            if kind != "worker":
                slowest, busiest = max(slowest, seconds), max(busiest, computed)
                assert seconds <= SECONDS or computed <= CPU_SECONDS, f"a worker outlived its parent by {seconds:.1f} s"
                process.wait()
                process = begin(command, killed)


def main(number: int = 20, *learners: str) -> str:
    """Kill the runs of each learner, and print what came of it.

    :param number: how many kills of each
    :param learners: of which; by default of all
    :return: a line on all
    :raises AssertionError: if anything is lost, different, or left over
    """
    results = []
    for name in learners or METHODS:
        with tempfile.TemporaryDirectory() as made:
            results.append(torture(name, number, Path(made)))
        print(results[-1].line(name), flush=True)
    kills, later, rounds, files, gone_on, models, slowest, busiest = zip(*results, strict=True)
    sums = sum(later), sum(rounds), sum(files), sum(gone_on), sum(models)
    total = Result(sum(kills, Counter()), *sums, max(slowest), max(busiest))
    return total.line("random kills")


if __name__ == "__main__":
    count, *chosen = sys.argv[1:] or ["20"]
    print(main(int(count), *chosen))
