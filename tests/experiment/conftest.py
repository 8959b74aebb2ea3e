"""A cell small enough to be trained in a test, and checkpoints as often as a test needs them."""

from collections.abc import Callable
from pathlib import Path

import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.checkpoint import Checkpoints
from lawn_sb3.experiment.recipe import Evaluation, Method
from lawn_sb3.experiment.watching import Watch
from lawn_sb3.scenario import PRESETS

SMALL_EVALUATION = Evaluation(episodes=5, record_every=1, watch_every=100, watch_episodes=3)


@pytest.fixture
def small_cell(tmp_path: Path) -> Cell:
    """Four rollouts of MAPPO on two games."""
    method = Method(
        label="MAPPO",
        algo="mappo",
        env_steps=256,
        num_games=2,
        settings={"n_steps": 32, "batch_size": 64, "n_epochs": 2, "learning_rate": "lin_1e-3", "ent_coef": "lin_0.02"},
    )
    scenario = PRESETS["paper"].changed(max_slots=20)
    return Cell("mappo", method, 3, scenario, SMALL_EVALUATION, tmp_path / "mappo" / "seed-3")


@pytest.fixture
def checkpoint_every(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], None]:
    original = Checkpoints.__init__

    def choose(every: int) -> None:
        def chosen(self: Checkpoints, cell: Cell, watch: Watch) -> None:
            original(self, cell, watch, every=every)

        monkeypatch.setattr(Checkpoints, "__init__", chosen)

    return choose


@pytest.fixture
def often(checkpoint_every: Callable[[int], None]) -> None:
    checkpoint_every(1)
