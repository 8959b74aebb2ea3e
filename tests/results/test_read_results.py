"""Reading the runs of a recipe: what is missing or damaged is named, and all the rest is there."""

from dataclasses import replace

import pandas as pd
import pytest
import yaml
from rich.console import Console

from lawn_sb3.experiment.after_training import add_scaling
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe, Scaling
from lawn_sb3.results.results import Results, read_results

TABLES = {
    "evaluation.csv": "episodes",
    "evaluation_sampled.csv": "sampled",
    "slots.csv": "slots",
    "paths.csv": "paths",
    "progress.csv": "curves",
    "regret.csv": "regrets",
    "scaling.csv": "scaling",
}
"""File: the table that it becomes a part of."""
SCALING = Scaling(num_uavs=(1, 3), episodes=2, methods=("mappo",))


def runs_in(table: pd.DataFrame) -> set[tuple[str, int]]:
    return set(zip(table["method"], table["seed"], strict=True)) if len(table) else set()


@pytest.fixture
def asking(planned: Recipe) -> Recipe:
    return planned.model_copy(update={"scaling": SCALING})


@pytest.fixture
def learners(planned_cells: list[Cell]) -> list[Cell]:
    chosen = [cell for cell in planned_cells if cell.key == "mappo"]
    add_scaling(chosen, SCALING, Console(quiet=True))
    return chosen


@pytest.mark.parametrize("name", TABLES)
def test_a_damaged_file_is_named_and_all_the_rest_stays(asking: Recipe, learners: list[Cell], name: str) -> None:
    (learners[1].directory / name).write_text("")
    results = read_results(asking, learners)
    assert results.problems == [f"mappo seed 1: {name} cannot be read: it is empty"]
    for table in TABLES.values():
        # A run without a whole evaluation counts for nothing; any other file only for its own table.
        lost = {("mappo", 1)} if name == "evaluation.csv" or table == TABLES[name] else set()
        assert runs_in(getattr(results, table)) == {("mappo", 0), ("mappo", 1)} - lost


def test_every_row_knows_its_run(asking: Recipe, learners: list[Cell]) -> None:
    rows = read_results(asking, learners).scaling
    assert rows[["method", "seed", "num_uavs", "episodes"]].to_numpy().tolist() == [
        ["mappo", seed, num_uavs, 2] for seed in (0, 1) for num_uavs in (1, 3)
    ]


def test_a_run_that_is_not_finished_is_named_once(asking: Recipe, learners: list[Cell]) -> None:
    (learners[1].directory / "finished").unlink()
    results = read_results(asking, learners)
    assert results.problems == ["mappo seed 1: not finished, or made with another configuration"]
    assert all(runs_in(getattr(results, table)) == {("mappo", 0)} for table in TABLES.values())


def test_players_without_training_need_no_curve_and_no_sampled_play(small_cells: list[Cell], recipe: Recipe) -> None:
    results = read_results(recipe, small_cells)
    assert results.problems == []
    assert (
        runs_in(results.slots) == runs_in(results.paths) == {("random", 0), ("random", 1), ("mappo", 0), ("mappo", 1)}
    )
    assert runs_in(results.sampled) == runs_in(results.curves) == {("mappo", 0), ("mappo", 1)}


def test_a_recipe_that_samples_anyway_needs_no_second_evaluation(recipe: Recipe, small_cells: list[Cell]) -> None:
    # Its runs would be made without evaluation_sampled.csv, so it must not be missed.
    made = small_cells[-1]
    cell = replace(made, evaluation=made.evaluation.model_copy(update={"deterministic": False}))
    assert cell.method.algo == "mappo"
    (cell.directory / "evaluation_sampled.csv").unlink()
    (cell.directory / "finished").write_text(cell.fingerprint())
    (cell.directory / "config.yaml").write_text(yaml.safe_dump(cell.configuration()))
    assert read_results(recipe, [cell]).problems == []


def test_regrets_are_asked_for_by_the_recipe_and_never_of_the_bound(
    recipe: Recipe, small_cells: list[Cell], planned: Recipe, planned_cells: list[Cell]
) -> None:
    assert runs_in(read_results(planned, planned_cells).regrets) == {
        (key, seed) for key in ("random", "mappo", "equilibrium") for seed in (0, 1)
    }
    for cell in small_cells:
        (cell.directory / "regret.csv").unlink()
    without = read_results(recipe, small_cells)
    assert without.problems == []
    assert len(without.regrets) == len(without.scaling) == 0


def test_results_without_any_run_are_empty(recipe: Recipe) -> None:
    results = read_results(recipe, [])
    assert isinstance(results, Results)
    assert results.methods == {}
    assert len(results.slots) == len(results.paths) == len(results.sampled) == len(results.regrets) == 0
