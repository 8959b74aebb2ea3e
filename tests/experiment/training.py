"""Short trainings for tests: interrupted, resumed, and compared file by file."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
import torch as th
from stable_baselines3.common.save_util import load_from_zip_file

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.run_directory.files import CONFIG_FILE, PROVENANCE_FILE, RESULT_FILES
from lawn_sb3.experiment.train import run_cell


class InterruptionError(Exception):
    """Stands for whatever ends a training early."""


def ignore(env_steps: int) -> None:
    """A progress report nobody reads."""


def interrupted_at(limit: int) -> Callable[[int], None]:

    def report(env_steps: int) -> None:
        if env_steps >= limit:
            raise InterruptionError

    return report


def parameters(cell: Cell) -> dict[str, th.Tensor]:
    _, saved, _ = load_from_zip_file(cell.directory / "model.zip", load_data=False)
    return dict(saved["policy"])


def assert_equal_runs(one: Cell, other: Cell) -> None:
    """Both left the same files with the same bytes, times aside, and the same weights."""
    for name in {CONFIG_FILE, *RESULT_FILES} - {PROVENANCE_FILE}:
        first, second = (cell.directory / name for cell in (one, other))
        assert first.exists() == second.exists(), name
        assert not first.exists() or first.read_bytes() == second.read_bytes(), name
    for name, weights in parameters(one).items():
        assert th.equal(weights, parameters(other)[name]), name


def resumed(cell: Cell, limit: int) -> list[int]:
    """Interrupt a cell's training and resume it; it must leave what an uninterrupted one does.

    Returns the env steps that were reported after the interruption.
    """
    whole = replace(cell, directory=cell.directory.with_name("whole"))
    run_cell(whole, ignore)
    with pytest.raises(InterruptionError):
        run_cell(cell, interrupted_at(limit))
    np.random.seed(0)
    th.manual_seed(0)
    reports: list[int] = []
    run_cell(cell, reports.append)
    assert_equal_runs(cell, whole)
    return reports
