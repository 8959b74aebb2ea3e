"""Distributions of a quantity over all UAVs: a curve a method, those of the planners in a panel of their own."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lawn_sb3.experiment.recipe import Method
from lawn_sb3.report.style import colours, line_of, use_house_style
from lawn_sb3.results.results import Results

TITLES = "(a) learners, random and straight flight", "(b) planners"
NOT_PLANNERS = ("random", "shortest-path")
"""Players without training that every figure has beside the learners."""


def planners(methods: Mapping[str, Method]) -> dict[str, Method]:
    """Those of some methods that plan; the bound is one of them."""
    return {
        key: method
        for key, method in methods.items()
        if method.player is not None and method.player not in NOT_PLANNERS
    }


def references(methods: Mapping[str, Method]) -> dict[str, Method]:
    """The methods that are drawn again beside the planners: straight flight, and a learner.

    The learner is MAPPO whose critic reads [o_i, x] if there is one, or the first.
    """
    straight = [key for key, method in methods.items() if method.player == "shortest-path"]
    learners = [key for key, method in methods.items() if method.algo is not None]
    learners.sort(key=lambda key: methods[key].policy != "centralized_critic")  # stable: otherwise in order
    return {key: methods[key] for key in (*straight[:1], *learners[:1])}


def distributions(
    results: Results, rows: pd.DataFrame, column: str, xlabel: str, ylabel: str, end: float | None = None
) -> Figure:
    """Draw the empirical distribution of a column, a curve a method.

    :param results: what the runs left
    :param rows: one of its tables, or one like it, with one row per UAV and episode
    :param column: a column of 0 or more
    :param xlabel: what it is
    :param ylabel: what the share of the UAVs is called
    :param end: where the axis ends; at the highest value if left out
    :return: the figure: one panel, or two if there are planners; a line is all seeds together, its band their range
    """
    use_house_style()
    shown = _by_panel(results.methods_in(rows))
    figure = Figure(figsize=(7, 4.5) if len(shown) == 1 else (11, 4.8), layout="constrained")
    grid = np.linspace(0.0, end or max(rows[column].max(), 1.0) * 1.02, 400)
    for k, ax in enumerate(figure.subplots(1, len(shown), sharex=True, sharey=True, squeeze=False)[0]):
        _draw(ax, results, rows, column, list(shown[k]), grid)
        ax.set(xlabel=xlabel, ylabel="" if k else ylabel, xlim=(0, grid[-1]), ylim=(0, 1.02))
        ax.legend(loc="best", frameon=True)
        if len(shown) > 1:
            ax.set_title(TITLES[k])
    return figure


def _by_panel(methods: Mapping[str, Method]) -> list[dict[str, Method]]:
    """The methods of each panel."""
    planning = planners(methods)
    others = {key: method for key, method in methods.items() if key not in planning}
    return [others, references(others) | planning] if planning and others else [dict(methods)]


def panels_text(results: Results, rows: pd.DataFrame) -> str:
    """What the panels hold, for the caption: a sentence with a space behind it, or nothing if there is one panel."""
    shown = _by_panel(results.methods_in(rows))
    if len(shown) == 1:
        return ""
    again = " and ".join(method.label for key, method in shown[1].items() if key in shown[0])
    beside = f", with {again} once more" if again else ""
    return f"(b): planners{beside}. "


def _draw(ax: Axes, results: Results, rows: pd.DataFrame, column: str, keys: list[str], grid: np.ndarray) -> None:
    methods = results.recipe.methods
    palette = colours(methods)
    for key in keys:
        own = rows[rows["method"] == key]
        by_seed = np.array([_cdf(of_seed[column], grid) for _, of_seed in own.groupby("seed")])
        ax.fill_between(grid, by_seed.min(axis=0), by_seed.max(axis=0), color=palette[key], alpha=0.25, linewidth=0)
        ax.plot(grid, _cdf(own[column], grid), color=palette[key], linestyle=line_of(key), label=methods[key].label)


def _cdf(values: pd.Series, grid: np.ndarray) -> np.ndarray:
    """Share of the values up to each point of the grid."""
    ordered = np.sort(values.to_numpy())
    share: np.ndarray = np.searchsorted(ordered, grid, side="right") / len(ordered)
    return share
