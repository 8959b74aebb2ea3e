"""Scaling out: finished players flown with more or fewer UAVs than they were trained with, without retraining."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd
import torch as th
from rich.console import Console
from rich.progress import track

from lawn_sb3.experiment.cell import SCALING_FILE, is_finished, write_rows
from lawn_sb3.experiment.evaluation import evaluate, summarize
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.recipe import Cell, Scaling


def scale_out(cells: Sequence[Cell], scaling: Scaling, console: Console) -> None:
    """Fly the finished runs of the chosen methods with each number of UAVs; what was flown already is kept.

    :param cells: the cells of a recipe
    :param scaling: what to fly
    :param console: where progress goes
    """
    chosen = [cell for cell in cells if cell.key in scaling.methods and is_finished(cell)]
    todo = [cell for cell in chosen if not has_flown(cell, scaling)]
    th.set_num_threads(1)  # as in training: equal bytes everywhere
    for cell in track(todo, "flying with other numbers of UAVs", console=console, disable=not todo):
        write_rows(cell.directory / SCALING_FILE, fly_scaled(cell, scaling))


def fly_scaled(cell: Cell, scaling: Scaling) -> pd.DataFrame:
    """Fly one finished run with each number of UAVs.

    Each N has missions of its own, the same for every player.

    :param cell: the cell of the run
    :param scaling: what to fly
    :return: one row for each N: ``num_uavs``, ``episodes`` and the means of
        :func:`lawn_sb3.experiment.evaluation.summarize`
    :raises UserError: if the player cannot be moved to another N, or the airspace is too small for it
    """
    player, rows = load_player(cell, cell.evaluation.deterministic), []
    for num_uavs in scaling.num_uavs:
        game = cell.scenario.changed(num_uavs=num_uavs)
        flown = evaluate(player, game, scaling.episodes, cell.evaluation.seed, cell.seed)
        rows.append({"num_uavs": num_uavs, "episodes": scaling.episodes, **summarize(flown)})
    return pd.DataFrame(rows)


def has_flown(cell: Cell, scaling: Scaling) -> bool:
    """Whether a run was flown with these numbers of UAVs and episodes.

    :param cell: the cell of the run
    :param scaling: what to fly
    :return: true if there is nothing left to do
    """
    try:
        rows = pd.read_csv(cell.directory / SCALING_FILE, usecols=["num_uavs", "episodes"])
    except (OSError, ValueError):  # missing, or damaged
        return False
    return bool(tuple(rows["num_uavs"]) == scaling.num_uavs and (rows["episodes"] == scaling.episodes).all())
