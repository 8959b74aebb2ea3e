"""The regrets of finished runs, worked out once and kept beside their evaluations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
import torch as th
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import FLIGHT_FILES, REGRET_FILE, is_finished, write_rows
from lawn_sb3.experiment.evaluation import flies_alone, fly
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.recipe import Cell
from lawn_sb3.experiment.regret import COLUMNS, EQUILIBRIUM_MBPS, regrets


def add_regrets(cells: Sequence[Cell], console: Console) -> None:
    """Fly the finished runs of a recipe again, and work out what each UAV could have gained; what is there is kept.

    A run whose model is missing or damaged is named and left without.

    :param cells: the cells
    :param console: where progress goes
    """
    todo = [cell for cell in cells if is_finished(cell) and has_regrets(cell) and not _are_kept(cell)]
    th.set_num_threads(1)  # as in training: equal bytes everywhere
    for cell in track(todo, "working out regrets", console=console, disable=not todo):
        chosen = cell.evaluation
        try:
            player = load_player(cell, chosen.deterministic)
        except UserError as error:
            console.print(f"no regrets of {cell.title}: {error}", markup=False, highlight=False, soft_wrap=True)
            continue
        flights = fly(player, cell.scenario, chosen.episodes, chosen.seed, cell.seed, traced=chosen.episodes)
        write_rows(cell.directory / REGRET_FILE, regrets(flights, cell.scenario, chosen.seed))


def has_regrets(cell: Cell) -> bool:
    """Whether a cell's UAVs meet: one that is alone in its game has nobody whose trajectory it could respond to.

    :param cell: the cell
    :return: false for the bound
    """
    return cell.method.player is None or not flies_alone(load_player(cell))


def _are_kept(cell: Cell) -> bool:
    try:
        rows, flown = (pd.read_csv(cell.directory / name) for name in (REGRET_FILE, FLIGHT_FILES[0]))
        same = (rows[list(COLUMNS[:3])].to_numpy() == flown[list(COLUMNS[:3])].to_numpy()).all()
        finite = np.isfinite(rows.to_numpy(float)).all()
        return tuple(rows.columns) == COLUMNS and bool(same and finite and not is_too_low(rows, flown).any())
    except (OSError, ValueError, KeyError, AttributeError):  # missing, or damaged
        return False


def is_too_low(rows: pd.DataFrame, flown: pd.DataFrame) -> NDArray[np.bool_]:
    """Where a best response is worth less than the flight itself, although that did not collide: it cannot be.

    :param rows: what :func:`regrets` returned
    :param flown: the evaluation's rows, in the same order
    :return: one truth value a row
    """
    lower = rows["best_mbps"].to_numpy() < flown["utility_mbps"].to_numpy() - EQUILIBRIUM_MBPS
    return np.asarray(lower & (flown["collisions"].to_numpy() == 0))
