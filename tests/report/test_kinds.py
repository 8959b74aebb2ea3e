"""The reports of ablations and of changed games: what they hold, and what they say is missing."""

import shutil
from pathlib import Path

import pandas as pd
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import cells
from lawn_sb3.experiment.recipe import Recipe, load_recipe
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.report.contents import build_report
from lawn_sb3.report.document import Report, write_report


def report_of(recipe: Recipe, runs: Path) -> Report:
    return build_report(recipe, cells(recipe, runs), "lawn-sb3 report")


@pytest.fixture
def twins(runs: Path, recipe: Recipe) -> Recipe:
    """The small recipe with an ablation that changes nothing: a copy of the default's runs."""
    shutil.copytree(runs / "small" / "mappo", runs / "small" / "twin")
    twin = recipe.methods["mappo"].model_copy(update={"label": "Twin", "paper_row": None, "baseline": "mappo"})
    return recipe.model_copy(update={"methods": {**recipe.methods, "twin": twin}})


def test_the_report_holds_effects_and_learning_and_names_every_file(twins: Recipe, runs: Path, tmp_path: Path) -> None:
    report = report_of(twins, runs / "small")
    assert report.problems == []
    write_report(report, tmp_path)
    page = (tmp_path / "README.md").read_text(encoding="utf-8")
    for name in ("effects_forest.png", "learning_curves.png"):
        assert f"({name})" in page
        assert (tmp_path / name).exists()
    assert "| Twin " in page
    assert pd.read_csv(tmp_path / "effects.csv").set_index("key").loc["twin", "reward"] == 0.0


def test_an_ablation_whose_default_has_no_run_is_named(twins: Recipe, runs: Path) -> None:
    shutil.rmtree(runs / "small" / "mappo")
    report = report_of(twins, runs / "small")
    assert "twin: not among the effects, as there is no whole run of mappo" in report.problems
    assert "effects" not in report.tables


@pytest.fixture
def varied(tmp_path: Path) -> Path:
    path = tmp_path / "varied.yaml"
    path.write_text(
        "seeds: [0, 1]\nset: [max_slots=10]\nevaluation: {episodes: 5}\n"
        "variants: {as-is: [], loud: [tx_power_dbm=30]}\n"
        "methods:\n  random: {label: Random, player: random}\n  straight: {label: Straight, player: shortest-path}\n",
        encoding="utf-8",
    )
    for cell in cells(load_recipe(path), tmp_path / "varied"):
        run_cell(cell, lambda env_steps: None)
    return path


def test_a_recipe_with_changed_games_has_a_report_of_its_own(varied: Path) -> None:
    runs, report = varied.with_suffix(""), report_of(load_recipe(varied), varied.with_suffix(""))
    numbers = report.tables["ranking_utility_mbps"].numbers.set_index(["game", "method"])["value"]
    assert numbers["loud", "straight"] > numbers["as-is", "straight"]  # ten times the power
    write_report(report, runs / "report")
    page = (runs / "report" / "README.md").read_text(encoding="utf-8")
    assert "| loud" in page
    assert "leads.png" in page


def test_a_missing_run_is_named_with_its_game(varied: Path) -> None:
    runs = varied.with_suffix("")
    (runs / "loud" / "random" / "seed-1" / "finished").unlink()
    report = report_of(load_recipe(varied), varied.with_suffix(""))
    assert report.problems == ["loud random seed 1: not finished, or made with another configuration"]


def test_without_the_game_as_it_is_there_is_nothing_to_compare_with(varied: Path) -> None:
    runs = varied.with_suffix("")
    for marker in (runs / "as-is").rglob("finished"):
        marker.unlink()
    with pytest.raises(UserError, match="no finished run of 'as-is'"):
        report_of(load_recipe(varied), varied.with_suffix(""))
