"""Sensitivity: figures and ranks by changed game, and the pairs that change places beyond what seeds explain."""

from __future__ import annotations

from pathlib import Path

import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import run_cell
from lawn_sb3.experiment.recipe import cells, load_recipe
from lawn_sb3.report.contents import build_report
from lawn_sb3.report.document import Report, write_report
from lawn_sb3.report.sections.ranking import ranking
from lawn_sb3.results.results import Results
from tests.handmade import flown, learner, recipe_with, results_of

RECIPE = recipe_with({"one": learner("One"), "two": learner("Two")})


def game(one: tuple[float, float], two: tuple[float, float]) -> Results:
    """Two seeds of two methods, one mission each."""
    return results_of(
        RECIPE,
        *(flown("one", seed, reward=[reward]) for seed, reward in enumerate(one)),
        *(flown("two", seed, reward=[reward]) for seed, reward in enumerate(two)),
    )


def moved(before: Results, after: Results) -> str:
    """What the table says of the changed game."""
    return str(ranking({"as-is": before, "changed": after}, "reward").shown.iloc[1]["Changed places"])


def test_figures_and_ranks_by_hand() -> None:
    shown = ranking({"as-is": game((3.0, 3.2), (2.0, 2.0))}, "reward").shown.iloc[0]
    assert shown["One"] == "3.10 [3.00, 3.20] (1.)"
    assert shown["Two"] == "2.00 [2.00, 2.00] (2.)"
    assert shown["n"] == "2 × 200"


def test_a_pair_that_is_apart_in_both_games_changes_places() -> None:
    assert moved(game((3.0, 3.2), (2.0, 2.1)), game((1.0, 1.1), (2.0, 2.1))) == "Two above One"


def test_a_pair_that_seeds_do_not_tell_apart_has_not_changed_places() -> None:
    assert moved(game((3.0, 3.2), (2.0, 2.1)), game((1.0, 3.0), (2.0, 2.1))) == "none"
    assert moved(game((3.0, 3.2), (2.0, 2.1)), game((3.0, 3.1), (2.0, 2.1))) == "none"


def report_of(path: Path, runs: Path | None = None) -> Report:
    """The report of a recipe's runs, by default those beside it."""
    recipe = load_recipe(path)
    return build_report(recipe, cells(recipe, runs or path.with_suffix("")), "lawn-sb3 report varied.yaml")


@pytest.fixture
def varied(tmp_path: Path) -> Path:
    """A recipe with two games that needs no training, run."""
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
    runs, report = varied.with_suffix(""), report_of(varied)
    numbers = report.tables["ranking_utility_mbps"].numbers.set_index(["game", "method"])["value"]
    assert numbers["loud", "straight"] > numbers["as-is", "straight"]  # ten times the power
    write_report(report, runs / "report")
    page = (runs / "report" / "README.md").read_text(encoding="utf-8")
    assert "| loud" in page
    assert "leads.png" in page


def test_a_missing_run_is_named_with_its_game(varied: Path) -> None:
    runs = varied.with_suffix("")
    (runs / "loud" / "random" / "seed-1" / "finished").unlink()
    report = report_of(varied)
    assert report.problems == ["loud random seed 1: not finished, or made with another configuration"]


def test_without_any_run_there_is_no_report(varied: Path, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no finished run"):
        report_of(varied, tmp_path / "nowhere")


def test_without_the_game_as_it_is_there_is_nothing_to_compare_with(varied: Path) -> None:
    runs = varied.with_suffix("")
    for marker in (runs / "as-is").rglob("finished"):
        marker.unlink()
    with pytest.raises(UserError, match="no finished run of 'as-is'"):
        report_of(varied)
