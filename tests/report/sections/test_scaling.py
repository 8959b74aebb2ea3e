"""Scaling out: means over seeds by number of UAVs; a file that is not whole, or of other flights, is named."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from lawn_sb3.experiment.cell import SCALING_FILE, write_rows
from lawn_sb3.experiment.recipe import Cell, Recipe, Scaling, cells
from lawn_sb3.experiment.scaling import fly_scaled
from lawn_sb3.report.sections.scaling import read_scaling, scaling_figure, scaling_table
from tests.handmade import learner, recipe_with

FLOWN = Scaling(num_uavs=(1, 3), episodes=2, methods=("random",))


def rows_of(method: str, seed: int, utility_mbps: list[float], num_uavs: tuple[int, ...] = (1, 4)) -> pd.DataFrame:
    """Flights of one run with these utilities."""
    rows = pd.DataFrame({"method": method, "seed": seed, "num_uavs": num_uavs, "episodes": 7})
    dull = {"reward": 0.0, "rate_mbps": 1.0, "makespan_slots": 4.0, "completion_slots": 3.0, "success_percent": 50.0}
    rows = rows.assign(**dull, utility_mbps=utility_mbps, collisions=[0.0, 0.5])
    return rows.assign(welfare_mbps=rows["utility_mbps"] * rows["num_uavs"])


HANDMADE = recipe_with({"mappo": learner("MAPPO"), "blind": learner("Blind").model_copy(update={"baseline": "mappo"})})
ROWS = pd.concat(
    [
        rows_of("mappo", 0, [40.0, 10.0]),
        rows_of("mappo", 1, [50.0, 20.0]),
        rows_of("blind", 0, [30.0, 5.0]),
        rows_of("blind", 1, [30.0, 5.0]),
    ],
    ignore_index=True,
)


@pytest.fixture
def flown(runs: Path, recipe: Recipe) -> tuple[Recipe, list[Cell]]:
    """The small recipe, its random player flown with one and three UAVs."""
    recipe = recipe.model_copy(update={"scaling": FLOWN})
    made = cells(recipe, runs / "small")
    for cell in made:
        if cell.key == "random":
            write_rows(cell.directory / SCALING_FILE, fly_scaled(cell, FLOWN))
    return recipe, made


def test_what_was_flown_is_read_back(flown: tuple[Recipe, list[Cell]]) -> None:
    problems: list[str] = []
    rows = read_scaling(*flown, problems)
    assert problems == []
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
    flown: tuple[Recipe, list[Cell]], damage: Callable[[Path], None], expected: str
) -> None:
    recipe, made = flown
    damaged = next(cell for cell in made if cell.key == "random" and cell.seed == 1)
    damage(damaged.directory / SCALING_FILE)
    problems: list[str] = []
    rows = read_scaling(recipe, made, problems)
    (problem,) = problems
    assert problem.startswith(f"random seed 1: {expected}")
    assert "\n" not in problem
    assert rows["seed"].unique().tolist() == [0]


def test_runs_that_are_not_finished_are_passed_over(flown: tuple[Recipe, list[Cell]]) -> None:
    recipe, made = flown
    next(cell for cell in made if cell.key == "random" and cell.seed == 1).directory.joinpath("finished").unlink()
    problems: list[str] = []
    assert read_scaling(recipe, made, problems)["seed"].unique().tolist() == [0]
    assert problems == []


def test_a_recipe_that_asks_for_nothing_misses_nothing(recipe: Recipe, small_cells: list[Cell]) -> None:
    problems: list[str] = []
    assert read_scaling(recipe, small_cells, problems).empty
    assert problems == []


def test_the_table_by_hand() -> None:
    # Seeds with 40 and 50: mean 45, resampled between 40 and 50.
    table = scaling_table(ROWS, HANDMADE)
    shown = table.shown[table.shown["Quantity"] == "U (Mbps)"].set_index("Method")
    assert shown.loc["MAPPO"].tolist() == ["U (Mbps)", "45.00 [40.00, 50.00]", "15.00 [10.00, 20.00]", "2 × 7"]
    assert shown.loc["MAPPO: Blind", "N = 1"] == "30.00 [30.00, 30.00]"  # an ablation says of what
    numbers = table.numbers.set_index(["key", "num_uavs"])
    assert numbers.loc[("mappo", 4), "welfare_mbps"] == 60.0  # 4 * (10 + 20) / 2
    assert numbers.loc[("mappo", 4), "makespan_slots"] == 4.0


def test_the_order_of_runs_does_not_matter() -> None:
    forward, backward = (scaling_table(rows, HANDMADE) for rows in (ROWS, ROWS[::-1].reset_index(drop=True)))
    pd.testing.assert_frame_equal(forward.numbers, backward.numbers)


def test_the_figure_shows_the_means_and_where_actors_were_trained() -> None:
    figure = scaling_figure(ROWS, HANDMADE)
    assert len(figure.axes) == 3
    utility = figure.axes[0]
    mappo, blind, trained = utility.lines
    assert mappo.get_xydata().tolist() == [[1.0, 45.0], [4.0, 15.0]]
    assert blind.get_xydata().tolist() == [[1.0, 30.0], [4.0, 5.0]]
    assert set(np.asarray(trained.get_xdata())) == {HANDMADE.game().num_uavs} == {4}
    assert [text.get_text() for text in utility.get_xticklabels()] == ["1", "4"]
    assert (mappo.get_color(), mappo.get_marker()) != (blind.get_color(), blind.get_marker())
