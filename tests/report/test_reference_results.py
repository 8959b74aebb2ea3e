"""The results kept with the code: whole, small, holding no code, and just what this code makes of its runs."""

from pathlib import Path

import numpy as np
import pytest

from lawn_sb3.experiment.cell import cells
from lawn_sb3.experiment.recipe import load_recipe
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.report.contents import build_report
from lawn_sb3.report.document import Report, page

REFERENCE = Path("runs/reference")
SEEDS = {"paper": 5, "ablation": 5, "ladder": 3}


@pytest.fixture(scope="module", params=SEEDS)
def report(request: pytest.FixtureRequest) -> Report:
    """The report of a recipe's kept results, made anew."""
    name = request.param
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(REPOSITORY)
        recipe = load_recipe(Path(f"runs/{name}.yaml"))
        command = f"lawn-sb3 report runs/{name}.yaml --runs runs/reference/{name}"
        return build_report(recipe, cells(recipe, REFERENCE / name), command)


def test_every_run_is_whole_and_of_the_recipe_as_it_is(report: Report) -> None:
    assert report.problems == []
    assert len(report.recipe.seeds) == SEEDS[report.recipe.name]


def test_the_kept_page_and_tables_are_those_that_this_code_makes(report: Report) -> None:
    folder = REPOSITORY / REFERENCE / report.recipe.name / "report"
    assert page(report) == (folder / "README.md").read_text(encoding="utf-8")
    for name, table in report.tables.items():
        assert table.as_markdown() + "\n" == (folder / f"{name}.md").read_text(encoding="utf-8"), name


def test_what_is_kept_beside_the_page_is_on_it(report: Report) -> None:
    folder = REPOSITORY / REFERENCE / report.recipe.name / "report"
    kept = {path.stem for path in folder.iterdir()} - {"README", "report", "index", "replay"}
    assert kept == {*report.tables, *report.figures}


def test_models_are_small_and_hold_arrays_alone() -> None:
    folder = REPOSITORY / REFERENCE / "paper"
    models = sorted(folder.rglob("weights.npz"))
    assert len(models) == 6  # one for each method that learns
    for path in models:
        assert path.stat().st_size < 1_000_000
        with np.load(path, allow_pickle=False) as stored:
            assert all(stored[name].dtype.kind == "f" for name in stored.files)
    assert not list(folder.rglob("*.zip"))
    assert not list(folder.rglob("*.pt"))
