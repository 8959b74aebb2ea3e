"""The report: a pure function of the runs; what is missing or damaged is named and the rest is shown."""

from __future__ import annotations

import json
from pathlib import Path

import matplotlib.image
import numpy as np
import pandas as pd
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.evaluation import COLUMNS
from lawn_sb3.experiment.recipe import Cell, Recipe
from lawn_sb3.report.figures import smoothed
from lawn_sb3.report.page import baseline_verdicts, first_crossing, nearest_to_paper, write_report
from lawn_sb3.report.results import Results, read_results
from lawn_sb3.report.style import colours
from lawn_sb3.report.table_two import as_markdown, table_two

FILES = {
    "README.md", "table2.md", "table2.csv", "table2.tex",
    "fig2_convergence.png", "fig2_convergence.pdf", "fig3_utility_cdf.png", "fig3_utility_cdf.pdf",
}  # fmt: skip


SOURCE = Path("runs/small.yaml")


def rows(arrived: bool, utility_mbps: float) -> pd.DataFrame:
    """One episode of one UAV."""
    values = (0, 0, 1.0, 30.0, 5, 5, arrived, utility_mbps, 0, 5, 1.0)
    return pd.DataFrame([values], columns=list(COLUMNS))


def test_a_report_has_its_tables_figures_and_page(recipe: Recipe, small_cells: list[Cell], tmp_path: Path) -> None:
    results = write_report(recipe, small_cells, tmp_path / "report", SOURCE)
    assert results.problems == []
    assert {path.name for path in (tmp_path / "report").iterdir()} == FILES
    page = (tmp_path / "report" / "README.md").read_text(encoding="utf-8")
    assert "Not in this report" not in page
    assert "| Random" in page
    assert "(-3.57)" in page  # the paper's J of Random, Table II
    picture = matplotlib.image.imread(tmp_path / "report" / "fig2_convergence.png")
    assert picture.std() > 0.01


def test_equal_runs_give_equal_bytes(recipe: Recipe, small_cells: list[Cell], tmp_path: Path) -> None:
    for name in ("first", "second"):
        write_report(recipe, small_cells, tmp_path / name, SOURCE)
    for name in FILES:
        assert (tmp_path / "first" / name).read_bytes() == (tmp_path / "second" / name).read_bytes(), name


def test_table_two_by_hand(recipe: Recipe) -> None:
    # Random: seed 0 fails (0 %), seed 1 arrives (100 %): mean 50, standard deviation 100 / sqrt(2) = 70.71.
    parts = []
    for method, seed, arrived, utility in [
        ("random", 0, False, 0.0),
        ("random", 1, True, 20.0),
        ("mappo", 0, True, 40.0),
    ]:
        own = rows(arrived, utility)
        own.insert(0, "seed", seed)
        own.insert(0, "method", method)
        parts.append(own)
    table = table_two(Results(recipe, pd.concat(parts, ignore_index=True))).set_index("method")
    assert table.loc["Random", "success_percent"] == 50.0
    assert table.loc["Random", "success_percent_sd"] == pytest.approx(70.7107, abs=1e-4)
    assert table.loc["Random", "utility_mbps"] == 10.0
    assert table.loc["Random", "success_percent_paper"] == 22.4
    assert table.loc["CTDE-MAPPO", "makespan_slots_paper"] == 8.7
    assert table.loc["CTDE-MAPPO", "seeds"] == 1
    assert np.isnan(table.loc["CTDE-MAPPO", "success_percent_sd"])
    assert "50.0 ± 70.7 (22.4)" in as_markdown(table.reset_index())


def test_smoothing_averages_the_last_points_of_each_seed() -> None:
    curves = pd.DataFrame(
        {"method": "m", "seed": [0, 0, 0, 1], "time/env_steps": [1, 2, 3, 1], "value": [0.0, 2.0, 4.0, 8.0]}
    )
    assert smoothed(curves, "value", 2)["value"].tolist() == [0.0, 1.0, 3.0, 8.0]


def test_first_crossing_is_that_of_the_slowest_seed(recipe: Recipe) -> None:
    curves = pd.DataFrame(
        {
            "method": "mappo",
            "seed": [0, 0, 1, 1],
            "time/env_steps": [1000, 2000, 1000, 2000],
            "missions/success_percent": [95.0, 90.0, 80.0, 96.0],
            "greedy/success_percent": [10.0, 20.0, 97.0, 98.0],
        }
    )
    own = rows(True, 40.0)
    own.insert(0, "seed", 0)
    own.insert(0, "method", "mappo")
    crossing = first_crossing(Results(recipe, own, curves)).iloc[0]
    assert crossing["training missions"] == "2,000"
    assert crossing["greedy evaluation"] == "1 of 2 seeds"


@pytest.mark.parametrize(
    ("rewards", "word"), [((3.0, 3.2), "as good as"), ((4.0, 4.2), "better than"), ((1.0, 1.2), "worse than")]
)
def test_a_baseline_is_held_against_mappo_seed_by_seed(recipe: Recipe, rewards: tuple[float, float], word: str) -> None:
    baseline = recipe.methods["mappo"].model_copy(update={"label": "IQL", "paper_row": "IQL"})
    both = recipe.model_copy(update={"methods": {**recipe.methods, "iql": baseline}})
    parts = []
    for method, values in (("mappo", (3.1, 3.0)), ("iql", rewards)):  # differences -0.1 and 0.2, shifted by -2, 0, 1
        for seed, reward in enumerate(values):
            own = rows(True, 40.0).assign(reward=reward)
            own.insert(0, "seed", seed)
            own.insert(0, "method", method)
            parts.append(own)
    (verdict,) = baseline_verdicts(Results(both, pd.concat(parts, ignore_index=True)))
    assert f"IQL is {word} CTDE-MAPPO" in verdict
    assert "± 0.212" in verdict  # standard deviation of two differences 0.3 apart


def test_nearest_to_the_paper_is_the_evaluation_with_the_nearest_mean_success(recipe: Recipe) -> None:
    # Means over the two seeds: 50 % at 1,000 env steps, 99 % at 2,000; the paper's CTDE-MAPPO has 100 %.
    figures = {name: [1.0, 2.0, 3.0, 4.0] for name in ("reward", "rate_mbps", "makespan_slots")}
    curves = pd.DataFrame(
        {
            "method": "mappo",
            "seed": [0, 0, 1, 1],
            "time/env_steps": [1000, 2000, 1000, 2000],
            "greedy/success_percent": [20.0, 99.0, 80.0, 99.0],
            **{f"greedy/{name}": values for name, values in figures.items()},
        }
    )
    own = rows(True, 40.0)
    own.insert(0, "seed", 0)
    own.insert(0, "method", "mappo")
    nearest = nearest_to_paper(Results(recipe, own, curves)).iloc[0]
    assert nearest["env steps"] == "2,000"
    assert nearest["Success (%)"] == "99.0 (100.0)"
    assert nearest["J̄"] == "3.00 (3.19)"


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("evaluation.csv", None, "cannot be read"),
        ("evaluation.csv", "", "cannot be read"),
        ("evaluation.csv", "episode,uav\n0,0\n", "lacks the columns reward"),
        ("progress.csv", "nothing\n1\n", "lacks the columns time/env_steps"),
        ("finished", "0123456789abcdef\n", "another configuration"),
        ("config.yaml", None, "no run yet"),
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
    results = write_report(recipe, small_cells, tmp_path / "report", SOURCE)
    assert len(results.problems) == 1
    assert "mappo seed 1" in results.problems[0]
    assert expected in results.problems[0]
    assert set(results.methods) == {"random", "mappo"}
    assert expected in (tmp_path / "report" / "README.md").read_text(encoding="utf-8")


def test_rows_that_are_cut_off_are_not_used(recipe: Recipe, small_cells: list[Cell]) -> None:
    path = small_cells[0].directory / "evaluation.csv"
    text = path.read_text()
    path.write_text(text[: len(text) // 2])
    results = read_results(recipe, small_cells)
    assert "cut off" in results.problems[0]
    assert len(results.by_seed()) == 3


def test_without_any_run_there_is_no_report(recipe: Recipe, tmp_path: Path) -> None:
    from lawn_sb3.experiment.recipe import cells

    with pytest.raises(UserError, match="no finished run"):
        write_report(recipe, cells(recipe, tmp_path / "empty"), tmp_path / "report", SOURCE)


def test_a_method_keeps_its_colour_whatever_is_beside_it() -> None:
    everyone = colours(["random", "iql", "qmix", "mappo", "mappo-state", "mine", "yours"])
    assert len(set(everyone.values())) == 7
    for key in ("random", "mappo", "qmix"):
        assert colours([key])[key] == everyone[key]


def test_provenance_names_commit_versions_and_command(small_cells: list[Cell]) -> None:
    record = json.loads((small_cells[0].directory / "provenance.json").read_text())
    assert {"command", "commit", "versions", "hardware", "started", "train_seconds"} <= set(record)


def test_labels_are_shown_as_they_are_written(recipe: Recipe, small_cells: list[Cell], tmp_path: Path) -> None:
    odd = recipe.methods["mappo"].model_copy(update={"label": "A|B & V_x"})
    renamed = recipe.model_copy(update={"methods": {**recipe.methods, "mappo": odd}})
    write_report(renamed, small_cells, tmp_path / "report", SOURCE)
    assert "A\\|B & V_x" in (tmp_path / "report" / "table2.md").read_text(encoding="utf-8")
    assert "A|B \\& V\\_x" in (tmp_path / "report" / "table2.tex").read_text(encoding="utf-8")


def test_a_curve_that_was_not_measured_is_called_so(recipe: Recipe) -> None:
    own = rows(True, 40.0)
    own.insert(0, "seed", 0)
    own.insert(0, "method", "mappo")
    curves = pd.DataFrame({"method": ["mappo"], "seed": [0], "time/env_steps": [64]})
    assert first_crossing(Results(recipe, own, curves)).iloc[0]["training missions"] == "not measured"


def test_the_page_names_what_the_recipe_changed(recipe: Recipe, small_cells: list[Cell], tmp_path: Path) -> None:
    write_report(recipe, small_cells, tmp_path / "report", SOURCE)
    assert "scenario `paper, max_slots=20`" in (tmp_path / "report" / "README.md").read_text(encoding="utf-8")
