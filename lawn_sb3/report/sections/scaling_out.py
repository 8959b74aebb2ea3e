"""Scaling out: what actors do among more or fewer UAVs than they were trained with, without retraining."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.style import colours, legend_below, line_of, mark_cut, markers, use_house_style
from lawn_sb3.report.table import Table, interval_columns, sample_text
from lawn_sb3.results.quantities import QUANTITIES, Quantity
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import Interval, mean_interval

COLUMNS = (
    "reward", "rate_mbps", "makespan_slots", "completion_slots", "utility_mbps", "success_percent", "collisions",
    "welfare_mbps",
)  # fmt: skip
"""Columns of ``scaling.csv`` with means over the episodes."""
DECIMALS = {"utility_mbps": 2, "success_percent": 1, "collisions": 2}
"""The quantities that are shown; with them their costs, where they were measured."""
COSTS = {
    "decision_ms": Quantity("time of a decision", "time of a decision", "ms", 3, 3, "time of a decision", False),
    "memory_mb": Quantity("memory", "memory", "MB", 0, 0, "peak memory", False),
}
"""Columns of ``costs.csv``, where the recipe asks for them."""
Means = dict[str, dict[int, dict[str, Interval]]]
"""Mean over seeds by method, number of UAVs and column of ``scaling.csv`` and ``costs.csv``."""


def section(results: Results) -> Section | None:
    """Flights with other numbers of UAVs, where the recipe asks for them."""
    if not len(results.scaling):
        return None
    means = _means(results.scaling, results.costs)
    parts: dict[str, Table | Picture | None] = {
        "scaling_out": Picture(_figure(results, means), _caption(results, means)),
        "scaling": _table(results, means),
    }
    return Section("Other numbers of UAVs", parts)


def _means(*tables: pd.DataFrame) -> Means:
    found: Means = {}
    for rows in tables:
        columns = [name for name in (*COLUMNS, *COSTS) if name in rows]
        for _, own in rows.groupby(["method", "num_uavs"]) if len(rows) else ():
            key, num_uavs = str(own["method"].iloc[0]), int(own["num_uavs"].iloc[0])
            by_column = found.setdefault(key, {}).setdefault(num_uavs, {})
            by_column |= {name: mean_interval(own[name]) for name in columns}
    return found


def _shown(results: Results) -> dict[str, Quantity]:
    """The quantities that are shown."""
    return {name: QUANTITIES[name] for name in DECIMALS} | (COSTS if len(results.costs) else {})


def _labels(results: Results) -> dict[str, str]:
    """What the flown methods are called; an ablation's label alone may not say of what."""
    methods, labels = results.recipe.methods, {}
    for key, method in results.methods_in(results.scaling).items():
        of = "" if method.baseline is None else f"{methods[method.baseline].label}: "
        labels[key] = of + method.label
    return labels


def _table(results: Results, means: Means) -> Table:
    """A column for each number of UAVs; numbers have one row for each method and number of UAVs, with all means."""
    rows, labels = results.scaling, _labels(results)
    seeds = rows.groupby("method")["seed"].nunique()
    episodes = rows.groupby("num_uavs")["episodes"].first()
    flown = [int(num_uavs) for num_uavs in episodes.index]
    numbers = [
        {
            "method": label,
            "key": key,
            "num_uavs": num_uavs,
            "seeds": seeds[key],
            "episodes": episodes[num_uavs],
            **interval_columns(figures),
        }
        for key, label in labels.items()
        for num_uavs, figures in means[key].items()
    ]
    shown = [
        {
            "Quantity": quantity.heading,
            "Method": label,
            **{f"N = {num_uavs}": _text(means[key].get(num_uavs, {}), name, quantity) for num_uavs in flown},
            "n": sample_text(seeds[key], " / ".join(map(str, dict.fromkeys(episodes)))),
        }
        for name, quantity in _shown(results).items()
        for key, label in labels.items()
    ]
    text = f"{_caption(results, means)} In brackets those intervals. n: seeds × test episodes for each N"
    if len(results.costs):
        text += "; what a decision costs is measured on one game. –: not flown"
    return Table(pd.DataFrame(numbers), pd.DataFrame(shown), f"{text}.")


def _text(means: dict[str, Interval], name: str, quantity: Quantity) -> str:
    """A mean as a table shows it; a dash where it was not flown."""
    return means[name].text(DECIMALS.get(name, quantity.decimals)) if name in means else "–"


def _figure(results: Results, means: Means) -> Figure:
    """Utility, success and collisions against the number of UAVs, with bands for the intervals over seeds."""
    use_house_style()
    shown, rows, labels = _shown(results), results.scaling, _labels(results)
    lines = -(-len(shown) // len(DECIMALS))
    figure = Figure(figsize=(10, 3.6 * lines), layout="constrained")
    axes = figure.subplots(lines, len(DECIMALS), squeeze=False).ravel()
    for ax in axes[len(shown) :]:
        ax.remove()
    palette, looks = colours(labels), markers(labels)
    style: dict[str, dict[str, Any]] = {
        key: {"color": palette[key], "linestyle": line_of(key), "marker": looks[key]} for key in labels
    }
    for ax, (name, quantity) in zip(axes, shown.items(), strict=False):
        for key in labels:
            own = {num_uavs: found[name] for num_uavs, found in means[key].items() if name in found}
            num_uavs, values = list(own), np.array(list(own.values())).reshape(-1, 3)  # [N, 3]
            ax.plot(num_uavs, values[:, 0], markersize=4.5, linewidth=1.3, **style[key])
            ax.fill_between(num_uavs, values[:, 1], values[:, 2], color=palette[key], alpha=0.2, linewidth=0)
        _finish(ax, sorted(rows["num_uavs"].unique()), results.recipe.game().num_uavs)
        ax.set_ylabel(quantity.axis_label)
        if name == "decision_ms":
            ax.set_yscale("log")
        elif name == "memory_mb":
            ax.set_ylim(bottom=0.0)
    if _is_cut(means):
        mark_cut(axes[0], y=True)
    else:
        axes[0].set_ylim(bottom=-0.5)
    axes[1].set_ylim(-2.0, 102.0)
    _spread_collisions(axes[2], rows["collisions"])
    handles = [Line2D([], [], markersize=5, label=label, **style[key]) for key, label in labels.items()]
    legend_below(figure, handles, 3.2)
    return figure


def _is_cut(means: Means) -> bool:
    """Whether utilities lie so close to each other that their axis does not begin at 0."""
    utilities = [found["utility_mbps"].value for by_number in means.values() for found in by_number.values()]
    return min(utilities) > max(utilities) / 2.0


def _finish(ax: Axes, flown: list[int], trained: int) -> None:
    """Ticks at the numbers of UAVs that were flown, and a line where actors were trained."""
    ax.set_xscale("log", base=2)
    ax.set_xticks(flown, list(map(str, flown)))
    ax.set_xlabel("UAVs N")
    ax.axvline(trained, color="0.4", linestyle=":", linewidth=1.2, zorder=1)
    place: dict[str, Any] = {"xycoords": ax.get_xaxis_transform(), "textcoords": "offset points", "xytext": (0, 3)}
    ax.annotate(f"trained: N = {trained}", (trained, 1.0), ha="center", fontsize="small", **place)


def _spread_collisions(ax: Axes, collisions: pd.Series) -> None:
    """Some collide hundreds of times as often as others, and a UAV alone never does: logarithmic down to near 0."""
    some = collisions[collisions > 0.0]
    if len(some):
        linear_to = 10.0 ** np.ceil(np.log10(some.min()))
        ax.set_yscale("symlog", linthresh=linear_to)
        ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        ax.set_ylim(-0.08 * linear_to, 1.5 * max(some.max(), linear_to))


def _caption(results: Results, means: Means) -> str:
    game, scaling = results.recipe.game(), results.recipe.scaling
    grows = scaling is not None and scaling.constant_density
    counts = results.scaling.groupby("num_uavs")["episodes"].first()
    same = counts.nunique() == 1
    each = str(counts.iloc[0]) if same else ", ".join(f"{episodes} (N = {n})" for n, episodes in counts.items())
    area = (
        f" The airspace and its GBSs grow with N: {game.num_gbs} GBSs on {game.width_voxels} x {game.length_voxels} "
        f"voxels for {game.num_uavs} UAVs, and so on."
        if grows
        else ""
    )
    return (
        f"Players among N UAVs; learners were trained with N = {game.num_uavs} (dotted) and not again.{area} "
        f"Each N has {each} missions of its own, the same for all players and seeds, so "
        "from N to N the missions change too. Collisions: of a UAV in a mission; their axis is linear up to its second "
        f"tick{', and that of the utility is cut (//)' if _is_cut(means) else ''}. "
        "Means over seeds with 95 % bootstrap intervals over seeds, which with five seeds hold the true mean in "
        "about five of six cases."
    )
