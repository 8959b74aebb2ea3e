"""What ``lawn-sb3 train`` trains: the settings it starts from, and what the options change."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.experiment.recipe import load_recipe
from lawn_sb3.experiment.registry import REPOSITORY
from tests.cli.running import QUICK, Lawn, exit_status

PAPER = str(REPOSITORY / "runs" / "paper.yaml")


@pytest.fixture
def trained(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., Cell]:
    cells: list[Cell] = []
    monkeypatch.setattr("lawn_sb3.experiment.train.run_cell", lambda cell, advance: cells.append(cell))
    monkeypatch.setattr("lawn_sb3.cli.train._show_result", lambda cell: None)

    def train(*options: str) -> Cell:
        assert exit_status("train", "--out", tmp_path / "mine", *options) == 0
        return cells.pop()

    return train


def test_an_algorithm_is_trained_with_the_papers_settings_for_it(trained: Callable[..., Cell]) -> None:
    paper = load_recipe(Path(PAPER)).methods
    for options, key in (((), "mappo"), (("--algo", "qmix"), "qmix"), (("--policy", "state_critic"), "mappo-state")):
        own = trained(*options).method
        changes = {"label": "mine", "paper_row": None}
        assert own == paper[key].model_copy(update=changes), key


def test_options_change_what_they_name_alone(trained: Callable[..., Cell]) -> None:
    cell = trained(
        "--recipe", PAPER, "--method", "iql", "--seed", "7", "--env-steps", "50", "-params", "gamma=0.5",
        "--set", "num_uavs=2",
    )  # fmt: skip
    recipe = load_recipe(Path(PAPER))
    method = recipe.methods["iql"]
    settings = {**method.settings, "gamma": 0.5}
    assert cell.method == method.model_copy(update={"env_steps": 50, "settings": settings})
    assert (cell.seed, cell.scenario) == (7, recipe.game().changed(num_uavs=2))
    assert (cell.evaluation, cell.regret) == (recipe.evaluation, recipe.regret)


def test_a_method_whose_learners_share_a_network_is_labelled_as_such(trained: Callable[..., Cell]) -> None:
    assert trained("--algo", "iql", "-params", "share_parameters=true").method.label == "mine, shared network"


def test_a_training_ends_with_what_it_reached_and_how_long_it_was(
    lawn: Lawn, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")
    said = lawn("train", "--out", tmp_path / "mine", "--num-games", "2", "--env-steps", "100", *QUICK)
    assert "trained 128 env steps: whole rollouts, so not just the 100 asked for" in said.err
    rows = {line.split()[1]: line.split() for line in said.out.splitlines() if line.startswith("│")}
    assert rows["utility"][-2] == "Mbps"
    summary = summarize(pd.read_csv(tmp_path / "mine" / "evaluation.csv"))
    assert rows["success"][3] == f"{summary['success_percent']:.3f}"
    assert "±" in rows["reward"]
    again = lawn("train", "--out", tmp_path / "mine", "--num-games", "2", "--env-steps", "100", *QUICK)
    assert again.out == said.out
