"""Greedy success of each ablation during training, its default behind it."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.sections.learning_effects import HEADING
from lawn_sb3.report.style import colours, in_thousands, legend_below, panels, title_of, use_house_style
from lawn_sb3.results.learning import THRESHOLD, greedy_curves, has_curves
from lawn_sb3.results.pairing import pair_up
from lawn_sb3.results.results import Results

DEFAULT_COLOUR = "0.45"
CAPTION = (
    "Greedy success during training on missions apart from the test's: each ablation (in colour) and its default "
    "(grey, dashed), mean over seeds; bands: range over seeds, from the worst to the best. Dotted: "
    f"{THRESHOLD:.0f} %. In the order of the table of effects."
)


def section(results: Results) -> Section | None:
    """All ablations that were watched together with their defaults."""
    return Section(HEADING, {"learning_curves": Picture(_figure(results), CAPTION)}) if has_curves(results) else None


def _figure(results: Results) -> Figure:
    """A panel for each ablation; lines are means over seeds, bands their range."""
    use_house_style()
    groups = pair_up(results)
    pairs = [pair for own in groups.values() for pair in own]
    palette = colours(groups)
    figure = Figure(layout="constrained")
    axes = panels(figure, len(pairs), 2.25, 1.6, "env steps", "success (%)")
    for ax, pair in zip(axes, pairs, strict=True):
        colour = palette[pair.baseline]
        ax.axhline(THRESHOLD, color="0.5", linestyle=":", linewidth=0.8)
        _draw(ax, greedy_curves(results, pair.baseline, pair.seeds), DEFAULT_COLOUR, "--")
        _draw(ax, greedy_curves(results, pair.key, pair.seeds), colour, "-")
        title_of(ax, results.recipe.methods[pair.key].label, colour)
        ax.set_ylim(-2, 102)
        in_thousands(ax)
    handles = [
        Line2D([], [], color=palette[key], label=f"ablation of {results.recipe.methods[key].label}") for key in groups
    ]
    legend_below(figure, [*handles, Line2D([], [], color=DEFAULT_COLOUR, linestyle="--", label="its default")], 2.3)
    return figure


def _draw(ax: Axes, curves: dict[int, pd.Series], colour: str, style: str) -> None:
    """Mean and range over seeds, where all of them were watched."""
    if curves:
        together = pd.DataFrame(curves).dropna()  # one column a seed
        steps = together.index.to_numpy()
        ax.fill_between(steps, together.min(axis=1), together.max(axis=1), color=colour, alpha=0.25, linewidth=0)
        ax.plot(steps, together.mean(axis=1), color=colour, linestyle=style, linewidth=1.3)
