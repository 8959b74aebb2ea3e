"""Checkpoints with a bit flipped or cut off, at random: each training has to leave the bytes of an undamaged one.

``python -m tests.torture.damages [NUMBER]``: how many of each learner, 100 by default.
"""

import shutil
import sys
import tempfile
import warnings
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import torch as th

from lawn_sb3.errors import Notice
from lawn_sb3.experiment.checkpoint import Checkpoints
from lawn_sb3.experiment.run_directory.files import CHECKPOINT_BEFORE_FILE, CHECKPOINT_FILE
from lawn_sb3.experiment.train import run_cell
from tests.experiment.test_damaged_checkpoints import LEARNERS, damaged
from tests.experiment.training import assert_equal_runs, ignore, interrupt

BOTH_EVERY = 5
"""One in so many has both checkpoints damaged."""


ENDS = ("the one before is used", "the training starts anew")
"""What a damage may end in."""


def torture(learner: str, number: int, folder: Path) -> Counter[str]:
    """Damage checkpoints of a learner.

    :param learner: its name
    :param number: how many
    :param folder: where runs may go
    :return: how often which of the ends came about; all were noticed, and left equal runs
    :raises AssertionError: if a damage goes unnoticed, or alters what is left
    """
    make, limit = LEARNERS[learner]
    whole, cut = make(folder / "whole"), make(folder / "cut")
    run_cell(whole, ignore)
    interrupt(cut, limit)
    chance, ends = np.random.default_rng(0), Counter[str]()
    for count in range(number):
        cell = replace(cut, directory=folder / "damaged")
        shutil.copytree(cut.directory, cell.directory)
        names = (CHECKPOINT_FILE, CHECKPOINT_BEFORE_FILE)[: 1 if count % BOTH_EVERY else 2]
        for path in (cell.directory / name for name in names):
            path.write_bytes(damaged(path.read_bytes(), chance))
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", Notice)
            run_cell(cell, ignore)
        (notice,) = [str(one.message) for one in told if issubclass(one.category, Notice)]
        end = notice.rpartition("; ")[2]
        assert all(str(cell.directory / name) in notice for name in names), notice
        assert end == ENDS[len(names) - 1], notice
        ends[end] += 1
        assert_equal_runs(cell, whole)
        shutil.rmtree(cell.directory)
    return ends


def line(name: str, ends: Counter[str]) -> str:
    """Say in one line what came of damages."""
    return (
        f"{name}: {ends.total()} damages noticed, {ends[ENDS[0]]} resumed from the checkpoint before, {ends[ENDS[1]]} "
        "begun anew; all raw files and weights equal"
    )


def main(number: int = 100) -> str:
    """Damage checkpoints of each learner, and print what came of it.

    :param number: how many of each
    :return: a line on all
    :raises AssertionError: if a damage goes unnoticed, or alters what is left
    """
    th.set_num_threads(1)
    Checkpoints.__init__.__defaults__ = (1,)  # a checkpoint whenever there can be one
    total = Counter[str]()
    for name in LEARNERS:
        with tempfile.TemporaryDirectory() as made:
            ends = torture(name, number, Path(made))
        print(line(name, ends), flush=True)
        total += ends
    return line("damaged checkpoints", total)


if __name__ == "__main__":
    print(main(*map(int, sys.argv[1:])))
