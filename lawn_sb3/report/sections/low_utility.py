"""Who gets the low utilities: utility by how many others shared the cell, and by how long the mission took."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Literal

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from lawn_sb3.experiment.run_directory.reading import TOLERANCE
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.sections.fairness_table import HEADING
from lawn_sb3.report.style import colours, legend_below, markers, use_house_style
from lawn_sb3.report.table import Table, interval_columns
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import mean_interval

MOST_BINS = 7
"""Bins of the co-served UAVs beyond the one for nobody."""
DETOURS = (1.0, 1.5, 2.0, math.inf)
"""Bounds of the bins of T/T_min, each bin closed at its upper end."""
FAILED = "failed"
MOST_ABREAST = 8
"""With more methods the panels stand below each other, so that points of a bin stay apart."""
Cause = Literal["co_served", "detour"]
CAUSES: dict[Cause, str] = {
    "co_served": "other UAVs in the own cell, mean over the mission",
    "detour": "flight time over the least possible, $T_i/T_i^{\\min}$",
}
"""What may cost utility, as the axes call it."""
HEADINGS: dict[Cause, str] = {"co_served": "{} others", "detour": "T/T_min {}"}
"""What the tables call a bin."""


def section(results: Results) -> Section | None:
    """Low utilities of all methods whose UAVs meet."""
    joint = results.without_bound()
    if not joint.methods:
        return None
    figure = Picture(_figure(joint), _caption(joint))
    by_load, by_delay = (_table(joint, cause) for cause in CAUSES)
    return Section(HEADING, {"low_utilities": figure, "low_utility_by_load": by_load, "low_utility_by_delay": by_delay})


def binned(results: Results, cause: Cause) -> tuple[pd.Series, list[str]]:
    """Sort all UAV-missions into bins.

    :param results: what the runs left
    :param cause: by the mean number of other UAVs in the own cell, or by T/T_min
    :return: the index of each mission's bin, and the names of the bins
    """
    rows = results.episodes
    if cause == "co_served":
        bounds = co_served_bounds(results.recipe.game().num_uavs)
        return _bins(rows["mean_cell_load"] - 1.0, bounds), _names(bounds)
    names = [*_names(DETOURS), FAILED]
    return _bins(rows["slots"] / rows["min_slots"], DETOURS).where(rows["arrived"], len(names) - 1), names


def co_served_bounds(num_uavs: int) -> tuple[float, ...]:
    """Bounds of the bins of co-served UAVs.

    :param num_uavs: UAVs of an episode N
    :return: 0, then equal steps up to N - 1 or beyond: of one UAV, or of more where that made too many bins
    """
    step = max(math.ceil((num_uavs - 1) / MOST_BINS), 1)
    return tuple(float(bound) for bound in range(0, num_uavs - 1 + step, step))


def _bins(values: pd.Series, bounds: tuple[float, ...]) -> pd.Series:
    """0 for values up to the first bound, 1 for those up to the second, and so on."""
    return pd.Series(np.searchsorted(np.array(bounds) + TOLERANCE, values), index=values.index)


def _names(bounds: tuple[float, ...]) -> list[str]:
    steps = [f"> {low:g}" if math.isinf(high) else f"({low:g}, {high:g}]" for low, high in pairwise(bounds)]
    return [f"{bounds[0]:g}", *steps]


def _table(results: Results, cause: Cause) -> Table:
    """A column for each bin; as numbers one row for each method and bin that has missions."""
    bins, names = binned(results, cause)
    rows, cells = [], {}
    for key, method in results.methods.items():
        own = results.episodes[results.episodes["method"] == key]
        for index, missions in own.groupby(bins[own.index]):
            interval = mean_interval(missions.groupby("seed")["utility_mbps"].mean())
            name, count = names[int(index)], len(missions)
            figures = interval_columns({"utility_mbps": interval})
            rows.append({"method": method.label, "key": key, cause: name, **figures, "missions": count})
            cells[key, name] = f"{interval.text(1)}, n = {count:,}"
    shown = {"Method": [method.label for method in results.methods.values()]}
    for name in names:
        heading = name if name == FAILED else HEADINGS[cause].format(name)
        shown[heading] = [cells.get((key, name), "") for key in results.methods]
    return Table(pd.DataFrame(rows), pd.DataFrame(shown), _caption(results, cause))


def _figure(results: Results) -> Figure:
    """A point is the mean utility of a method in a bin, its bar the 95 % interval over seeds."""
    use_house_style()
    palette, looks, methods = colours(results.recipe.methods), markers(results.recipe.methods), results.methods
    stacked = len(methods) > MOST_ABREAST
    figure = Figure(figsize=(10, 6.4) if stacked else (10, 3.6), layout="constrained")
    axes = figure.subplots(*((len(CAUSES), 1) if stacked else (1, len(CAUSES))), sharey=True)
    offsets = np.linspace(-0.4, 0.4, len(methods)) if len(methods) > 1 else np.zeros(1)
    for ax, (cause, text) in zip(axes, CAUSES.items(), strict=True):
        numbers, names = _table(results, cause).numbers, binned(results, cause)[1]
        for k, (key, method) in enumerate(methods.items()):
            own = numbers[numbers["key"] == key]
            known = own["utility_mbps_low"].notna().to_numpy()
            x = own[cause].map(names.index).to_numpy() + offsets[k]
            value = own["utility_mbps"].to_numpy()
            bounds = own[["utility_mbps_low", "utility_mbps_high"]].to_numpy().T
            ax.errorbar(x, value, np.abs(bounds - value), fmt="none", ecolor=palette[key], elinewidth=1.2)
            ax.plot(x[known], value[known], looks[key], color=palette[key], markersize=5, label=method.label)
            ax.plot(x[~known], value[~known], looks[key], color=palette[key], markersize=5, markerfacecolor="white")
        ax.set_xticks(range(len(names)), names)
        ax.set_xlim(-0.5, len(names) - 0.5)
        ax.grid(axis="x", visible=False)
        for edge in np.arange(0.5, len(names) - 1):
            ax.axvline(edge, color="0.85", linewidth=0.8, zorder=0)
        ax.set_xlabel(text)
        if stacked or cause == "co_served":
            ax.set_ylabel(QUANTITIES["utility_mbps"].axis_label)
    legend_below(figure, figure.axes[0].get_legend_handles_labels()[0], 2.4)
    return figure


def _caption(results: Results, cause: Cause | None = None) -> str:
    """What one of the tables shows; without a cause, what the figure shows."""
    by = {
        "co_served": "the mean number of other UAVs in the own cell",
        "detour": "the flight time T over the least possible T_min",
    }
    what = " and by ".join(by.values()) if cause is None else by[cause]
    hollow = " Hollow: only one seed has such missions." if cause is None else " n: UAV-missions of all seeds."
    return (
        f"Mean utility (Mbps) of UAV-missions by {what}; a failed mission has utility 0. Mean over seeds of "
        f"{results.extent(results.episodes)}, with 95 % bootstrap intervals over the seeds that have such missions."
        f"{hollow}"
    )
