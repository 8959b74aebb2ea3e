"""Checkpoints with a bit flipped or cut off, at random: each training has to leave the bytes of an undamaged one.

``python -m tests.torture.damages [NUMBER]``: how many of each learner, 100 by default.
"""

import shutil
import sys
import tempfile
import warnings
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


def torture(learner: str, number: int, folder: Path) -> str:
    """Damage checkpoints of a learner.

    :param learner: its name
    :param number: how many
    :param folder: where runs may go
    :return: a line that says what came of it
    """
    make, limit = LEARNERS[learner]
    whole, cut = make(folder / "whole"), make(folder / "cut")
    run_cell(whole, ignore)
    interrupt(cut, limit)
    chance, ends = np.random.default_rng(0), {"the one before is used": 0, "the training starts anew": 0}
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
        assert all(name in notice for name in names), notice
        ends[notice.rpartition("; ")[2]] += 1
        assert_equal_runs(cell, whole)
        shutil.rmtree(cell.directory)
    return f"{learner}: {number} damages, none unnoticed, all results equal; {ends}"


if __name__ == "__main__":
    th.set_num_threads(1)
    Checkpoints.__init__.__defaults__ = (1,)  # a checkpoint whenever there can be one
    for name in LEARNERS:
        with tempfile.TemporaryDirectory() as made:
            print(torture(name, int(sys.argv[1]) if len(sys.argv) > 1 else 100, Path(made)), flush=True)
