"""Scaling out: what actors do among more or fewer UAVs than they were trained with, without retraining."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.report.style import colours, legend_below, use_house_style
from lawn_sb3.report.table import Table, interval_columns
from lawn_sb3.results.statistics import Interval, mean_interval

MARKERS = "osD^vPX*"
"""Colours repeat when there are many methods; with markers and line styles no two look alike."""
LineStyle = Literal["-", "--", "-.", ":"]
STYLES: tuple[LineStyle, ...] = ("-", "-.", ":")
"""Of learners; players that do not learn are dashed, as in Fig. 2."""


class Scaled(NamedTuple):
    """A figure that is followed over the number of UAVs."""

    heading: str
    axis: str
    decimals: int


QUANTITIES = {
    "utility_mbps": Scaled("U (Mbps)", "mean utility $U_i$ (Mbps)", 2),
    "success_percent": Scaled("Success (%)", "success (%)", 1),
    "collisions": Scaled("Collisions", "collisions a UAV and mission", 2),
}
"""Column of ``scaling.csv``: how it is shown."""
MEANS = (
    "reward", "rate_mbps", "makespan_slots", "completion_slots", "utility_mbps", "success_percent", "collisions",
    "welfare_mbps",
)  # fmt: skip
"""Columns of ``scaling.csv`` with means over the episodes."""


def scaling_table(rows: pd.DataFrame, recipe: Recipe) -> Table:
    """Utility, success and collisions of every method by number of UAVs.

    :param rows: ``scaling`` of the results
    :param recipe: the recipe
    :return: one row for each quantity and method, a column for each number of UAVs; numbers have one row for each
        method and number of UAVs, with all figures
    """
    means, labels = _means(rows, MEANS), _labels(rows, recipe)
    numbers = [
        {
            "method": labels[key],
            "key": key,
            "num_uavs": num_uavs,
            "seeds": rows.loc[rows["method"] == key, "seed"].nunique(),
            "episodes": rows["episodes"].iloc[0],
            **interval_columns(figures),
        }
        for key in labels
        for num_uavs, figures in means[key].items()
    ]
    shown = [
        {
            "Quantity": quantity.heading,
            "Method": labels[key],
            **{f"N = {num_uavs}": own[name].text(quantity.decimals) for num_uavs, own in means[key].items()},
            "n": f"{rows.loc[rows['method'] == key, 'seed'].nunique()} × {rows['episodes'].iloc[0]}",
        }
        for name, quantity in QUANTITIES.items()
        for key in labels
    ]
    text = f"{caption(rows, recipe)} In brackets those intervals. n: seeds × test episodes for each N."
    return Table(pd.DataFrame(numbers), pd.DataFrame(shown), text)


def scaling_figure(rows: pd.DataFrame, recipe: Recipe) -> Figure:
    """Utility, success and collisions against the number of UAVs.

    :param rows: ``scaling`` of the results
    :param recipe: the recipe
    :return: the figure: a line a method, with a band for its interval over seeds
    """
    use_house_style()
    figure = Figure(figsize=(10, 3.6), layout="constrained")
    axes = figure.subplots(1, len(QUANTITIES))
    means, labels = _means(rows, QUANTITIES), _labels(rows, recipe)
    palette, looks = colours(labels), _looks(recipe, list(labels))
    for ax, (name, quantity) in zip(axes, QUANTITIES.items(), strict=True):
        for key in labels:
            _draw_line(ax, {n: own[name] for n, own in means[key].items()}, palette[key], *looks[key])
        _finish(ax, sorted(rows["num_uavs"].unique()), recipe.game().num_uavs)
        ax.set_ylabel(quantity.axis)
    axes[0].set_ylim(bottom=-0.5)
    axes[1].set_ylim(-2.0, 102.0)
    _spread_collisions(axes[2], rows["collisions"])
    handles = [_line(palette[key], *looks[key], label) for key, label in labels.items()]
    legend_below(figure, handles, 3.2)
    return figure


def _spread_collisions(ax: Axes, collisions: pd.Series) -> None:
    """Some collide hundreds of times as often as others, and a UAV alone never does: logarithmic down to near 0."""
    some = collisions[collisions > 0.0]
    if len(some):
        linear_to = 10.0 ** np.ceil(np.log10(some.min()))
        ax.set_yscale("symlog", linthresh=linear_to)
        ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        ax.set_ylim(-0.08 * linear_to, 1.5 * max(some.max(), linear_to))


def caption(rows: pd.DataFrame, recipe: Recipe) -> str:
    """What the figure of scaling out shows.

    :param rows: ``scaling`` of the results
    :param recipe: the recipe
    :return: one paragraph
    """
    return (
        f"Players among N UAVs; learners were trained with N = {recipe.game().num_uavs} (dotted) and not again. Each N "
        f"has {rows['episodes'].iloc[0]} missions of its own, the same for all players and seeds, so from N to N the "
        "missions change too. Collisions: of a UAV in a mission; their axis is linear up to its second tick. "
        "Means over seeds with 95 % bootstrap intervals over seeds, which with five seeds hold the true mean in about "
        "five of six cases."
    )


def _means(rows: pd.DataFrame, names: Iterable[str]) -> dict[str, dict[int, dict[str, Interval]]]:
    """Mean over seeds by method, number of UAVs and figure."""
    found: dict[str, dict[int, dict[str, Interval]]] = {}
    for key, own in rows.groupby("method"):
        found[str(key)] = {
            num_uavs: {name: mean_interval(own.loc[own["num_uavs"] == num_uavs, name]) for name in names}
            for num_uavs in sorted(own["num_uavs"].unique().tolist())
        }
    return found


def _labels(rows: pd.DataFrame, recipe: Recipe) -> dict[str, str]:
    """What the flown methods are called, in the recipe's order; an ablation's label alone may not say of what."""
    present, labels = set(rows["method"]), {}
    for key, method in recipe.methods.items():
        if key in present:
            of = "" if method.baseline is None else f"{recipe.methods[method.baseline].label}: "
            labels[key] = of + method.label
    return labels


def _looks(recipe: Recipe, methods: list[str]) -> dict[str, tuple[LineStyle, str]]:
    """Line and marker of each method."""
    looks: dict[str, tuple[LineStyle, str]] = {}
    for place, key in enumerate(methods):
        style = STYLES[place // len(MARKERS) % len(STYLES)]
        looks[key] = "--" if recipe.methods[key].player else style, MARKERS[place % len(MARKERS)]
    return looks


def _draw_line(ax: Axes, means: dict[int, Interval], colour: str, style: LineStyle, marker: str) -> None:
    values = np.array(list(means.values()))  # [N, 3]
    ax.plot(list(means), values[:, 0], color=colour, linestyle=style, marker=marker, markersize=4.5, linewidth=1.3)
    ax.fill_between(list(means), values[:, 1], values[:, 2], color=colour, alpha=0.2, linewidth=0)


def _line(colour: str, style: LineStyle, marker: str, label: str) -> Line2D:
    return Line2D([], [], color=colour, linestyle=style, marker=marker, markersize=5, label=label)


def _finish(ax: Axes, flown: list[int], trained: int) -> None:
    """Ticks at the numbers of UAVs that were flown, and a line where actors were trained."""
    ax.set_xscale("log", base=2)
    ax.set_xticks(flown, list(map(str, flown)))
    ax.set_xlabel("UAVs N")
    ax.axvline(trained, color="0.4", linestyle=":", linewidth=1.2, zorder=1)
    ax.annotate(
        f"trained: N = {trained}", (trained, 1.0), xycoords=ax.get_xaxis_transform(), xytext=(0, 3),
        textcoords="offset points", ha="center", fontsize="small",
    )  # fmt: skip
