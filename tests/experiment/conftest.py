"""A cell small enough to be trained in a test, and checkpoints as often as a test needs them."""

from pathlib import Path

import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.checkpoint import Checkpoints
from tests.experiment.training import mappo_cell


@pytest.fixture
def small_cell(tmp_path: Path) -> Cell:
    return mappo_cell(tmp_path / "mappo" / "seed-3")


@pytest.fixture
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """A checkpoint whenever there can be one."""
    original = Checkpoints.__init__
    monkeypatch.setattr(Checkpoints, "__init__", lambda self, cell, watch: original(self, cell, watch, every=1))
