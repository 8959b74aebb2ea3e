"""What all tests share: settings, and small runs of players without training and of a short MAPPO."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
import torch as th
from hypothesis import settings
from rich.console import Console

from lawn_sb3.experiment.after_training import add_regrets
from lawn_sb3.experiment.cell import Cell, cells
from lawn_sb3.experiment.checkpoint import Checkpoints
from lawn_sb3.experiment.recipe import Recipe, load_recipe
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.paper.making import fly_checks
from tests.cli.running import Lawn, Said, exit_status

# The first example of a test may have to wait for Numba to compile.
settings.register_profile("kit", deadline=None)
settings.load_profile("kit")

RECIPE = """
title: A small comparison
seeds: [0, 1]
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
PLANNED = f"""{RECIPE}
  equilibrium: {{label: Equilibrium, player: equilibrium}}
  bound: {{label: Bound, player: bound}}
regret: true
"""
"""The same with two planners and with regrets, its runs in the same folder."""


@pytest.fixture(scope="session", autouse=True)
def _one_torch_thread() -> None:
    """Small networks are fastest on one thread, and with one alone the same seed gives the same numbers."""
    th.set_num_threads(1)


@pytest.fixture(scope="session", autouse=True)
def _no_folders_left_by_loggers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """SB3 makes a folder in the system's own for each model that learns without a logger of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SB3_LOGDIR", str(tmp_path_factory.mktemp("loggers")))
        yield


@pytest.fixture(scope="session")
def finished_runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Both recipes with all their runs."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "small.yaml").write_text(RECIPE, encoding="utf-8")
    (folder / "planned.yaml").write_text(PLANNED, encoding="utf-8")
    todo = cells(load_recipe(folder / "planned.yaml"), folder / "small")
    for cell in todo:
        run_cell(cell, lambda env_steps: None)
    quiet = Console(quiet=True)
    add_regrets(todo, quiet)
    for name in ("small", "planned"):
        recipe = load_recipe(folder / f"{name}.yaml")
        fly_checks(recipe, cells(recipe, folder / "small"), quiet)
    return folder


@pytest.fixture
def runs(finished_runs: Path, tmp_path: Path) -> Path:
    """A copy of them that a test may damage: no manifest vouches for what it holds."""
    without = shutil.ignore_patterns("manifest.json")
    return Path(shutil.copytree(finished_runs, tmp_path / "runs", ignore=without))


@pytest.fixture
def recipe(runs: Path) -> Recipe:
    return load_recipe(runs / "small.yaml")


@pytest.fixture
def small_cells(runs: Path, recipe: Recipe) -> list[Cell]:
    return cells(recipe, runs / "small")


@pytest.fixture
def planned(runs: Path) -> Recipe:
    return load_recipe(runs / "planned.yaml")


@pytest.fixture
def planned_cells(runs: Path, planned: Recipe) -> list[Cell]:
    return cells(planned, runs / "small")


@pytest.fixture
def lawn(capfd: pytest.CaptureFixture[str]) -> Lawn:
    """The command line; bad input, status 2, has to be refused in one line with nothing on standard output."""

    def run(*arguments: str | Path, status: int = 0) -> Said:
        capfd.readouterr()
        ended = exit_status(*arguments)
        said = Said(*capfd.readouterr())
        assert ended == status, said.err
        if status == 2:
            assert (said.out, len(said.err.splitlines())) == ("", 1), said
        return said

    return run


@pytest.fixture
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """A checkpoint whenever there can be one."""
    original = Checkpoints.__init__
    monkeypatch.setattr(Checkpoints, "__init__", lambda self, cell, watch: original(self, cell, watch, every=1))
