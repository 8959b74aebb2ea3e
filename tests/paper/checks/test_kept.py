"""Checks are made once, vouched for by what they were made from, and read back whole or not at all."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from lawn_sb3.experiment.cell import Cell, cells
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.paper.checks import export_checks, read_checks
from lawn_sb3.paper.checks.kept import checks_folder, needed_checks
from lawn_sb3.paper.making import fly_checks
from lawn_sb3.paper.making.make import hovering

QUIET = Console(quiet=True)
OF_CLAIMS = {"printed_grid", "least_reward", "deviation_cycles", "hovering", "state_noise"}


def read(recipe: Recipe, own: list[Cell]) -> tuple[dict[str, pd.DataFrame | str], list[str]]:
    problems: list[str] = []
    return read_checks(recipe, own, problems), problems


def written(folder: Path) -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}


def test_what_was_flown_is_read_back(recipe: Recipe, small_cells: list[Cell]) -> None:
    found, problems = read(recipe, small_cells)
    assert (set(found), problems) == (OF_CLAIMS, [])
    again = hovering(recipe, [])
    assert isinstance(found["hovering"], pd.DataFrame)
    np.testing.assert_allclose(found["hovering"]["rate_mbps"], again["rate_mbps"], rtol=1e-8)
    record = json.loads((checks_folder(small_cells) / "hovering.json").read_text(encoding="utf-8"))
    assert record["rows"] == len(again)
    assert {"command", "commit", "versions", "hardware"} <= set(record)


def test_the_price_of_anarchy_is_prepared_where_there_are_equilibria_and_a_bound(
    planned: Recipe, planned_cells: list[Cell]
) -> None:
    assert set(read(planned, planned_cells)[0]) == OF_CLAIMS | {"guaranteed"}


def test_finished_checks_are_kept_and_missing_ones_made(recipe: Recipe, small_cells: list[Cell]) -> None:
    folder = checks_folder(small_cells)
    before = written(folder)
    (folder / "hovering.csv").unlink()
    fly_checks(recipe, small_cells, QUIET)
    changed = {name for name, when in written(folder).items() if before[name] != when}
    assert changed == {"hovering.csv", "hovering.json"}
    assert read(recipe, small_cells)[1] == []


def test_checks_of_other_missions_are_stale_and_made_anew(recipe: Recipe, small_cells: list[Cell]) -> None:
    runs = checks_folder(small_cells).parent
    evaluation = recipe.evaluation.model_copy(update={"seed": recipe.evaluation.seed + 1})
    other = recipe.model_copy(update={"evaluation": evaluation})
    own = [cell for cell in cells(other, runs) if cell.key == "random"]
    for cell in own:  # runs on the other missions
        (cell.directory / "finished").write_text(cell.fingerprint(), encoding="utf-8")
        text = (cell.directory / "config.yaml").read_text(encoding="utf-8")
        (cell.directory / "config.yaml").write_text(text.replace("seed: 20000", "seed: 20001"), encoding="utf-8")
    problems = read(other, own)[1]
    assert problems == [
        f"checks/{name}.csv: made from other settings or runs; lawn-sb3 reproduce makes it"
        for name in ("printed_grid", "least_reward", "deviation_cycles", "hovering")
    ]
    fly_checks(other, own, QUIET)
    found, problems = read(other, own)
    assert (set(found), problems) == (OF_CLAIMS - {"state_noise"}, [])


def test_nothing_is_flown_for_claims_where_the_game_is_not_the_papers_or_no_row_is_named(
    recipe: Recipe, small_cells: list[Cell]
) -> None:
    other_game = recipe.model_copy(update={"set": ("tx_power_dbm=10",)})
    methods = {key: method.model_copy(update={"paper_row": None}) for key, method in recipe.methods.items()}
    for other in (other_game, recipe.model_copy(update={"methods": methods})):
        assert needed_checks(other, small_cells) == []


def test_noise_is_of_the_models_that_are_there_now(recipe: Recipe, small_cells: list[Cell]) -> None:
    others = [cell for cell in small_cells if (cell.key, cell.seed) != ("mappo", 0)]
    assert read(recipe, others)[1] == [
        "checks/state_noise.csv: made from other settings or runs; lawn-sb3 reproduce makes it"
    ]


def test_what_cannot_be_made_leaves_its_reason_until_it_can(recipe: Recipe, small_cells: list[Cell]) -> None:
    folder = checks_folder(small_cells)
    model = next(cell.directory for cell in small_cells if (cell.key, cell.seed) == ("mappo", 0)) / "model.zip"
    aside = model.rename(model.with_name("aside.zip"))
    (folder / "state_noise.json").unlink()
    fly_checks(recipe, small_cells, QUIET)
    found, problems = read(recipe, small_cells)
    assert str(found["state_noise"]).startswith(f"needs the trained model of CTDE-MAPPO: {str(model)!r} is missing")
    assert problems == []
    assert not (folder / "state_noise.csv").exists()
    aside.rename(model)
    fly_checks(recipe, small_cells, QUIET)
    assert isinstance(read(recipe, small_cells)[0]["state_noise"], pd.DataFrame)


def cut(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text("".join(lines[: len(lines) // 2]), encoding="utf-8")


def other_values(path: Path) -> None:
    rows = pd.read_csv(path)
    rows.assign(reward=rows["reward"] + 1.0).to_csv(path, index=False)


def no_rows(path: Path) -> None:
    path.write_text(path.read_text(encoding="utf-8").replace('"rows": 48', '"rows": 0'), encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "damage", "problem"),
    [
        ("hovering.csv", Path.unlink, "checks/hovering.csv cannot be read: No such file or directory"),
        ("hovering.csv", cut, "checks/hovering.csv is cut off: 23 of 48 rows"),
        ("hovering.csv", other_values, "checks/hovering.csv is not what hovering.json vouches for"),
        ("hovering.json", no_rows, "checks/hovering.json cannot be read"),
        ("hovering.json", Path.unlink, "checks/hovering.csv: not there yet"),
        ("hovering.json", cut, "checks/hovering.json cannot be read"),
    ],
)
def test_damage_is_told_in_one_line_and_mended(
    recipe: Recipe, small_cells: list[Cell], name: str, damage: Callable[[Path], None], problem: str
) -> None:
    damage(checks_folder(small_cells) / name)
    found, problems = read(recipe, small_cells)
    assert "hovering" not in found
    assert problems == [f"{problem}; lawn-sb3 reproduce makes it"]
    fly_checks(recipe, small_cells, QUIET)
    assert read(recipe, small_cells)[1] == []


def test_a_value_that_cannot_be_is_told(recipe: Recipe, small_cells: list[Cell]) -> None:
    path = checks_folder(small_cells) / "least_reward.csv"
    rows = pd.read_csv(path)
    rows.assign(least_mbps=-1.0).to_csv(path, index=False)
    assert read(recipe, small_cells)[1] == [
        "checks/least_reward.csv line 2: least_mbps = '-1.0': must be a finite number of at least 0; "
        "lawn-sb3 reproduce makes it"
    ]


def test_reports_that_judge_nothing_need_no_checks(recipe: Recipe, small_cells: list[Cell]) -> None:
    blind = recipe.methods["mappo"].model_copy(update={"baseline": "mappo"})
    ablation = recipe.model_copy(update={"methods": {**recipe.methods, "blind": blind}})
    assert read(ablation, small_cells) == ({}, [])
    assert read(recipe.model_copy(update={"variants": {"loud": ("tx_power_dbm=30",)}}), small_cells) == ({}, [])


def test_exported_checks_are_those_of_the_runs(recipe: Recipe, small_cells: list[Cell], tmp_path: Path) -> None:
    (tmp_path / "checks").mkdir()
    (tmp_path / "checks" / "old.csv").write_text("left by an earlier export", encoding="utf-8")
    size = export_checks(small_cells, tmp_path)
    kept = sorted((tmp_path / "checks").iterdir())
    assert [path.name for path in kept] == sorted(path.name for path in checks_folder(small_cells).iterdir())
    assert size == sum(path.stat().st_size for path in kept)
