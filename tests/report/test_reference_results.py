"""The results kept with the code: whole, small, holding no code, and just what this code makes of its runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lawn_sb3.experiment.recipe import cells, load_recipe
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.report.document import Report
from lawn_sb3.report.page import build_report
from lawn_sb3.report.sections.ablation import build_ablation
from lawn_sb3.results.results import Results

REFERENCE = REPOSITORY / "runs" / "reference" / "paper"


def made_anew(name: str, build: Callable[..., tuple[Report, Results]]) -> Report:
    """The report of a recipe's kept results."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(REPOSITORY)
        recipe = load_recipe(Path(f"runs/{name}.yaml"))
        report, _ = build(recipe, cells(recipe, Path(f"runs/reference/{name}")), "command")
    return report


@pytest.fixture(scope="module")
def report() -> Report:
    """The report, made anew."""
    return made_anew("paper", build_report)


def test_every_run_is_whole_and_of_the_recipe_as_it_is(report: Report) -> None:
    assert report.problems == []
    assert len(report.recipe.seeds) == 5


@pytest.mark.parametrize(
    "name",
    ["table1", "table2", "comparison", "claims", "fairness", "sampling", "first_crossing", "anarchy", "regret"],
)
def test_the_kept_tables_are_those_that_this_code_makes(report: Report, name: str) -> None:
    assert report.tables[name].as_markdown() + "\n" == (REFERENCE / "report" / f"{name}.md").read_text(encoding="utf-8")


def test_models_are_small_and_hold_arrays_alone() -> None:
    models = sorted(REFERENCE.rglob("weights.npz"))
    assert len(models) == 6  # one for each method that learns
    for path in models:
        assert path.stat().st_size < 1_000_000
        with np.load(path, allow_pickle=False) as stored:
            assert all(stored[name].dtype.kind == "f" for name in stored.files)
    assert not list(REFERENCE.rglob("*.zip"))
    assert not list(REFERENCE.rglob("*.pt"))


@pytest.fixture(scope="module")
def ablation() -> Report:
    """The report of the ablations, made anew."""
    return made_anew("ablation", build_ablation)


def test_every_ablation_is_whole_and_of_the_recipe_as_it_is(ablation: Report) -> None:
    assert ablation.problems == []
    assert len(ablation.recipe.seeds) == 5


@pytest.mark.parametrize("name", ["effects", "learning_effects", "claims", "scaling"])
def test_the_kept_tables_of_the_ablations_are_those_that_this_code_makes(ablation: Report, name: str) -> None:
    kept = REPOSITORY / "runs" / "reference" / "ablation" / "report" / f"{name}.md"
    assert ablation.tables[name].as_markdown() + "\n" == kept.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def ladder() -> Report:
    """The report of the ladder, made anew."""
    return made_anew("ladder", build_report)


def test_every_rung_is_whole_and_of_the_recipe_as_it_is(ladder: Report) -> None:
    assert ladder.problems == []
    assert len(ladder.recipe.seeds) == 3


@pytest.mark.parametrize("name", ["ladder_table", "table2", "claims", "regret"])
def test_the_kept_tables_of_the_ladder_are_those_that_this_code_makes(ladder: Report, name: str) -> None:
    kept = REPOSITORY / "runs" / "reference" / "ladder" / "report" / f"{name}.md"
    assert ladder.tables[name].as_markdown() + "\n" == kept.read_text(encoding="utf-8")
