"""The report: a pure function of the runs; what is missing or damaged is named and the rest is shown."""

from __future__ import annotations

import json
from pathlib import Path

import matplotlib.image
import pandas as pd
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.recipe import Cell, Recipe, cells
from lawn_sb3.paper.checks.kept import checks_folder
from lawn_sb3.report.document import page as page_of
from lawn_sb3.report.document import write_report
from lawn_sb3.report.page import SECTIONS, build_report
from lawn_sb3.report.style import colours
from lawn_sb3.results.curves import smoothed
from lawn_sb3.results.results import read_results

COMMAND = "lawn-sb3 report runs/small.yaml"
TABLES = {
    "table1", "table2", "comparison", "claims_headlines", "claims_summary", "claims", "first_crossing",
    "nearest_to_paper", "fairness", "low_utility_by_load", "low_utility_by_delay", "sampling", "anarchy", "regret",
}  # fmt: skip
FIGURES = {
    "fig2_convergence", "fig3_utility_cdf", "cell_loads", "low_utilities", "trajectories", "trajectories_3d",
    "regret_cdf", "fairness_tradeoff",
}  # fmt: skip
LADDER = "What a UAV must know"
"""The section of recipes whose learners differ in what they know."""
FILES = {
    "README.md",
    "report.json",
    *(f"{name}.{ending}" for name in TABLES for ending in ("md", "csv", "tex")),
    *(f"{name}.{ending}" for name in FIGURES for ending in ("png", "pdf")),
}


def reported(recipe: Recipe, runs: list[Cell], folder: Path) -> str:
    """Write a report; returns its page."""
    report, _ = build_report(recipe, runs, COMMAND)
    write_report(report, folder)
    return (folder / "README.md").read_text(encoding="utf-8")


def test_a_report_has_its_tables_figures_and_page(planned: Recipe, planned_cells: list[Cell], tmp_path: Path) -> None:
    page = reported(planned, planned_cells, tmp_path / "report")
    assert {path.name for path in (tmp_path / "report").iterdir()} == FILES
    assert "Not in this report" not in page
    assert "(-3.57)" in page  # the paper's J of Random, Table II
    assert "Scenario `paper, max_slots=20`" in page  # what the recipe changed
    for heading in SECTIONS.keys() - {LADDER}:
        assert f"## {heading}" in page
    picture = matplotlib.image.imread(tmp_path / "report" / "fig2_convergence.png")
    assert picture.std() > 0.01


def test_every_table_and_figure_is_on_the_page_with_the_command_that_made_it(
    planned: Recipe, planned_cells: list[Cell], tmp_path: Path
) -> None:
    assert {name for names in SECTIONS.values() for name in names} == TABLES | FIGURES | {*SECTIONS[LADDER]}
    page = reported(planned, planned_cells, tmp_path / "report")
    assert page.count(f"Made by `{COMMAND}`.") == len(TABLES | FIGURES)
    for name in FIGURES:
        assert f"({name}.png)" in page


def test_equal_runs_give_equal_bytes(planned: Recipe, planned_cells: list[Cell], tmp_path: Path) -> None:
    for name in ("first", "second"):
        reported(planned, planned_cells, tmp_path / name)
    for name in FILES:
        assert (tmp_path / "first" / name).read_bytes() == (tmp_path / "second" / name).read_bytes(), name


def test_the_json_file_holds_every_table_and_is_valid(
    planned: Recipe, planned_cells: list[Cell], tmp_path: Path
) -> None:
    reported(planned, planned_cells, tmp_path / "report")

    def refuse(name: str) -> None:
        raise ValueError(f"{name} is no JSON")

    content = json.loads((tmp_path / "report" / "report.json").read_text(encoding="utf-8"), parse_constant=refuse)
    assert set(content["tables"]) == TABLES
    assert content["scenario"]["max_slots"] == 20
    rows = pd.read_csv(tmp_path / "report" / "table2.csv")
    assert [row["reward"] for row in content["tables"]["table2"]] == pytest.approx(rows["reward"].tolist(), rel=1e-5)


def test_smoothing_averages_the_last_points_of_each_seed() -> None:
    curves = pd.DataFrame(
        {"method": "m", "seed": [0, 0, 0, 1], "time/env_steps": [1, 2, 3, 1], "value": [0.0, 2.0, 4.0, 8.0]}
    )
    assert smoothed(curves, "value", 2)["value"].tolist() == [0.0, 1.0, 3.0, 8.0]


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("evaluation.csv", None, "evaluation.csv"),
        ("evaluation.csv", "episode,uav\n0,0\n", "evaluation.csv"),
        ("progress.csv", "nothing\n1\n", "progress.csv"),
        ("paths.csv", "x", "paths.csv"),
        ("finished", "0123456789abcdef\n", "another configuration"),
        ("config.yaml", None, "no config.yaml there: not a run"),
    ],
)
def test_a_damaged_file_is_named_and_the_report_is_made_of_the_rest(
    recipe: Recipe, small_cells: list[Cell], tmp_path: Path, name: str, content: str | None, expected: str
) -> None:
    damaged = next(cell for cell in small_cells if cell.key == "mappo" and cell.seed == 1)
    path = damaged.directory / name
    if content is None:
        path.unlink()
    else:
        path.write_text(content)
    results = read_results(recipe, small_cells)
    assert len(results.problems) == 1
    assert "mappo seed 1" in results.problems[0]
    assert expected in results.problems[0]
    assert set(results.methods) == {"random", "mappo"}
    page = reported(recipe, small_cells, tmp_path / "report")
    assert f"- {results.problems[0]}" in page


def test_a_report_flies_nothing_and_names_what_was_not_flown_before_it(recipe: Recipe, small_cells: list[Cell]) -> None:
    (checks_folder(small_cells) / "hovering.csv").unlink()
    report, _ = build_report(recipe, small_cells, COMMAND)
    assert report.problems == [
        "checks/hovering.csv cannot be read: No such file or directory; lawn-sb3 reproduce makes it"
    ]
    claims = report.tables["claims"].numbers.set_index("id")
    assert claims.loc["iql-rate-artefact", "verdict"] == "not testable"
    assert claims.loc["iql-rate-artefact", "why"] == "Needs checks/hovering.csv, which lawn-sb3 reproduce makes."
    assert not (checks_folder(small_cells) / "hovering.csv").exists()


def test_players_that_do_not_learn_make_a_report_of_their_own(
    recipe: Recipe, small_cells: list[Cell], tmp_path: Path
) -> None:
    reported(recipe, small_cells, tmp_path / "report")  # with learners: their tables must not stay
    alone = recipe.model_copy(update={"methods": {"random": recipe.methods["random"]}})
    page = reported(alone, [cell for cell in small_cells if cell.key == "random"], tmp_path / "report")
    assert "fig3_utility_cdf.png" in page
    assert "first_crossing" not in {path.stem for path in (tmp_path / "report").iterdir()}


def test_what_needs_regrets_or_uavs_that_meet_is_left_out_without_them(
    recipe: Recipe, small_cells: list[Cell], planned: Recipe, planned_cells: list[Cell]
) -> None:
    report, _ = build_report(recipe, small_cells, COMMAND)
    assert TABLES - report.tables.keys() == {"anarchy", "regret"}
    assert FIGURES - report.figures.keys() == {"regret_cdf"}
    assert "How far from the optimum" not in page_of(report)
    alone = planned.model_copy(update={"methods": {"bound": planned.methods["bound"]}})
    report, _ = build_report(alone, [cell for cell in planned_cells if cell.key == "bound"], COMMAND)
    assert "table2" in report.tables
    assert report.figures.keys() == {"fig2_convergence", "fig3_utility_cdf"}
    assert not {"fairness", "comparison", "low_utility_by_load"} & report.tables.keys()


def test_the_bound_is_in_no_table_or_figure_of_uavs_that_meet(planned: Recipe, planned_cells: list[Cell]) -> None:
    report, _ = build_report(planned, planned_cells, COMMAND)
    assert "Bound" in set(report.tables["table2"].shown["Method"])
    for name in ("comparison", "fairness", "low_utility_by_load", "low_utility_by_delay", "regret"):
        assert "Bound" not in set(report.tables[name].shown["Method"])
    for name in ("cell_loads", "trajectories", "trajectories_3d"):
        assert len(report.figures[name][0].axes) == 3  # random, mappo, equilibrium


def test_without_any_run_there_is_no_report(recipe: Recipe, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no finished run"):
        build_report(recipe, cells(recipe, tmp_path / "empty"), COMMAND)


def test_a_method_keeps_its_colour_whatever_is_beside_it() -> None:
    everyone = colours(["random", "iql", "qmix", "mappo", "mappo-state", "mine", "yours"])
    assert len(set(everyone.values())) == 7
    for key in ("random", "mappo", "qmix"):
        assert colours([key])[key] == everyone[key]


def test_provenance_names_commit_versions_and_command(small_cells: list[Cell]) -> None:
    record = json.loads((small_cells[0].directory / "provenance.json").read_text())
    assert {"command", "commit", "versions", "hardware", "started", "train_seconds"} <= set(record)
