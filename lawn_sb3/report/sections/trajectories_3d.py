"""One test episode as every method flies it, drawn in space."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]

from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.sections.trajectories import (
    BORDER_COLOUR,
    FIRST_SLOTS,
    HEADING,
    SITE_COLOUR,
    Floats,
    caption,
    cell_borders,
    heading,
    legend_handles,
    longest_episode,
    offsets,
    uav_look,
)
from lawn_sb3.report.style import colours, grid_shape, legend_below, title_of, use_house_style
from lawn_sb3.results.results import Results
from lawn_sb3.scenario import Scenario

FLATTEST = 0.5
"""An airspace flatter than this is drawn stretched to it: height over the longer side."""


def section(results: Results) -> Section | None:
    """The same episode in space."""
    joint = results.without_bound()
    if not len(joint.paths):
        return None
    return Section(HEADING, {"trajectories_3d": Picture(_figure(joint), caption(joint))})


def _figure(results: Results) -> Figure:
    """A panel for each method, seen in space."""
    use_house_style()
    game, episode = results.recipe.game(), longest_episode(results)
    palette = colours(results.recipe.methods)
    rows, columns = grid_shape(len(episode.flights))
    # The layout does not see the labels of a 3D panel: leave them room.
    layout = ConstrainedLayoutEngine(wspace=0.08, rect=(0.0, 0.0, 0.97, 1.0))
    figure = Figure(figsize=(0.6 + 2.6 * columns, 0.2 + 2.5 * rows), layout=layout)
    for k, flight in enumerate(episode.flights):
        ax = figure.add_subplot(rows, columns, k + 1, projection="3d")
        _draw_space(ax, game)
        for i, path in enumerate(flight.paths):
            _draw_path(ax, game, i, path, episode.destinations[i])
        title_of(ax, heading(results, flight), palette[flight.method], height=0.9)
    legend_below(figure, legend_handles(game, by_altitude=False), 1.6)
    return figure


def _draw_space(ax: Axes3D, game: Scenario) -> None:
    width, length, height = (float(edge) * game.voxel_size_m for edge in game.grid)
    low, high = game.min_altitude_m, game.max_altitude_m
    for segment in cell_borders(game):
        ax.plot(*segment.T, [low, low], color=BORDER_COLOUR, linestyle="--", linewidth=0.8)
    ax.plot(*game.gbs_positions.T, "^", color=SITE_COLOUR, markersize=6)
    ax.set(xlim=(0, width), ylim=(0, length), zlim=(low, high), xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
    longer = max(width, length)
    ax.set_box_aspect((width, length, max(height, FLATTEST * longer)), zoom=0.98)
    ax.patch.set_visible(False)
    ax.view_init(elev=32, azim=-60)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        first = "lower" if axis is ax.yaxis else None  # it would touch the last number of the x-axis
        axis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10], prune=first))
        axis.labelpad = -4
    ax.tick_params(pad=-2, labelsize="small")


def _draw_path(ax: Axes3D, game: Scenario, uav: int, path: Floats, destination: Floats) -> None:
    (colour, line), aside = uav_look(uav), np.append(offsets(game)[uav], 0.0)
    cut = len(path) - 1 > FIRST_SLOTS
    drawn = path[: FIRST_SLOTS + 1] + aside
    if not cut:
        for x, y, z in drawn[1:]:
            ax.plot([x, x], [y, y], [game.min_altitude_m, z], color=colour, linewidth=0.5, alpha=0.4)
    ax.plot(*drawn.T, line, color=colour, linewidth=0.6 if cut else 1.5, alpha=0.8)
    ax.plot(*drawn[1:].T, "o", color=colour, markersize=1.5 if cut else 3.5, alpha=0.8)
    ax.plot(*drawn[:1].T, "o", color=colour, markerfacecolor="white", markersize=6, markeredgewidth=1.4)
    ax.plot(*(destination + aside)[:, None], "*", color=colour, markersize=9)
