"""Making the checks of a recipe that are missing, damaged or stale."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import torch as th
from rich.console import Console
from rich.progress import track

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.provenance import provenance
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.experiment.run_directory.configuration import is_finished
from lawn_sb3.experiment.run_directory.csv_file import write_rows
from lawn_sb3.game.player import RandomPlayer
from lawn_sb3.paper.checks.checks import SHARE_FLYING, Check
from lawn_sb3.paper.checks.kept import checks_folder, fingerprint, hash_of, needed_checks, read_check
from lawn_sb3.paper.making.deviation_cycles import deviation_cycles
from lawn_sb3.paper.making.guaranteed import guaranteed
from lawn_sb3.paper.making.hovering import HoveringPlayer
from lawn_sb3.paper.making.least_reward import least_reward
from lawn_sb3.paper.making.state_noise import state_noise
from lawn_sb3.scenario import PRESETS
from lawn_sb3.whole_files import write_json


def printed_grid(recipe: Recipe, finished: Sequence[Cell]) -> pd.DataFrame:
    """Raw rows of Random on the grid that the paper's Table I prints."""
    return evaluate(RandomPlayer(), PRESETS["as-printed"], recipe.evaluation.episodes, recipe.evaluation.seed)


def hovering(recipe: Recipe, finished: Sequence[Cell]) -> pd.DataFrame:
    """Raw rows of UAVs of which as many fly as the paper's IQL brings home, and the others hover, in both ways."""
    parts = []
    for seeks in (False, True):
        player = HoveringPlayer(SHARE_FLYING, seeks=seeks)
        rows = evaluate(player, recipe.game(), recipe.evaluation.episodes, recipe.evaluation.seed)
        rows.insert(0, "seeks", int(seeks))
        parts.append(rows)
    return pd.concat(parts, ignore_index=True)


MAKERS: dict[str, Callable[[Recipe, Sequence[Cell]], pd.DataFrame]] = {
    maker.__name__: maker for maker in (printed_grid, least_reward, deviation_cycles, hovering, state_noise, guaranteed)
}
"""By the name of a check what makes its rows, from the recipe and the cells whose runs are finished."""


def fly_checks(recipe: Recipe, cells: Sequence[Cell], console: Console) -> None:
    """Make the checks that the report of a recipe needs; those that are there and still hold are kept.

    A check that cannot be made, as where a trained model was not kept, leaves the reason instead.

    :param recipe: the recipe
    :param cells: its cells
    :param console: where progress goes
    """
    finished = [cell for cell in cells if is_finished(cell)]
    folder = checks_folder(cells)
    todo = [check for check in needed_checks(recipe, finished) if not _is_kept(check, recipe, finished, folder)]
    th.set_num_threads(1)  # as in training: equal bytes everywhere
    for check in track(todo, "flying what claims rest on", console=console, disable=not todo):
        _make(check, recipe, finished, folder)


def _is_kept(check: Check, recipe: Recipe, finished: Sequence[Cell], folder: Path) -> bool:
    """Whether a check's rows are there; one that could not be made is tried again."""
    try:
        return not isinstance(read_check(check, recipe, finished, folder), str)
    except UserError:
        return False


def _make(check: Check, recipe: Recipe, finished: Sequence[Cell], folder: Path) -> None:
    """Fly a check and write its files; the record goes first and comes last: it never vouches for other rows."""
    folder.mkdir(parents=True, exist_ok=True)
    table, record = folder / f"{check.name}.csv", folder / f"{check.name}.json"
    for path in (record, table):
        path.unlink(missing_ok=True)
    content: dict[str, Any] = {"fingerprint": fingerprint(check, recipe, finished)}
    try:
        rows = MAKERS[check.name](recipe, finished)
    except UserError as error:
        content["cannot"] = str(error)
    else:
        write_rows(table, rows)
        content |= {"rows": len(rows), "sha256": hash_of(table)}
    write_json(record, {**content, **provenance()})
