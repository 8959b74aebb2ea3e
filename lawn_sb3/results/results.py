"""Reading back what the cells of a recipe left; what is missing or damaged is named, and the rest goes on."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Literal, Self

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.experiment.recipe import Method, Recipe
from lawn_sb3.experiment.run_directory.configuration import is_finished
from lawn_sb3.experiment.run_directory.files import CONFIG_FILE, MANIFEST_FILE
from lawn_sb3.experiment.run_directory.manifest import altered_files
from lawn_sb3.experiment.run_directory.progress import read_progress
from lawn_sb3.experiment.run_directory.reading import (
    read_costs,
    read_evaluation,
    read_paths,
    read_regrets,
    read_sampled,
    read_scaling,
    read_slots,
)
from lawn_sb3.results.statistics import Interval, mean_interval

TABLES = ("slots", "paths", "curves", "sampled", "regrets", "scaling", "costs")
"""Tables of :class:`Results` beside the evaluations."""
BOUND = "bound"
"""The player that gives every UAV a game of its own: its UAVs never meet, and there is nobody to respond to."""
EQUILIBRIA = ("equilibrium", "worst-equilibrium")
"""Players that look for equilibria."""


@dataclass
class Results:
    """All that tables and figures are made of; every table has the columns ``method`` and ``seed`` in front.

    :param recipe: the recipe
    :param episodes: raw rows of all evaluations
    :param curves: rows of all ``progress.csv``
    :param problems: one line for each file that could not be used
    :param slots: rows of all ``slots.csv``
    :param paths: rows of all ``paths.csv``
    :param sampled: raw rows of all evaluations with sampled actions
    :param regrets: rows of all ``regret.csv``; none of the bound
    :param scaling: rows of all ``scaling.csv``
    :param costs: rows of all ``costs.csv``
    :param checks: what was flown besides the runs, by name: its rows, or why it cannot be made
    """

    recipe: Recipe
    episodes: pd.DataFrame = field(default_factory=pd.DataFrame)
    curves: pd.DataFrame = field(default_factory=pd.DataFrame)
    problems: list[str] = field(default_factory=list)
    slots: pd.DataFrame = field(default_factory=pd.DataFrame)
    paths: pd.DataFrame = field(default_factory=pd.DataFrame)
    sampled: pd.DataFrame = field(default_factory=pd.DataFrame)
    regrets: pd.DataFrame = field(default_factory=pd.DataFrame)
    scaling: pd.DataFrame = field(default_factory=pd.DataFrame)
    costs: pd.DataFrame = field(default_factory=pd.DataFrame)
    checks: dict[str, pd.DataFrame | str] = field(default_factory=dict)

    @property
    def methods(self) -> dict[str, Method]:
        """The methods that have results, in the recipe's order."""
        return self.methods_in(self.episodes)

    def methods_in(self, rows: pd.DataFrame) -> dict[str, Method]:
        """The methods that a table has rows of, in the recipe's order."""
        present = set(rows["method"].unique()) if len(rows) else set()
        return {key: method for key, method in self.recipe.methods.items() if key in present}

    def without_bound(self) -> Self:
        """The same without the rows of the bound, for all that is about UAVs that meet; the recipe stays."""
        bounds = [key for key, method in self.recipe.methods.items() if method.player == BOUND]
        rest = replace(self)
        for name, rows in vars(self).items():
            if isinstance(rows, pd.DataFrame) and len(rows):
                setattr(rest, name, rows[~rows["method"].isin(bounds)])
        return rest

    def by_seed(self) -> pd.DataFrame:
        """The summary of every evaluation, one row for each method and seed."""
        rows = [
            {"method": key, "seed": seed, **summarize(group)}
            for (key, seed), group in self.episodes.groupby(["method", "seed"], sort=False)
        ]
        return pd.DataFrame(rows)

    def seeds(self, method: str) -> list[int]:
        """The seeds of a method that have results, in ascending order."""
        rows = self.episodes
        return sorted(rows.loc[rows["method"] == method, "seed"].unique().tolist()) if len(rows) else []

    def extent(self, rows: pd.DataFrame) -> str:
        """Over how much a mean of every method in a table is taken: ``200 test episodes of each of 5 seeds``."""
        counts = rows.groupby("method")["seed"].nunique() if len(rows) else pd.Series([0])
        seeds = " to ".join(map(str, sorted({int(counts.min()), int(counts.max())})))
        return f"{self.recipe.evaluation.episodes} test episodes of each of {seeds} seed{'' if seeds == '1' else 's'}"

    def scores(self, method: str, name: str, per: Literal["episode", "uav"] = "episode") -> NDArray[np.float64]:
        """The values of one column of the evaluations, ready for statistics.

        :param method: its key in the recipe
        :param name: the column, such as ``reward``; ``success_percent`` is made of ``arrived``
        :param per: ``episode`` averages over the UAVs of an episode
        :return: values [S, E], or [S, E, N] per UAV: seeds, episodes and UAVs in ascending order
        :raises UserError: if the method has no results, or there is no such column
        """
        return score_matrix(self.episodes, method, name, per)

    def mean(self, method: str, name: str) -> Interval:
        """The mean over seeds of one column of the evaluations, with its bootstrap interval; see :meth:`scores`."""
        return mean_interval(self.scores(method, name).mean(axis=1))


def score_matrix(
    rows: pd.DataFrame, method: str, name: str, per: Literal["episode", "uav"] = "episode"
) -> NDArray[np.float64]:
    """The same as :meth:`Results.scores` of any raw rows with the columns ``method`` and ``seed``."""
    known: set[str] = set(rows["method"].unique()) if len(rows) else set()
    if method not in known:
        raise unknown_name("method with results", method, known)
    if name == "success_percent":
        return 100.0 * score_matrix(rows, method, "arrived", per)
    if name not in rows:
        raise unknown_name("column", name, rows.columns)
    own = rows[rows["method"] == method].sort_values(["seed", "episode", "uav"])
    shape = [own[column].nunique() for column in ("seed", "episode", "uav")]
    values = own[name].to_numpy(dtype=np.float64).reshape(shape)
    return values if per == "uav" else values.mean(axis=-1)


def read_results(recipe: Recipe, cells: Sequence[Cell], tables: Collection[str] = TABLES) -> Results:
    """Read the runs of a recipe.

    :param recipe: the recipe
    :param cells: its cells
    :param tables: the tables to read beside ``episodes``
    :return: what could be read, and what could not
    """
    results = Results(recipe)
    parts: dict[str, list[pd.DataFrame]] = {name: [] for name in ("episodes", *tables)}
    for cell in cells:
        if not (cell.directory / CONFIG_FILE).exists():
            other = cell.directory.exists() and (not cell.directory.is_dir() or any(cell.directory.iterdir()))
            results.problems.append(f"{cell.title}: {f'no {CONFIG_FILE} there: not a run' if other else 'no run yet'}")
            continue
        if not is_finished(cell):
            results.problems.append(f"{cell.title}: not finished, or made with another configuration")
            continue
        if (tables_read := _read_run(recipe, cell, tables, results.problems)) and _is_altered(cell, results.problems):
            continue
        for table, rows in tables_read.items():
            labels = pd.DataFrame({"method": cell.key, "seed": cell.seed}, index=rows.index)
            parts[table].append(pd.concat([labels, rows], axis=1))
    for table, frames in parts.items():
        if frames:
            setattr(results, table, pd.concat(frames, ignore_index=True))
    return results


def _is_altered(cell: Cell, problems: list[str]) -> bool:
    """Whether a run is not as it was left; adds a line that says so."""
    try:
        altered = altered_files(cell.directory)
    except UserError as error:
        problems.append(f"{cell.title}: {error}")
        return True
    if altered:
        problems.append(f"{cell.title}: {', '.join(altered)} not as the run left it, by its {MANIFEST_FILE}")
    return bool(altered)


def _read_run(recipe: Recipe, cell: Cell, tables: Collection[str], problems: list[str]) -> dict[str, pd.DataFrame]:
    """The tables of one run that are whole; nothing without its evaluation. Adds a line for each that is not."""
    try:
        evaluation = read_evaluation(cell)
    except UserError as error:
        problems.append(f"{cell.title}: {error}")
        return {}
    trains, scaling = cell.method.algo is not None, recipe.scaling
    readers: dict[str, Callable[[], pd.DataFrame]] = {
        "slots": lambda: read_slots(cell, evaluation),
        "paths": lambda: read_paths(cell, evaluation),
    }
    if trains:
        readers["curves"] = lambda: read_progress(cell)
    if trains and cell.evaluation.deterministic:
        readers["sampled"] = lambda: read_sampled(cell, evaluation)
    if recipe.regret and cell.method.player != BOUND:
        readers["regrets"] = lambda: read_regrets(cell, evaluation)
    if scaling is not None and cell.key in scaling.methods:
        readers["scaling"] = partial(read_scaling, cell, scaling)
        if scaling.costs:
            readers["costs"] = partial(read_costs, cell, scaling)
    found = {"episodes": evaluation}
    for table, read in readers.items():
        if table in tables:
            try:
                found[table] = read()
            except UserError as error:
                problems.append(f"{cell.title}: {error}")
    return found
