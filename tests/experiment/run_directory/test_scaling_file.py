"""Flights with other numbers of UAVs: a file that is not whole, or of other flights, is named, and the rest is read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from lawn_sb3.experiment.after_training import fly_scaled
from lawn_sb3.experiment.recipe import Cell, Recipe, Scaling
from lawn_sb3.experiment.run_directory.csv_file import write_rows
from lawn_sb3.experiment.run_directory.files import SCALING_FILE
from lawn_sb3.results.results import Results, read_results

FLOWN = Scaling(num_uavs=(1, 3), episodes=2, methods=("random",))


@pytest.fixture
def scaled(recipe: Recipe) -> Recipe:
    """The small recipe, with such flights of its random player."""
    return recipe.model_copy(update={"scaling": FLOWN})


@pytest.fixture
def random_cells(small_cells: list[Cell]) -> list[Cell]:
    """The runs of that player, so flown."""
    chosen = [cell for cell in small_cells if cell.key == "random"]
    for cell in chosen:
        write_rows(cell.directory / SCALING_FILE, fly_scaled(cell, FLOWN))
    return chosen


def read(recipe: Recipe, cells: list[Cell]) -> Results:
    """What these runs left of such flights."""
    return read_results(recipe, cells, ("scaling",))


def test_what_was_flown_is_read_back(scaled: Recipe, random_cells: list[Cell], small_cells: list[Cell]) -> None:
    results = read(scaled, small_cells)  # with a learner that was not to be flown
    assert results.problems == []
    rows = results.scaling
    assert rows[["method", "seed", "num_uavs", "episodes"]].to_numpy().tolist() == [
        ["random", seed, num_uavs, 2] for seed in (0, 1) for num_uavs in (1, 3)
    ]
    alone = rows[rows["num_uavs"] == 1]
    assert (alone["collisions"] == 0.0).all()  # nobody to collide with
    assert alone["welfare_mbps"].tolist() == alone["utility_mbps"].tolist()


def replaced(column: str, value: float) -> Callable[[Path], None]:
    """Damage: the last value of a column is another one."""

    def damage(path: Path) -> None:
        rows = pd.read_csv(path)
        rows[column] = [*rows[column][:-1], value]
        rows.to_csv(path, index=False)

    return damage


@pytest.mark.parametrize(
    ("damage", "expected"),
    [
        (Path.unlink, "scaling.csv cannot be read: No such file"),
        (lambda path: path.write_text(""), "scaling.csv cannot be read: it is empty"),
        (lambda path: path.write_text(path.read_text()[:-2]), "scaling.csv is cut off: line"),
        (lambda path: path.write_text("city,people\nBath,94000\n"), "scaling.csv lacks the columns num_uavs"),
        (replaced("num_uavs", 8), "scaling.csv is of 1, 8 UAVs: must be 1, 3"),
        (replaced("num_uavs", 1), "scaling.csv line 3 repeats num_uavs 1: must be there once"),
        (replaced("episodes", 50), "scaling.csv is of 2, 50 episodes: must be 2"),
        (replaced("success_percent", 101.5), "scaling.csv line 3: success_percent = '101.5': must be a finite number"),
        (replaced("makespan_slots", 20.5), "scaling.csv line 3: makespan_slots = '20.5': must be a finite number"),
        (replaced("welfare_mbps", 999), "scaling.csv line 3: welfare_mbps = 999: must be num_uavs times utility_mbps"),
    ],
)
def test_a_damaged_or_foreign_file_is_named_and_the_rest_is_read(
    scaled: Recipe, random_cells: list[Cell], damage: Callable[[Path], None], expected: str
) -> None:
    damage(random_cells[1].directory / SCALING_FILE)
    results = read(scaled, random_cells)
    (problem,) = results.problems
    assert problem.startswith(f"random seed 1: {expected}")
    assert "\n" not in problem
    assert results.scaling["seed"].unique().tolist() == [0]


def test_runs_that_are_not_finished_are_named_once(scaled: Recipe, random_cells: list[Cell]) -> None:
    (random_cells[1].directory / "finished").unlink()
    results = read(scaled, random_cells)
    assert results.scaling["seed"].unique().tolist() == [0]
    assert results.problems == ["random seed 1: not finished, or made with another configuration"]


def test_a_recipe_that_asks_for_nothing_misses_nothing(recipe: Recipe, small_cells: list[Cell]) -> None:
    results = read(recipe, small_cells)
    assert results.scaling.empty
    assert results.problems == []
