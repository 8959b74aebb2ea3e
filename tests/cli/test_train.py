"""What ``lawn-sb3 train`` trains: the settings it starts from, and what the options change."""

from collections.abc import Callable
from pathlib import Path

import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import load_recipe
from lawn_sb3.experiment.registry import REPOSITORY
from tests.cli.running import exit_status

PAPER = str(REPOSITORY / "runs" / "paper.yaml")


@pytest.fixture
def trained(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., Cell]:
    cells: list[Cell] = []
    monkeypatch.setattr("lawn_sb3.cli.train.run_cell", lambda cell, advance: cells.append(cell))

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
