"""``config.yaml`` and ``finished``: what a run was made with, and whether it is the finished run of a cell."""

from collections.abc import Collection, Iterable
from pathlib import Path
from typing import Any

import yaml

from lawn_sb3.choices import is_whole
from lawn_sb3.config import validated
from lawn_sb3.errors import UserError, first_line
from lawn_sb3.experiment.cell import NOT_IN_RESULTS, Cell
from lawn_sb3.experiment.policy_places import check_trusted
from lawn_sb3.experiment.recipe import Evaluation, Method
from lawn_sb3.experiment.run_directory.files import CONFIG_FILE, FINISHED_FILE
from lawn_sb3.scenario import Scenario
from lawn_sb3.whole_files import write_text


def write_configuration(cell: Cell) -> None:
    """Write down all that the cell's run depends on."""
    write_text(cell.directory / CONFIG_FILE, yaml.safe_dump(cell.configuration(), sort_keys=False))


def load_run(directory: Path, trusted: Collection[str] = ()) -> Cell:
    """Read back which cell a run directory holds.

    :param directory: the run
    :param trusted: policies that it may name though they do not come with the kit
    :return: its cell
    :raises UserError: if it holds no run, another version's, or one of a policy that is not trusted
    """
    path = directory / CONFIG_FILE
    try:
        values = yaml.safe_load(path.read_text(encoding="utf-8"))
        if not isinstance(values, dict):
            raise ValueError("it holds no keys and values")
        if lacking := [name for name in ("key", "seed", "method", "scenario", "evaluation") if name not in values]:
            raise ValueError(f"{lacking[0]} is missing")
        if not is_whole(values["seed"]) or values["seed"] < 0:
            raise ValueError(f"seed = {values['seed']!r}: a whole number from 0 up")
        if not isinstance(values["key"], str) or Path(values["key"]).name != values["key"]:
            raise ValueError(f"key = {values['key']!r}: the name of a method, or of a folder")
        cell = Cell(
            key=values["key"],
            method=validated(Method, values["method"], "method"),
            seed=values["seed"],
            scenario=validated(Scenario, values["scenario"], "scenario"),
            evaluation=validated(Evaluation, values["evaluation"], "evaluation"),
            directory=directory,
        )
    except OSError as error:
        raise UserError(f"{str(directory)!r} holds no run: {path.name}: {error.strerror}") from None
    except (yaml.YAMLError, ValueError) as error:
        raise UserError(f"{str(path)!r} is not the configuration of a run: {first_line(error)}") from None
    if cell.method.policy is not None:
        check_trusted(cell.method.policy, trusted, repr(str(path)))
    return cell


def load_finished_run(directory: Path, trusted: Collection[str] = ()) -> Cell:
    """Read back which cell a run directory holds, and refuse it if its run is not complete.

    :param directory: the run
    :param trusted: as for :func:`load_run`
    :return: its cell
    :raises UserError: as :func:`load_run`, and if its run is not finished
    """
    cell = load_run(directory, trusted)
    if not is_finished(cell):
        raise UserError(f"{str(directory)!r} is not finished, or its policy file has changed since")
    return cell


def mark_finished(cell: Cell) -> None:
    """Say that the cell's run is complete."""
    write_text(cell.directory / FINISHED_FILE, cell.fingerprint() + "\n")


def is_finished(cell: Cell) -> bool:
    """Whether a cell's run is complete and was made with the same configuration.

    :param cell: the cell
    :return: true if there is nothing left to do
    """
    try:
        if (cell.directory / FINISHED_FILE).read_text(encoding="utf-8").strip() not in cell.fingerprints():
            return False
        kept = yaml.safe_load((cell.directory / CONFIG_FILE).read_text(encoding="utf-8"))
        return all(_agree(kept[part], cell.configuration()[part]) for part in ("method", "scenario", "evaluation"))
    except (OSError, ValueError, KeyError, AttributeError, TypeError, yaml.YAMLError):  # missing, or damaged
        return False


def check_finished(cells: Iterable[Cell]) -> None:
    """Refuse the first cell whose run is not complete."""
    for cell in cells:
        if not is_finished(cell):
            raise UserError(f"{str(cell.directory)!r}: not finished, or made with another configuration")


def _agree(kept: dict[str, Any], now: dict[str, Any]) -> bool:
    """Whether the fields that both know have the same values: a changed default is another configuration."""
    return all(kept[name] == now[name] for name in kept.keys() & now.keys() - set(NOT_IN_RESULTS))
