"""Who got the low utilities: how evenly they fall on the UAVs, what evenness costs, and what makes them low."""

import math
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lawn_sb3.experiment.run_directory.reading import TOLERANCE
from lawn_sb3.game.fairness import gini, jain_index, nash_welfare
from lawn_sb3.report.bins import co_served_bounds, most_shown
from lawn_sb3.report.cdf import planners
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.style import colours, error_bars, legend_below, mark_cut, markers, use_house_style
from lawn_sb3.report.table import Table, interval_columns, interval_of, row_of, sample_of, table_of
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import mean_interval

UTILITY = QUANTITIES["utility_mbps"].axis_label
COLUMNS = {
    "jain": ("Jain index", 3),
    "gini": ("Gini", 3),
    "nash_welfare_mbps": ("Nash welfare (Mbps)", 1),
    "worst_mbps": ("Worst UAV's U (Mbps)", 1),
    "utility_mbps": ("Mean U (Mbps)", 1),
    "nobody_percent": ("Nobody arrives (%)", 1),
}
"""Column of the table of fairness: its heading and decimals."""
PANELS = {"jain": "Jain index of an episode's utilities", "worst_mbps": "utility of the worst UAV (Mbps)"}
"""Column of that table: what an axis calls it."""
CLOSER = " closer"
WEIGHTS = np.linspace(0.0, 1.0, 41)
"""Weights of the worst UAV's utility against the mean, from welfare alone to the worst UAV alone."""
FRONTIER = "Picked from all flights"
FAR_OFF = 0.5
"""A method with less than this share of the highest mean utility would squeeze all others into a corner."""
TRADEOFF = (
    "Fairness against mean utility; means over the episodes and seeds with 95 % bootstrap intervals over seeds. "
    "Axes do not begin at 0 (//). "
    "Further to the right the UAVs of an episode have more on average, that is more welfare; further up they have "
    "it more evenly (a), or the one with the least has more (b). A method with another one above and to the right "
    "of it is worse in both. Line in (b): for each mission one joint flight picked out of those of all methods and "
    "seeds, at its right end for the highest mean utility, at its left end for the highest utility of the worst "
    "UAV: so little has to be given up for the other."
)
"""Of the figure of fairness against mean utility."""
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
    """Fairness, and low utilities by what may cost utility, of all methods whose UAVs meet."""
    joint = results.without_bound()
    if not joint.methods:
        return None
    table = fairness(joint)
    by_cause = {cause: _cause_table(joint, cause) for cause in CAUSES}
    parts: dict[str, Table | Picture | None] = {
        "fairness": table,
        "fairness_tradeoff": _tradeoff(joint, table.numbers),
        "low_utilities": Picture(_by_cause(joint, by_cause), _cause_caption(joint)),
        "low_utility_by_load": by_cause["co_served"],
        "low_utility_by_delay": by_cause["detour"],
    }
    return Section("Who got the low utilities", parts)


def fairness(results: Results) -> Table:
    """How the methods spread utility over the UAVs of an episode: means over episodes, intervals over seeds."""
    rows = []
    for key in results.methods:
        utility = results.scores(key, "utility_mbps", per="uav")  # [S, E, N]
        by_seed = {
            "jain": jain_index(utility).mean(axis=-1),
            "gini": gini(utility).mean(axis=-1),
            "nash_welfare_mbps": nash_welfare(utility).mean(axis=-1),
            "worst_mbps": utility.min(axis=-1).mean(axis=-1),
            "utility_mbps": utility.mean(axis=(-2, -1)),
            "nobody_percent": 100.0 * (utility.max(axis=-1) == 0.0).mean(axis=-1),
        }
        row = row_of(results, key, seeds=len(utility))
        for name, (heading, decimals) in COLUMNS.items():
            row.add(name, heading, mean_interval(by_seed[name]), decimals)
        row.cells["n"] = sample_of(results, key)
        rows.append(row)
    caption = (
        f"How evenly the utilities U of an episode fall on its {results.recipe.game().num_uavs} UAVs. Jain index: 1 if "
        "all have the same, 1/N if one has everything; Gini: 0 and (N - 1)/N. An episode in which nobody arrives, and "
        "everybody has 0, counts as even, so both have to be read beside the share of such episodes. Nash welfare: the "
        "geometric mean of an episode's utilities, which is high if all have much and 0 if one has nothing. Worst UAV: "
        "lowest utility of an episode. Means with 95 % bootstrap intervals over seeds; n: seeds × test episodes."
    )
    return table_of(rows, caption)


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


def _tradeoff(results: Results, numbers: pd.DataFrame) -> Picture:
    """Fairness against mean utility, and once more without the planners but straight flight, which lie far apart."""
    use_house_style()
    near = numbers["utility_mbps"] >= FAR_OFF * numbers["utility_mbps"].max()
    drawn, off = numbers[near], numbers[~near]
    others = drawn[~drawn["key"].isin(planners(results.methods))]
    rows = [drawn, others] if 1 < len(others) < len(drawn) else [drawn]
    figure = Figure(figsize=(10, 3.8 * len(rows)), layout="constrained")
    axes = figure.subplots(len(rows), len(PANELS), squeeze=False)
    for k, shown in enumerate(rows):
        for ax, letter, (column, text) in zip(axes[k], "abcd"[2 * k :], PANELS.items(), strict=False):
            _draw_points(ax, results, shown, column)
            ax.set(xlabel=UTILITY, ylabel=text, title=f"({letter}){CLOSER if k else ''}")
            mark_cut(ax, x=True, y=True)
    (line,) = axes[0, 1].plot(*frontier(results).T, color="0.2", linewidth=1.5, zorder=1)
    handles = [*axes[0, 0].get_legend_handles_labels()[0], line]
    line.set_label(FRONTIER)
    legend_below(figure, handles, 2.4)
    again = " (c, d): the same closer, without all planners but straight flight." if len(rows) > 1 else ""
    return Picture(figure, f"{TRADEOFF}{again}{_far_off(off)}")


def _far_off(rows: pd.DataFrame) -> str:
    """End of the caption: the methods that are not drawn."""
    methods = [
        f"{row['method']} (mean U {row['utility_mbps']:.1f} Mbps, Jain index {row['jain']:.2f}, "
        f"worst UAV {row['worst_mbps']:.1f} Mbps)"
        for _, row in rows.iterrows()
    ]
    return f" Far to the left and not drawn: {', '.join(methods)}." if methods else ""


def _draw_points(ax: Axes, results: Results, numbers: pd.DataFrame, column: str) -> None:
    palette, looks = colours(results.recipe.methods), markers(results.recipe.methods)
    for _, row in numbers.iterrows():
        key, x, y = row["key"], row["utility_mbps"], row[column]
        across, up = (error_bars(interval_of(row, name)) for name in ("utility_mbps", column))
        ax.errorbar(x, y, xerr=across, yerr=up, fmt="none", ecolor=palette[key], elinewidth=1.2)
        ax.plot(x, y, looks[key], color=palette[key], markersize=7, label=row["method"])


def binned(results: Results, cause: Cause) -> tuple[pd.Series, list[str]]:
    """The index of each UAV-mission's bin, by the mean number of others in its cell or by T/T_min, and their names."""
    rows = results.episodes
    if cause == "co_served":
        most = most_shown(results.recipe.game().num_uavs, rows["mean_cell_load"].max())
        bounds = co_served_bounds(most)
        return _bins(rows["mean_cell_load"] - 1.0, bounds), _names(bounds)
    names = [*_names(DETOURS), FAILED]
    return _bins(rows["slots"] / rows["min_slots"], DETOURS).where(rows["arrived"], len(names) - 1), names


def _bins(values: pd.Series, bounds: tuple[float, ...]) -> pd.Series:
    """0 for values up to the first bound, 1 for those up to the second, and so on."""
    return pd.Series(np.searchsorted(np.array(bounds) + TOLERANCE, values), index=values.index)


def _names(bounds: tuple[float, ...]) -> list[str]:
    steps = [f"> {low:g}" if math.isinf(high) else f"({low:g}, {high:g}]" for low, high in pairwise(bounds)]
    return [f"{bounds[0]:g}", *steps]


def _cause_table(results: Results, cause: Cause) -> Table:
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
    return Table(pd.DataFrame(rows), pd.DataFrame(shown), _cause_caption(results, cause))


def _by_cause(results: Results, tables: dict[Cause, Table]) -> Figure:
    """A point is the mean utility of a method in a bin, its bar the 95 % interval over seeds."""
    use_house_style()
    palette, looks, methods = colours(results.recipe.methods), markers(results.recipe.methods), results.methods
    stacked = len(methods) > MOST_ABREAST
    figure = Figure(figsize=(10, 6.4) if stacked else (10, 3.6), layout="constrained")
    axes = figure.subplots(*((len(CAUSES), 1) if stacked else (1, len(CAUSES))), sharey=True)
    offsets = np.linspace(-0.4, 0.4, len(methods)) if len(methods) > 1 else np.zeros(1)
    for ax, (cause, text) in zip(axes, CAUSES.items(), strict=True):
        numbers, names = tables[cause].numbers, binned(results, cause)[1]
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
            ax.set_ylabel(UTILITY)
    handles = [
        Line2D([], [], marker=looks[key], color=palette[key], markersize=5, linestyle="", label=method.label)
        for key, method in methods.items()
    ]
    if any(table.numbers["utility_mbps_low"].isna().any() for table in tables.values()):
        look: dict[str, Any] = {"color": "0.3", "markerfacecolor": "white", "markersize": 5}
        handles.append(Line2D([], [], marker="o", linestyle="", label="hollow: of one seed alone", **look))
    legend_below(figure, handles, 2.4)
    return figure


def _cause_caption(results: Results, cause: Cause | None = None) -> str:
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
