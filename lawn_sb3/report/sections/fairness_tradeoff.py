"""Fairness against welfare: how much the UAVs have on average, and how evenly, a point a method."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lawn_sb3.report.cdf import planners
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.sections.fairness_table import HEADING, fairness
from lawn_sb3.report.style import colours, error_bars, legend_below, markers, use_house_style
from lawn_sb3.report.table import interval_of
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results

PANELS = {"jain": "Jain index of an episode's utilities", "worst_mbps": "utility of the worst UAV (Mbps)"}
"""Column of the table of fairness: what the axis calls it."""
CLOSER = " without the planners"
WEIGHTS = np.linspace(0.0, 1.0, 41)
"""Weights of the worst UAV's utility against the mean, from welfare alone to the worst UAV alone."""
FRONTIER = "Picked from all flights"
FAR_OFF = 0.5
"""A method with less than this share of the highest mean utility would squeeze all others into a corner."""


def section(results: Results) -> Section | None:
    """Fairness against welfare of all methods whose UAVs meet."""
    joint = results.without_bound()
    if not joint.methods:
        return None
    return Section(HEADING, {"fairness_tradeoff": Picture(_figure(joint), _caption(joint))})


def _drawn(results: Results) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Rows of the methods of the table of fairness that have a point, and of those that are too far off."""
    numbers = fairness(results).numbers
    near = numbers["utility_mbps"] >= FAR_OFF * numbers["utility_mbps"].max()
    return numbers[near], numbers[~near]


def frontier(results: Results) -> NDArray[np.float64]:
    """What the worst-off UAV can be given for how much welfare, as far as the flights of all methods tell.

    For each mission the joint flight is picked that has the highest weighted sum of mean utility and the worst UAV's
    utility, out of those of all methods and seeds.

    :param results: what the runs left
    :return: mean utility and the worst UAV's utility in Mbps, means over missions, for each weight [len(WEIGHTS), 2]
    """
    flights = np.concatenate([results.scores(key, "utility_mbps", per="uav") for key in results.methods])  # [R, E, N]
    mean, worst = flights.mean(axis=-1), flights.min(axis=-1)
    points = []
    for weight in WEIGHTS:
        picked = ((1.0 - weight) * mean + weight * worst).argmax(axis=0)[None]
        points.append([np.take_along_axis(values, picked, axis=0).mean() for values in (mean, worst)])
    return np.array(points)


def _figure(results: Results) -> Figure:
    """Fairness against mean utility, and once more without the planners, which lie far apart."""
    use_house_style()
    rows = _rows(results)
    figure = Figure(figsize=(10, 3.8 * len(rows)), layout="constrained")
    axes = figure.subplots(len(rows), len(PANELS), squeeze=False)
    for k, numbers in enumerate(rows):
        for ax, letter, (column, text) in zip(axes[k], "ab", PANELS.items(), strict=True):
            _draw(ax, results, numbers, column)
            ax.set(xlabel=QUANTITIES["utility_mbps"].axis_label, ylabel=text, title=f"({letter}){CLOSER if k else ''}")
    (line,) = axes[0, 1].plot(*frontier(results).T, color="0.2", linewidth=1.5, zorder=1)
    handles = [*axes[0, 0].get_legend_handles_labels()[0], line]
    line.set_label(FRONTIER)
    legend_below(figure, handles, 2.4)
    return figure


def _rows(results: Results) -> list[pd.DataFrame]:
    """What each row of panels shows."""
    near = _drawn(results)[0]
    others = near[~near["key"].isin(planners(results.methods))]
    return [near, others] if 1 < len(others) < len(near) else [near]


def _draw(ax: Axes, results: Results, numbers: pd.DataFrame, column: str) -> None:
    palette, looks = colours(results.recipe.methods), markers(results.recipe.methods)
    for _, row in numbers.iterrows():
        key, x, y = row["key"], row["utility_mbps"], row[column]
        across, up = (error_bars(interval_of(row, name)) for name in ("utility_mbps", column))
        ax.errorbar(x, y, xerr=across, yerr=up, fmt="none", ecolor=palette[key], elinewidth=1.2)
        ax.plot(x, y, looks[key], color=palette[key], markersize=7, label=row["method"])


def _caption(results: Results) -> str:
    off = [
        f"{row['method']} (mean U {row['utility_mbps']:.1f} Mbps, Jain index {row['jain']:.2f}, "
        f"worst UAV {row['worst_mbps']:.1f} Mbps)"
        for _, row in _drawn(results)[1].iterrows()
    ]
    again = " Bottom: the same without the planners." if len(_rows(results)) > 1 else ""
    outside = f" Far to the left and not drawn: {', '.join(off)}." if off else ""
    return (
        "Fairness against mean utility; means over the episodes and seeds with 95 % bootstrap intervals over seeds. "
        "Further to the right the UAVs of an episode have more on average, that is more welfare; further up they have "
        "it more evenly (a), or the one with the least has more (b). A method with another one above and to the right "
        "of it is worse in both. Line in (b): for each mission one joint flight picked out of those of all methods and "
        "seeds, at its right end for the highest mean utility, at its left end for the highest utility of the worst "
        f"UAV: so little has to be given up for the other.{again}{outside}"
    )
