"""Who leads in each changed game, and by how much."""

from collections.abc import Mapping
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lawn_sb3.report.changed_game import game_label
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.style import colours, error_bars, use_house_style
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import mean_interval

LEADS_IN = ("reward", "utility_mbps")
NAME_WIDTH = 44
"""Characters of a line of the name of a changed game."""
CAPTION = (
    "Mean over seeds minus the mean of all learning methods in the same changed game, with 95 % bootstrap intervals "
    "over seeds; rows are changed games, with what is changed. Random and shortest path are in the tables."
)


def section(games: Mapping[str, Results]) -> Section:
    """The leads in all changed games."""
    return Section("Leads", {"leads": Picture(_figure(games), CAPTION)})


def _figure(games: Mapping[str, Results]) -> Figure:
    """Each method's lead over the mean of the learning methods, by changed game."""
    use_house_style()
    figure = Figure(figsize=(10, 1.2 + 0.55 * len(games)), layout="constrained")
    axes = figure.subplots(1, len(LEADS_IN), sharey=True)
    base = next(iter(games.values())).recipe
    methods, usual = base.methods, base.game()
    names = [fill(game_label(name, own.recipe.game(), usual), NAME_WIDTH) for name, own in games.items()]
    learners = [key for key, method in methods.items() if method.algo is not None] or list(methods)
    palette = colours(methods)
    for ax, quantity in zip(axes, LEADS_IN, strict=True):
        for row, results in enumerate(games.values()):
            present = [key for key in learners if key in results.methods]
            if not present:
                continue
            level = np.mean([results.scores(key, quantity).mean() for key in present])
            for place, key in enumerate(learners):
                if key in results.methods:
                    own = mean_interval(results.scores(key, quantity).mean(axis=1) - level)
                    y = row + 0.6 * ((place + 0.5) / len(learners) - 0.5)
                    look: dict[str, Any] = {"markersize": 4, "color": palette[key], "capsize": 2, "linewidth": 1.2}
                    ax.errorbar(own.value, y, xerr=error_bars(own), fmt="o", **look)
        ax.axvline(0.0, color="0.5", linewidth=0.8, zorder=0)
        ax.set_xlabel(f"{QUANTITIES[quantity].axis_label},\nlead over the learners' mean")
        ax.set_yticks(range(len(games)), names)
        ax.set_ylim(len(games) - 0.5, -0.5)
        ax.grid(visible=False, axis="y")
        for row in range(1, len(games), 2):
            ax.axhspan(row - 0.5, row + 0.5, color="0.95", zorder=-1)
    for key in learners:
        axes[0].plot([], [], "o", color=palette[key], label=methods[key].label)
    figure.legend(loc="outside lower center", ncols=len(learners), frameon=False)
    return figure
