"""Reading back what the cells of a recipe left; what is missing or damaged is named, and the rest goes on."""

from __future__ import annotations

from dataclasses import dataclass, field

import pandas as pd
from pandas.api.types import is_numeric_dtype

from lawn_sb3.experiment.cell import is_finished
from lawn_sb3.experiment.evaluation import COLUMNS, summarize
from lawn_sb3.experiment.recipe import Cell, Method, Recipe


@dataclass
class Results:
    """All that tables and figures are made of.

    :param recipe: the recipe
    :param episodes: raw rows of all evaluations, with the columns ``method`` and ``seed`` in front
    :param curves: rows of all ``progress.csv``, with the columns ``method`` and ``seed`` in front
    :param problems: one line for each file that could not be used
    """

    recipe: Recipe
    episodes: pd.DataFrame = field(default_factory=pd.DataFrame)
    curves: pd.DataFrame = field(default_factory=pd.DataFrame)
    problems: list[str] = field(default_factory=list)

    @property
    def methods(self) -> dict[str, Method]:
        """The methods that have results, in the recipe's order."""
        present = set(self.episodes["method"]) if len(self.episodes) else set()
        return {key: method for key, method in self.recipe.methods.items() if key in present}

    def by_seed(self) -> pd.DataFrame:
        """The summary of every evaluation.

        :return: one row for each method and seed
        """
        rows = [
            {"method": key, "seed": seed, **summarize(group)}
            for (key, seed), group in self.episodes.groupby(["method", "seed"], sort=False)
        ]
        return pd.DataFrame(rows)


def read_results(recipe: Recipe, cells: list[Cell]) -> Results:
    """Read the runs of a recipe.

    :param recipe: the recipe
    :param cells: its cells
    :return: what could be read, and what could not
    """
    results = Results(recipe)
    episodes, curves = [], []
    for cell in cells:
        name = f"{cell.key} seed {cell.seed}"
        if not (cell.directory / "config.yaml").exists():
            results.problems.append(f"{name}: no run yet")
            continue
        if not is_finished(cell):
            results.problems.append(f"{name}: not finished, or made with another configuration")
            continue
        rows = _read(cell, "evaluation.csv", COLUMNS, results.problems)
        if rows is None:
            continue
        if rows["arrived"].dtype != bool or not all(map(is_numeric_dtype, rows.dtypes)):
            results.problems.append(f"{name}: evaluation.csv holds values that are no numbers")
            continue
        expected = cell.evaluation.episodes * cell.scenario.num_uavs
        if len(rows) != expected or rows.isna().to_numpy().any():
            results.problems.append(f"{name}: evaluation.csv is cut off: {len(rows)} of {expected} rows")
            continue
        episodes.append(_labelled(rows, cell))
        if cell.method.algo is not None:
            curve = _read(cell, "progress.csv", ("time/env_steps",), results.problems)
            if curve is not None:
                curves.append(_labelled(curve, cell))
    if episodes:
        results.episodes = pd.concat(episodes, ignore_index=True)
    if curves:
        results.curves = pd.concat(curves, ignore_index=True)
    return results


def _labelled(rows: pd.DataFrame, cell: Cell) -> pd.DataFrame:
    labels = pd.DataFrame({"method": cell.key, "seed": cell.seed}, index=rows.index)
    return pd.concat([labels, rows], axis=1)


def _read(cell: Cell, name: str, columns: tuple[str, ...], problems: list[str]) -> pd.DataFrame | None:
    """Read a CSV file of a run; on failure add a line to the problems."""
    path = cell.directory / name
    try:
        rows = pd.read_csv(path)
    except (OSError, ValueError) as error:  # pandas' parser errors are ValueErrors
        problems.append(f"{cell.key} seed {cell.seed}: {name} cannot be read: {str(error).splitlines()[0]}")
        return None
    missing = [column for column in columns if column not in rows]
    if missing:
        problems.append(f"{cell.key} seed {cell.seed}: {name} lacks the columns {', '.join(missing)}")
        return None
    return rows
