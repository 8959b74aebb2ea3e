"""Short trainings for tests: interrupted, resumed, and compared file by file."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch as th
from stable_baselines3.common.save_util import load_from_zip_file

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Evaluation, Method
from lawn_sb3.experiment.run_directory.files import (
    CONFIG_FILE,
    MODEL_FILE,
    PROVENANCE_FILE,
    RESULT_FILES,
    TENSORS_FILE,
)
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.scenario import PRESETS

SMALL_EVALUATION = Evaluation(episodes=5, record_every=1, watch_every=100, watch_episodes=3)


def small_cell_of(algo: str, directory: Path, max_slots: int, settings: dict[str, Any], **values: Any) -> Cell:
    """A cell that is trained in a moment."""
    scenario, more = PRESETS["paper"].changed(max_slots=max_slots), {"label": algo.upper(), "settings": settings}
    method = Method.model_validate({"algo": algo, "num_games": 2, **more, **values})
    return Cell(algo, method, 3, scenario, SMALL_EVALUATION, directory)


def mappo_cell(directory: Path, policy: str = "centralized_critic", **settings: Any) -> Cell:
    """Four rollouts on two games."""
    settings = {
        "n_steps": 32, "batch_size": 64, "n_epochs": 2, "learning_rate": "lin_1e-3", "ent_coef": "lin_0.02",
        **settings,
    }  # fmt: skip
    return small_cell_of("mappo", directory, 20, settings, policy=policy, env_steps=256)


def iql_cell(directory: Path, policy: str = "local_q", **settings: Any) -> Cell:
    """Twenty vector steps on two games; the replay of eighteen wraps around."""
    settings = {
        "buffer_size": 36, "learning_starts": 16, "batch_size": 16, "train_freq": 1, "target_update_interval": 6,
        "exploration_fraction": 0.5, "learning_rate": "lin_1e-3", "policy_kwargs": {"net_arch": [16]}, **settings,
    }  # fmt: skip
    return small_cell_of("iql", directory, 8, settings, policy=policy, env_steps=40)


def qmix_cell(directory: Path, policy: str = "monotonic_mixer") -> Cell:
    """Forty vector steps on three games, with a replay that overflows."""
    settings = {
        "buffer_size": 60, "learning_starts": 80, "batch_size": 16, "target_update_interval": 7,
        "learning_rate": "lin_1e-3", "gamma": 0.85, "policy_kwargs": {"net_arch": [16]},
    }  # fmt: skip
    return small_cell_of("qmix", directory, 9, settings, policy=policy, env_steps=120, num_games=3)


def ignore(env_steps: int) -> None:
    """A progress report nobody reads."""


def interrupt(cell: Cell, limit: int) -> None:
    """Train a cell until whatever ends a training early, after some env steps."""

    def report(env_steps: int) -> None:
        if env_steps >= limit:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_cell(cell, report)


def parameters(cell: Cell) -> dict[str, th.Tensor]:
    _, saved, _ = load_from_zip_file(cell.directory / "model.zip", load_data=False)
    return dict(saved["policy"])


def assert_equal_runs(one: Cell, other: Cell) -> None:
    """Both left the same files with the same bytes, the model too, times aside, and the same weights."""
    for name in {CONFIG_FILE, MODEL_FILE, TENSORS_FILE, *RESULT_FILES} - {PROVENANCE_FILE}:
        first, second = (cell.directory / name for cell in (one, other))
        assert first.exists() == second.exists(), name
        assert not first.exists() or first.read_bytes() == second.read_bytes(), name
    for name, weights in parameters(one).items():
        assert th.equal(weights, parameters(other)[name]), name


def resumed(cell: Cell, limit: int, meanwhile: Callable[[Cell], None] = lambda cell: None) -> list[int]:
    """Env steps reported by a training once it is resumed, which has to leave what an uninterrupted one does."""
    whole = replace(cell, directory=cell.directory.with_name("whole"))
    run_cell(whole, ignore)
    interrupt(cell, limit)
    meanwhile(cell)
    np.random.seed(0)
    th.manual_seed(0)
    reports: list[int] = []
    run_cell(cell, reports.append)
    assert_equal_runs(cell, whole)
    return reports
