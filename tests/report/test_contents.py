"""The report: a pure function of the runs; what is missing or damaged is named and the rest is shown."""

import json
from pathlib import Path

import matplotlib.image
import pandas as pd
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell, cells
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.paper.checks.kept import checks_folder
from lawn_sb3.report.contents import build_report
from lawn_sb3.report.document import Report, write_report
from lawn_sb3.report.document import page as page_of
from lawn_sb3.results.results import read_results

COMMAND = "lawn-sb3 report runs/small.yaml"
NEEDS_REGRETS = {"anarchy", "regret", "regret_cdf"}
NEEDS_UAVS_THAT_MEET = {
    "comparison", "cell_loads", "fairness", "fairness_tradeoff", "low_utilities", "low_utility_by_load",
    "low_utility_by_delay", "trajectories", "trajectories_3d",
}  # fmt: skip
NEEDS_LEARNERS = {"fig2_convergence", "first_crossing", "nearest_to_paper", "sampling"}
OF_THE_PAPERS_METHODS = {"claims_headlines", "claims_summary", "claims"}
ALWAYS = {"fig1_system_model", "table1", "table2", "claims_headlines", "claims_summary", "claims", "fig3_utility_cdf"}


def reported(recipe: Recipe, runs: list[Cell], folder: Path) -> str:
    write_report(build_report(recipe, runs, COMMAND), folder)
    return (folder / "README.md").read_text(encoding="utf-8")


def names_of(report: Report) -> set[str]:
    return {*report.tables, *report.figures}


def test_a_report_has_its_tables_figures_and_page(planned: Recipe, planned_cells: list[Cell], tmp_path: Path) -> None:
    report = build_report(planned, planned_cells, COMMAND)
    assert names_of(report) >= ALWAYS | NEEDS_LEARNERS | NEEDS_UAVS_THAT_MEET | NEEDS_REGRETS
    page = reported(planned, planned_cells, tmp_path / "report")
    assert {path.name for path in (tmp_path / "report").iterdir()} == {
        "README.md",
        "index.html",
        "replay.html",
        "report.json",
        *(f"{name}.{ending}" for name in report.tables for ending in ("md", "csv", "tex")),
        *(f"{name}.{ending}" for name in report.figures for ending in ("png", "pdf")),
    }
    assert "Not in this report" not in page
    assert "(-3.57)" in page  # the paper's J of Random, Table II
    assert "Scenario `paper`" in page
    picture = matplotlib.image.imread(tmp_path / "report" / "fig2_convergence.png")
    assert picture.std() > 0.01


def test_every_part_is_on_the_page_once_under_its_heading_with_the_command_that_made_it(
    planned: Recipe, planned_cells: list[Cell]
) -> None:
    report = build_report(planned, planned_cells, COMMAND)
    page = page_of(report)
    assert page.count(f"Made by `{COMMAND}`.") == len(names_of(report))
    assert all(page.count(f"({name}.png)") == 1 for name in report.figures)
    for heading in {section.heading for section in report.sections}:
        assert page.count(f"\n## {heading}\n") == 1


def test_equal_runs_give_equal_bytes(planned: Recipe, planned_cells: list[Cell], tmp_path: Path) -> None:
    for name in ("first", "second"):
        reported(planned, planned_cells, tmp_path / name)
    for path in (tmp_path / "first").iterdir():
        assert path.read_bytes() == (tmp_path / "second" / path.name).read_bytes(), path.name


def test_the_json_file_holds_every_table_and_is_valid(
    planned: Recipe, planned_cells: list[Cell], tmp_path: Path
) -> None:
    reported(planned, planned_cells, tmp_path / "report")

    def refuse(name: str) -> None:
        raise ValueError(f"{name} is no JSON")

    content = json.loads((tmp_path / "report" / "report.json").read_text(encoding="utf-8"), parse_constant=refuse)
    assert {"table1", "table2", "anarchy"} <= set(content["tables"])
    assert content["scenario"]["max_slots"] == 100
    rows = pd.read_csv(tmp_path / "report" / "table2.csv")
    assert [row["reward"] for row in content["tables"]["table2"]] == pytest.approx(rows["reward"].tolist(), rel=1e-5)


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("evaluation.csv", None, "evaluation.csv"),
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
    missing = checks_folder(small_cells) / "hovering.csv"
    missing.unlink()
    report = build_report(recipe, small_cells, COMMAND)
    assert report.problems == [
        "checks/hovering.csv cannot be read: No such file or directory; lawn-sb3 reproduce makes it"
    ]
    claims = set(report.tables["claims"].numbers["id"])
    assert "iql-rate-artefact" not in claims
    assert "table-1-grid" in claims
    assert not missing.exists()


def test_what_the_runs_do_not_give_is_left_out(
    recipe: Recipe, small_cells: list[Cell], planned: Recipe, planned_cells: list[Cell]
) -> None:
    whole = build_report(planned, planned_cells, COMMAND)
    without_regrets = build_report(recipe, small_cells, COMMAND)
    assert names_of(whole) - names_of(without_regrets) == NEEDS_REGRETS
    assert "How far from the optimum" not in page_of(without_regrets)
    alone = planned.model_copy(update={"methods": {"bound": planned.methods["bound"]}})
    of_bound = build_report(alone, [cell for cell in planned_cells if cell.key == "bound"], COMMAND)
    assert names_of(of_bound) == ALWAYS - OF_THE_PAPERS_METHODS


def test_what_an_earlier_report_had_and_this_one_lacks_is_removed(
    recipe: Recipe, small_cells: list[Cell], tmp_path: Path
) -> None:
    folder = tmp_path / "report"
    reported(recipe, small_cells, folder)
    (folder / "against_reference.md").write_text("of another command")
    alone = recipe.model_copy(update={"methods": {"random": recipe.methods["random"]}})
    players = [cell for cell in small_cells if cell.key == "random"]
    page = reported(alone, players, folder)
    assert "fig3_utility_cdf.png" in page
    left = {path.stem for path in folder.iterdir()} - {"README", "report", "index", "replay"}
    assert left == ALWAYS | (NEEDS_UAVS_THAT_MEET - {"comparison"}) | {"against_reference"}
    (folder / "report.json").write_text("{")  # damaged: what there was cannot be told, and stays
    assert reported(alone, players, folder) == page


def test_the_bound_is_in_no_table_or_figure_of_uavs_that_meet(planned: Recipe, planned_cells: list[Cell]) -> None:
    report = build_report(planned, planned_cells, COMMAND)
    assert "Bound" in set(report.tables["table2"].shown["Method"])
    for name in ("comparison", "fairness", "low_utility_by_load", "low_utility_by_delay", "regret"):
        assert "Bound" not in set(report.tables[name].shown["Method"])
    for name in ("cell_loads", "trajectories", "trajectories_3d"):
        assert len(report.figures[name].figure.axes) == 3  # random, mappo, equilibrium


def test_without_any_run_there_is_no_report(recipe: Recipe, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="no finished run"):
        build_report(recipe, cells(recipe, tmp_path / "empty"), COMMAND)
