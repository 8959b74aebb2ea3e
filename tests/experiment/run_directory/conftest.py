"""A finished run that a test may damage."""

import pytest
from rich.console import Console

from lawn_sb3.experiment.after_training import add_scaling
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Scaling

FLOWN = Scaling(num_uavs=(1, 3), episodes=2, methods=("mappo",))


@pytest.fixture
def damaged(small_cells: list[Cell]) -> Cell:
    """The run of a learner."""
    return next(cell for cell in small_cells if cell.key == "mappo" and cell.seed == 1)


@pytest.fixture
def scaled(damaged: Cell) -> Cell:
    """The same, flown with one and three UAVs."""
    add_scaling([damaged], FLOWN, Console(quiet=True))
    return damaged
