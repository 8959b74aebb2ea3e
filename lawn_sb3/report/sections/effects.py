"""What each part of a method is worth: ablations held against their defaults, in a table and at a glance."""

from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.style import colours, error_bars, use_house_style
from lawn_sb3.report.table import Row, interval_columns, row_of, sample_text, table_of
from lawn_sb3.results.learning import THRESHOLD, median_crossing
from lawn_sb3.results.pairing import EFFECTS, SEARCHED, Marks, Pair, left_out, marks_of, pair_up
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import LEVEL, UNKNOWN, Interval, mean_interval

IMPROVED = ("reward", "utility_mbps")
"""Quantities in which two seeds are rarely level on a test episode, so that they can be held against each other."""
ROW_INCHES = 0.28
JUMP = 5.0
"""An effect this many times as large as the next smaller one may go beyond the axis."""
MOST_BEYOND = 0.25
"""Share of the effects that may."""
LEAST_SIDE = 0.2
"""Share of an axis on either side of 0, at least."""

AT_A_GLANCE = (
    "Ablation minus default, in the order of the table. Large points: mean over seeds with Student's t interval "
    "(95 %) over the differences seed by seed; small ones: the seeds. Filled: passes Holm's correction over all "
    "{tested} effects, as {sure} do, or all seeds agree; an open point whose interval leaves 0 out may be chance, as "
    "there are so many. In the grey rows the defaults' own figures. Where an effect is so large that it would hide the "
    "others it lies beyond the axis, and its figures are written at the edge, with ‡ for filled and † for an interval "
    "that leaves 0 out, as in the table."
)
"""What the figure shows, to be filled with how many effects there are."""


def section(results: Results) -> Section:
    """Every ablation minus its default, seed by seed; those without an effect are named among the problems.

    :param results: what the runs left
    :return: a table with one row for each default, with its own figures, and below it one for each of its ablations,
        from the best effect on J to the worst; and a figure of the same rows
    """
    groups = pair_up(results)
    marks = marks_of(groups)
    rows: list[Row] = []
    for baseline, pairs in groups.items():
        rows += [_default_row(results, baseline), *(_effect_row(results, pair, marks) for pair in pairs)]
    table = table_of(rows, _caption(marks))
    text = AT_A_GLANCE.format(sure=marks.num_sure, tested=marks.num_tested)
    figure = Picture(_figure(results, groups, marks), text) if groups else None
    parts = {"effects": table, "effects_forest": figure}
    return Section("What each part is worth", parts, problems=tuple(left_out(results)))


def _default_row(results: Results, key: str) -> Row:
    """A default's own figures."""
    by_seed = results.by_seed()
    own = by_seed[by_seed["method"] == key]
    figures = {name: mean_interval(own[name]) for name in EFFECTS}
    return _row(results, key, results.seeds(key), figures, dict.fromkeys(IMPROVED, UNKNOWN), {})


def _effect_row(results: Results, pair: Pair, marks: Marks) -> Row:
    """An ablation's differences to its default."""
    figures = {name: pair.effect(name) for name in EFFECTS}
    improved = {name: pair.improvement(results, name) for name in IMPROVED}
    p_values = {name: pair.p_value(name) for name in EFFECTS}
    signs = {name: marks.mark(figures[name], p_values[name]) for name in EFFECTS}
    row = _row(results, pair.key, pair.seeds, figures, improved, signs, pair.baseline)
    row.numbers |= {f"{name}_p": p_value for name, p_value in p_values.items()}
    row.numbers |= {f"{name}_sure": marks.is_sure(figures[name], p_values[name]) for name in EFFECTS}
    return row


def _row(
    results: Results,
    key: str,
    seeds: list[int],
    figures: dict[str, Interval],
    improved: dict[str, Interval],
    signs: dict[str, str],
    baseline: str | None = None,
) -> Row:
    """A row; one without a baseline is a default's."""
    episodes, crossing = results.recipe.evaluation.episodes, median_crossing(results, key, seeds)
    row = row_of(
        results, key, baseline=baseline or key, is_default=baseline is None, seeds=len(seeds), episodes=episodes
    )
    if baseline is None:
        row.cells["Method"] += " (default)"
    for name, found in figures.items():
        quantity = QUANTITIES[name]
        row.add(name, quantity.difference_heading, found, quantity.fine_decimals, after=signs.get(name, ""))
        if name in improved:
            row.cells[f"P(better {quantity.symbol})"] = improved[name].text(2)
    row.numbers |= interval_columns({f"{name}_improvement": found for name, found in improved.items()})
    row.numbers["crossing_env_steps"] = crossing.if_reached
    row.cells |= {f"Env steps to {THRESHOLD:.0f} %": crossing.text(), "n": sample_text(len(seeds), episodes)}
    return row


def _caption(marks: Marks) -> str:
    """What the table shows, and how many of its effects are sure."""
    return (
        "Ablations under their defaults, from the best effect on J̄ to the worst. Rows of defaults are their own "
        "figures [95 % bootstrap interval over seeds]. Δ: ablation minus default, seed by seed on the same test "
        "missions, mean over seeds [95 % Student's t interval over these differences, which takes them for normal and "
        "may reach beyond what is possible, such as 100 % success]. †: the interval leaves 0 out, which by itself says "
        f"little among so many: of the {marks.num_tested} effects in which seeds differ {marks.num_marked} do, and "
        f"about {LEVEL * marks.num_tested:.0f} would if there were none. ‡: it also passes Holm's correction over "
        f"these {marks.num_tested} at 5 %, as {marks.num_sure} do, or all seeds agree. Conclusions rest on ‡ alone. "
        "T̄: makespan, less is better. U: mean utility. Collisions: of a UAV in a mission, fewer are better. "
        "P(better): probability that a seed of the ablation does better than one of the default on the same test "
        "episode, ties counted half, so that 0.5 is no difference [95 % bootstrap interval over seeds, which with five "
        "seeds holds the true value in about five of six cases; not counted among the marks]. J̄ counts all terms of "
        "the reward, also where training was not given one. Env steps: until the first greedy evaluation with "
        f"{THRESHOLD:.0f} % success, median of the seeds. n: seeds × test episodes. {SEARCHED}"
    )


class Span(NamedTuple):
    """What an axis shows."""

    low: float
    high: float

    def holds(self, values: NDArray[np.float64]) -> bool:
        """Whether all of these lie on the axis."""
        return bool(values.min() >= self.low and values.max() <= self.high)


def _figure(results: Results, groups: dict[str, list[Pair]], marks: Marks) -> Figure:
    """A panel for each quantity: one row for each ablation, under its default, in the order of the table."""
    use_house_style()
    rows: list[str | Pair] = []
    for baseline, pairs in groups.items():
        rows += [baseline, *pairs]
    figure = Figure(figsize=(12, 1.1 + ROW_INCHES * len(rows)), layout="constrained")
    axes = figure.subplots(1, len(EFFECTS), sharey=True)
    palette, levels = colours(groups), results.by_seed().groupby("method")[[*EFFECTS]].mean()
    for ax, name in zip(axes, EFFECTS, strict=True):
        _draw_panel(ax, name, rows, levels[name], palette, marks)
    labels = [results.recipe.methods[row if isinstance(row, str) else row.key].label for row in rows]
    axes[0].set_yticks(range(len(rows)), labels)
    for text, row in zip(axes[0].get_yticklabels(), rows, strict=True):
        if isinstance(row, str):
            text.set(color=palette[row], fontweight="bold")
    axes[0].set_ylim(len(rows) - 0.5, -0.5)
    return figure


def _draw_panel(
    ax: Axes, name: str, rows: list[str | Pair], levels: pd.Series, palette: dict[str, str], marks: Marks
) -> None:
    """One quantity."""
    quantity = QUANTITIES[name]
    span = visible_span([_extent(row, name) for row in rows if isinstance(row, Pair)])
    ax.set_xlim(span)
    ax.axvline(0.0, color="0.4", linewidth=0.9, zorder=1)
    for y, row in enumerate(rows):
        if isinstance(row, Pair):
            _draw_effect(ax, row, name, y, palette[row.baseline], span, marks)
        else:
            ax.axhspan(y - 0.5, y + 0.5, color="0.93", zorder=1.5)
            text = f"{levels[row]:.{quantity.fine_decimals}f}{quantity.level_unit}"
            ax.text(0.5, y, text, transform=ax.get_yaxis_transform(), ha="center", va="center", fontsize="small")
    ax.set_title(quantity.difference_label)
    ax.set_xlabel("better →" if quantity.more_is_better else "← better")
    ax.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    ax.grid(visible=False, axis="y")


def visible_span(extents: list[NDArray[np.float64]]) -> Span:
    """How far an axis reaches, so that a few huge effects do not hide the others.

    :param extents: for each effect all numbers that are drawn
    :return: room for all effects, or for all but the at most ``MOST_BEYOND`` of them that lie above the widest gap, if
        that gap is at least ``JUMP`` times wide
    """
    reaches = [float(np.abs(extent).max()) for extent in extents]
    ordered = np.sort([reach for reach in reaches if reach > 0.0])
    limit = np.inf
    may_go = int(MOST_BEYOND * len(reaches))
    if len(ordered) > 1 and may_go:
        first = max(len(ordered) - 1 - may_go, 0)
        jumps = ordered[first + 1 :] / ordered[first:-1]
        if jumps.max() >= JUMP:
            limit = ordered[first + int(jumps.argmax())]
    shown = [extent for extent, reach in zip(extents, reaches, strict=True) if reach <= limit]
    low = min(0.0, *(float(extent.min()) for extent in shown))
    high = max(0.0, *(float(extent.max()) for extent in shown))
    side = LEAST_SIDE * max(high - low, 1e-9) / (1.0 - LEAST_SIDE)
    low, high = min(low, -side), max(high, side)
    margin = 0.06 * (high - low)
    return Span(low - margin, high + margin)


def _extent(pair: Pair, name: str) -> NDArray[np.float64]:
    """All numbers that are drawn of an effect."""
    values: NDArray[np.float64] = np.array([*pair.effect(name), *pair.differences(name)])
    return np.asarray(values[~np.isnan(values)])


def _draw_effect(ax: Axes, pair: Pair, name: str, y: int, colour: str, span: Span, marks: Marks) -> None:
    """Point, interval and seeds; where they lie beyond the axis, their figures."""
    effect = pair.effect(name)
    fill = colour if marks.is_sure(effect, pair.p_value(name)) else "white"
    seeds = pair.differences(name)
    ax.plot(seeds, np.full(len(seeds), y + 0.27), "o", markersize=3, color=colour, alpha=0.4, markeredgewidth=0)
    look: dict[str, Any] = {"color": colour, "markerfacecolor": fill, "capsize": 2.5, "linewidth": 1.4, "zorder": 3}
    ax.errorbar(effect.value, y, xerr=error_bars(effect), fmt="o", markersize=5, **look)
    if not span.holds(_extent(pair, name)):
        text = effect.text(QUANTITIES[name].fine_decimals) + marks.mark(effect, pair.p_value(name))
        _write_at_edge(ax, text, y, left=effect.value < 0.0, colour=colour)


def _write_at_edge(ax: Axes, text: str, y: int, *, left: bool, colour: str) -> None:
    """An arrow over the edge of the panel, and figures beside it."""
    edge, inside, align = (0.03, 0.07, "left") if left else (0.97, 0.93, "right")
    place = ax.get_yaxis_transform()
    ax.plot(edge, y, "<" if left else ">", color=colour, markersize=5, transform=place, zorder=5)
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
    ax.text(inside, y, text, transform=place, ha=align, va="center", fontsize="x-small", bbox=box, zorder=4)
