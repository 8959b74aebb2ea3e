"""The effects of all ablations at a glance: a point an ablation, its interval, and the seeds behind it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.sections.effects import HEADING
from lawn_sb3.report.style import colours, error_bars, use_house_style
from lawn_sb3.results.pairing import EFFECTS, Pair, pair_up, significant
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results

ROW_INCHES = 0.28
JUMP = 5.0
"""An effect this many times as large as the next smaller one may go beyond the axis."""
MOST_BEYOND = 0.25
"""Share of the effects that may."""
LEAST_SIDE = 0.2
"""Share of an axis on either side of 0, at least."""

CAPTION = (
    "Ablation minus default, in the order of the table. Large points: mean over seeds with Student's t interval "
    "(95 %) over the differences seed by seed, filled where it leaves 0 out; small ones: the seeds. In the grey rows "
    "the defaults' own figures. Where an effect is so large that it would hide the others it lies beyond the axis, and "
    "its figures are written at the edge. The intervals are not corrected for their number."
)


def section(results: Results) -> Section | None:
    """The effects at a glance."""
    return Section(HEADING, {"effects_forest": Picture(_figure(results), CAPTION)}) if pair_up(results) else None


class Span(NamedTuple):
    """What an axis shows."""

    low: float
    high: float

    def holds(self, values: NDArray[np.float64]) -> bool:
        """Whether all of these lie on the axis."""
        return bool(values.min() >= self.low and values.max() <= self.high)


def _figure(results: Results) -> Figure:
    """A panel for each quantity: one row for each ablation, under its default, in the order of the table."""
    use_house_style()
    groups = pair_up(results)
    rows: list[str | Pair] = []
    for baseline, pairs in groups.items():
        rows += [baseline, *pairs]
    figure = Figure(figsize=(12, 1.1 + ROW_INCHES * len(rows)), layout="constrained")
    axes = figure.subplots(1, len(EFFECTS), sharey=True)
    palette, levels = colours(groups), results.by_seed().groupby("method")[[*EFFECTS]].mean()
    for ax, name in zip(axes, EFFECTS, strict=True):
        _draw_panel(ax, name, rows, levels[name], palette)
    labels = [results.recipe.methods[row if isinstance(row, str) else row.key].label for row in rows]
    axes[0].set_yticks(range(len(rows)), labels)
    for text, row in zip(axes[0].get_yticklabels(), rows, strict=True):
        if isinstance(row, str):
            text.set(color=palette[row], fontweight="bold")
    axes[0].set_ylim(len(rows) - 0.5, -0.5)
    return figure


def _draw_panel(ax: Axes, name: str, rows: list[str | Pair], levels: pd.Series, palette: dict[str, str]) -> None:
    """One quantity."""
    quantity = QUANTITIES[name]
    span = visible_span([_extent(row, name) for row in rows if isinstance(row, Pair)])
    ax.set_xlim(span)
    ax.axvline(0.0, color="0.4", linewidth=0.9, zorder=1)
    for y, row in enumerate(rows):
        if isinstance(row, Pair):
            _draw_effect(ax, row, name, y, palette[row.baseline], span)
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


def _draw_effect(ax: Axes, pair: Pair, name: str, y: int, colour: str, span: Span) -> None:
    """Point, interval and seeds; where they lie beyond the axis, their figures."""
    effect = pair.effect(name)
    fill = colour if significant(effect) else "white"
    seeds = pair.differences(name)
    ax.plot(seeds, np.full(len(seeds), y + 0.27), "o", markersize=3, color=colour, alpha=0.4, markeredgewidth=0)
    look: dict[str, Any] = {"color": colour, "markerfacecolor": fill, "capsize": 2.5, "linewidth": 1.4, "zorder": 3}
    ax.errorbar(effect.value, y, xerr=error_bars(effect), fmt="o", markersize=5, **look)
    if not span.holds(_extent(pair, name)):
        _write_at_edge(ax, effect.text(QUANTITIES[name].fine_decimals), y, left=effect.value < 0.0, colour=colour)


def _write_at_edge(ax: Axes, text: str, y: int, *, left: bool, colour: str) -> None:
    """An arrow over the edge of the panel, and figures beside it."""
    edge, inside, align = (0.03, 0.07, "left") if left else (0.97, 0.93, "right")
    place = ax.get_yaxis_transform()
    ax.plot(edge, y, "<" if left else ">", color=colour, markersize=5, transform=place, zorder=5)
    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
    ax.text(inside, y, text, transform=place, ha=align, va="center", fontsize="x-small", bbox=box, zorder=4)
