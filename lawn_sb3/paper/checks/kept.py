"""The checks of a recipe on disk: each is a table with a record of what it was made from."""

import hashlib
import json
import shutil
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import RESULTS_SINCE, Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.experiment.run_directory.configuration import is_finished
from lawn_sb3.experiment.run_directory.csv_file import read_table
from lawn_sb3.paper.checks.checks import CHECKS, Check


def checks_folder(cells: Sequence[Cell]) -> Path:
    """Where the checks of a recipe without changed games are kept, beside its runs."""
    return cells[0].directory.parents[1] / "checks"


def read_checks(recipe: Recipe, cells: Sequence[Cell], problems: list[str]) -> dict[str, pd.DataFrame | str]:
    """Read back the checks that the report of a recipe needs.

    :param recipe: the recipe
    :param cells: its cells
    :param problems: gets one line for each check that is missing, damaged, or made from something else
    :return: by name its rows, or why it cannot be made
    """
    finished = [cell for cell in cells if is_finished(cell)]
    found: dict[str, pd.DataFrame | str] = {}
    for check in needed_checks(recipe, finished):
        try:
            found[check.name] = read_check(check, recipe, finished, checks_folder(cells))
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


def needed_checks(recipe: Recipe, finished: Sequence[Cell]) -> list[Check]:
    """The checks that the report asks for: none of changed games or ablations."""
    if not finished or recipe.variants or recipe.is_ablation:
        return []
    return [check for check in CHECKS if check.is_needed(recipe, finished)]


def fingerprint(check: Check, recipe: Recipe, finished: Sequence[Cell]) -> str:
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


def read_check(check: Check, recipe: Recipe, finished: Sequence[Cell], folder: Path) -> pd.DataFrame | str:
    """The rows of a check, or why it cannot be made.

    :raises UserError: if it is missing, damaged, or made from something else
    """
    path = folder / f"{check.name}.json"
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        made_from, cannot = record["fingerprint"], record.get("cannot")
        num_rows, sha256 = (0, "") if cannot is not None else (record["rows"], record["sha256"])
        if cannot is None and not (isinstance(num_rows, int) and num_rows > 0):
            raise ValueError("no rows")
    except FileNotFoundError:
        raise UserError(f"{check.name}.csv: not there yet") from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise UserError(f"{path.name} cannot be read") from None
    if made_from != fingerprint(check, recipe, finished):
        raise UserError(f"{check.name}.csv: made from other settings or runs")
    if cannot is not None:
        return str(cannot)
    table = folder / f"{check.name}.csv"
    rows = read_table(table, check.columns(recipe, finished), num_rows, list(check.key))
    if hash_of(table) != sha256:
        raise UserError(f"{table.name} is not what {path.name} vouches for")
    return rows


def hash_of(path: Path) -> str:
    """The SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()
