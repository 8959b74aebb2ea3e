"""What is worked out of finished runs, once, and kept beside their evaluations: regrets, other numbers of UAVs."""

from collections.abc import Callable, Sequence

import pandas as pd
import torch as th
from rich.console import Console
from rich.progress import track

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.decision_costs import decision_costs
from lawn_sb3.experiment.evaluation import evaluate, flies_alone, fly
from lawn_sb3.experiment.measures import regrets, summarize
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.recipe import Scaling
from lawn_sb3.experiment.run_directory.configuration import is_finished
from lawn_sb3.experiment.run_directory.csv_file import write_rows
from lawn_sb3.experiment.run_directory.files import COSTS_FILE, REGRET_FILE, SCALING_FILE
from lawn_sb3.experiment.run_directory.manifest import vouch_for
from lawn_sb3.experiment.run_directory.reading import read_costs, read_evaluation, read_regrets, read_scaling
from lawn_sb3.experiment.run_directory.writer import only_writer


def add_regrets(cells: Sequence[Cell], console: Console) -> None:
    """Fly the finished runs of a recipe again, and work out what each UAV could have gained; what is there is kept.

    :param cells: the cells
    :param console: where progress goes, and a line for each run whose model is missing or damaged
    """
    _add(
        REGRET_FILE,
        [cell for cell in cells if has_regrets(cell)],
        work_out=_fly_again,
        read=lambda cell: read_regrets(cell, read_evaluation(cell)),
        doing="working out regrets",
        console=console,
    )


def add_scaling(cells: Sequence[Cell], scaling: Scaling, console: Console) -> None:
    """Fly the finished runs of the chosen methods with each number of UAVs; what is there is kept.

    :param cells: the cells of a recipe
    :param scaling: what to fly
    :param console: where progress goes, and a line for each run whose model is missing or damaged
    """
    _add(
        SCALING_FILE,
        [cell for cell in cells if cell.key in scaling.methods],
        work_out=lambda cell: fly_scaled(cell, scaling),
        read=lambda cell: read_scaling(cell, scaling),
        doing="flying with other numbers of UAVs",
        console=console,
    )


def add_costs(cells: Sequence[Cell], scaling: Scaling, console: Console) -> None:
    """Measure what the decisions of the chosen methods cost with each number of UAVs; what is there is kept.

    :param cells: the cells of a recipe
    :param scaling: what to fly
    :param console: where progress goes, and a line for each run whose model is missing or damaged
    """
    _add(
        COSTS_FILE,
        [cell for cell in cells if cell.key in scaling.methods],
        work_out=lambda cell: decision_costs(cell, scaling),
        read=lambda cell: read_costs(cell, scaling),
        doing="measuring what decisions cost",
        console=console,
    )


def has_regrets(cell: Cell) -> bool:
    """Whether a cell's UAVs meet: one that is alone in its game has nobody whose trajectory it could respond to."""
    return cell.method.player is None or not flies_alone(load_player(cell))


def fly_scaled(cell: Cell, scaling: Scaling) -> pd.DataFrame:
    """Fly one finished run with each number of UAVs.

    Each N has missions of its own, the same for every player.

    :param cell: the cell of the run
    :param scaling: what to fly
    :return: one row per N, the means of :func:`lawn_sb3.experiment.measures.summarize`
    :raises UserError: if the player cannot be moved to another N, or the airspace is too small for it
    """
    greedy, rows = cell.evaluation.deterministic, []
    same_for_all = None if scaling.constant_density else load_player(cell, greedy)
    for num_uavs, episodes in scaling.flown_by(cell.key).items():
        game = scaling.game(cell.scenario, num_uavs)
        player = same_for_all or load_player(cell, greedy, game)
        flown = evaluate(player, game, episodes, cell.evaluation.seed, cell.seed)
        rows.append({"num_uavs": num_uavs, "episodes": episodes, **summarize(flown)})
    return pd.DataFrame(rows)


def _fly_again(cell: Cell) -> pd.DataFrame:
    """The regrets of one finished run."""
    chosen, player = cell.evaluation, load_player(cell, cell.evaluation.deterministic)
    flights = fly(player, cell.scenario, chosen.episodes, chosen.seed, cell.seed, traced=chosen.episodes)
    return regrets(flights, cell.scenario, chosen.seed)


def _add(
    name: str,
    cells: Sequence[Cell],
    work_out: Callable[[Cell], pd.DataFrame],
    read: Callable[[Cell], pd.DataFrame],
    doing: str,
    console: Console,
) -> None:
    """Write a file for each finished run that lacks it, or has a damaged one."""

    def lacks_it(cell: Cell) -> bool:
        try:
            read(cell)
        except UserError:
            return True
        return False

    todo = [cell for cell in cells if is_finished(cell) and lacks_it(cell)]
    th.set_num_threads(1)  # as in training: equal bytes everywhere
    for cell in track(todo, doing, console=console, disable=not todo):
        try:
            with only_writer(cell.directory):
                write_rows(cell.directory / name, work_out(cell))
                vouch_for(cell.directory, name)
        except UserError as error:
            console.print(f"no {name} of {cell.title}: {error}", markup=False, highlight=False, soft_wrap=True)
