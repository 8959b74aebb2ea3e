"""A cell small enough to be trained in a test."""

from pathlib import Path

import pytest

from lawn_sb3.experiment.cell import Cell
from tests.experiment.training import mappo_cell


@pytest.fixture
def small_cell(tmp_path: Path) -> Cell:
    return mappo_cell(tmp_path / "mappo" / "seed-3")
