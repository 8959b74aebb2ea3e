"""Runs small enough to be made in a test: a player without training and a short MAPPO, two seeds each."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from lawn_sb3.experiment.cell import run_cell
from lawn_sb3.experiment.recipe import Cell, Recipe, cells, load_recipe

RECIPE = """
title: A small comparison
seeds: [0, 1]
set: [max_slots=20]
evaluation: {episodes: 6, record_every: 1, watch_every: 100, watch_episodes: 3}
methods:
  random: {label: Random, paper_row: Random, player: random}
  mappo:
    label: CTDE-MAPPO
    paper_row: CTDE-MAPPO
    algo: mappo
    env_steps: 192
    num_games: 2
    settings: {n_steps: 32, batch_size: 64, n_epochs: 1}
"""


@pytest.fixture(scope="session")
def finished_runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recipe with all its runs."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "small.yaml").write_text(RECIPE, encoding="utf-8")
    for cell in cells(load_recipe(folder / "small.yaml"), folder / "small"):
        run_cell(cell, lambda env_steps: None)
    return folder


@pytest.fixture
def runs(finished_runs: Path, tmp_path: Path) -> Path:
    """A copy of them that a test may damage."""
    return Path(shutil.copytree(finished_runs, tmp_path / "runs"))


@pytest.fixture
def recipe(runs: Path) -> Recipe:
    """The recipe."""
    return load_recipe(runs / "small.yaml")


@pytest.fixture
def small_cells(runs: Path, recipe: Recipe) -> list[Cell]:
    """Its cells."""
    return cells(recipe, runs / "small")
