"""Making the checks of a recipe and reading them back: each is a table with a record of what it was made from."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import torch as th
from rich.console import Console
from rich.progress import track

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import RESULTS_SINCE, Cell
from lawn_sb3.experiment.provenance import provenance
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.experiment.run_directory.configuration import is_finished
from lawn_sb3.experiment.run_directory.csv_file import read_table, write_rows
from lawn_sb3.paper.checks.check import Check
from lawn_sb3.paper.checks.deviation_cycles import DeviationCycles
from lawn_sb3.paper.checks.guaranteed import Guaranteed
from lawn_sb3.paper.checks.hovering import Hovering
from lawn_sb3.paper.checks.least_reward import LeastReward
from lawn_sb3.paper.checks.printed_grid import PrintedGrid
from lawn_sb3.paper.checks.state_noise import StateNoise
from lawn_sb3.whole_files import write_json

CHECKS: tuple[Check, ...] = (PrintedGrid(), LeastReward(), DeviationCycles(), Hovering(), StateNoise(), Guaranteed())
"""Each leaves ``NAME.csv``, and ``NAME.json`` with fingerprint, number of rows, the table's hash, and provenance."""


def checks_folder(cells: Sequence[Cell]) -> Path:
    """Where the checks of a recipe without changed games are kept, beside its runs."""
    return cells[0].directory.parents[1] / "checks"


def fly_checks(recipe: Recipe, cells: Sequence[Cell], console: Console) -> None:
    """Make the checks that the report of a recipe needs; those that are there and still hold are kept.

    A check that cannot be made, as where a trained model was not kept, leaves the reason instead.

    :param recipe: the recipe
    :param cells: its cells
    :param console: where progress goes
    """
    finished = [cell for cell in cells if is_finished(cell)]
    folder = checks_folder(cells)
    todo = [check for check in _needed(recipe, finished) if not _is_kept(check, recipe, finished, folder)]
    th.set_num_threads(1)  # as in training: equal bytes everywhere
    for check in track(todo, "flying what claims rest on", console=console, disable=not todo):
        _make(check, recipe, finished, folder)


def read_checks(recipe: Recipe, cells: Sequence[Cell], problems: list[str]) -> dict[str, pd.DataFrame | str]:
    """Read back the checks that the report of a recipe needs.

    :param recipe: the recipe
    :param cells: its cells
    :param problems: gets one line for each check that is missing, damaged, or made from something else
    :return: by name its rows, or why it cannot be made
    """
    finished = [cell for cell in cells if is_finished(cell)]
    found: dict[str, pd.DataFrame | str] = {}
    for check in _needed(recipe, finished):
        try:
            found[check.name] = _read(check, recipe, finished, checks_folder(cells))
        except UserError as error:
            problems.append(f"checks/{error}; lawn-sb3 reproduce makes it")
    return found


def export_checks(cells: Sequence[Cell], folder: Path) -> int:
    """Copy what there is of a recipe's checks; what an earlier export left goes.

    :param cells: the cells of the recipe
    :param folder: where the runs are copied to
    :return: bytes written
    """
    source, target = checks_folder(cells), folder / "checks"
    shutil.rmtree(target, ignore_errors=True)
    if not source.is_dir():
        return 0
    shutil.copytree(source, target)
    return sum(path.stat().st_size for path in target.iterdir())


def _needed(recipe: Recipe, finished: Sequence[Cell]) -> list[Check]:
    """The checks that the report asks for: none of changed games or ablations."""
    if not finished or recipe.variants or recipe.is_ablation:
        return []
    return [check for check in CHECKS if check.is_needed(recipe, finished)]


def _fingerprint(check: Check, recipe: Recipe, finished: Sequence[Cell]) -> str:
    """Hash of all that a check's rows depend on."""
    content = {
        "check": check.name,
        "since": check.since,
        "scenario": check.game(recipe).model_dump(mode="json", exclude_defaults=True),
        "episodes": recipe.evaluation.episodes,
        "seed": recipe.evaluation.seed,
        "version": RESULTS_SINCE,
        **check.depends_on(recipe, finished),
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def _make(check: Check, recipe: Recipe, finished: Sequence[Cell], folder: Path) -> None:
    """Fly a check and write its files; the record goes first and comes last: it never vouches for other rows."""
    folder.mkdir(parents=True, exist_ok=True)
    table, record = folder / f"{check.name}.csv", folder / f"{check.name}.json"
    for path in (record, table):
        path.unlink(missing_ok=True)
    content: dict[str, Any] = {"fingerprint": _fingerprint(check, recipe, finished)}
    try:
        rows = check.fly(recipe, finished)
    except UserError as error:
        content["cannot"] = str(error)
    else:
        write_rows(table, rows)
        content |= {"rows": len(rows), "sha256": _sha256(table)}
    write_json(record, {**content, **provenance()})


def _is_kept(check: Check, recipe: Recipe, finished: Sequence[Cell], folder: Path) -> bool:
    """Whether a check's rows are there; one that could not be made is tried again."""
    try:
        return not isinstance(_read(check, recipe, finished, folder), str)
    except UserError:
        return False


def _read(check: Check, recipe: Recipe, finished: Sequence[Cell], folder: Path) -> pd.DataFrame | str:
    path = folder / f"{check.name}.json"
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        fingerprint, cannot = record["fingerprint"], record.get("cannot")
        num_rows, sha256 = (0, "") if cannot is not None else (record["rows"], record["sha256"])
        if cannot is None and not (isinstance(num_rows, int) and num_rows > 0):
            raise ValueError("no rows")
    except FileNotFoundError:
        raise UserError(f"{check.name}.csv: not there yet") from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise UserError(f"{path.name} cannot be read") from None
    if fingerprint != _fingerprint(check, recipe, finished):
        raise UserError(f"{check.name}.csv: made from other settings or runs")
    if cannot is not None:
        return str(cannot)
    table = folder / f"{check.name}.csv"
    rows = read_table(table, check.columns(recipe, finished), num_rows, list(check.key))
    if _sha256(table) != sha256:
        raise UserError(f"{table.name} is not what {path.name} vouches for")
    return rows


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
