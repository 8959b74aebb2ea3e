"""One test episode as every method flies it, drawn from above and in space."""

from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.lines import Line2D
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]
from numpy.typing import NDArray

from lawn_sb3.experiment.evaluation import evaluation_missions
from lawn_sb3.game.radio import cell_borders
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.space import (
    BORDER_COLOUR,
    OFFSET_VOXELS,
    SITE_COLOUR,
    UAV_COLOURS,
    UAV_LINES,
    draw_space,
    offsets,
    uav_look,
)
from lawn_sb3.report.style import colours, grid_shape, legend_below, panels, title_of, use_house_style
from lawn_sb3.results.results import Results
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]

APART_MBPS = 0.5
"""Methods whose mean utilities are nearer have no order that an episode could contradict."""
TURNED = 0.1
"""Share of the pairs of methods that may stand the other way round in the episode that is shown."""
FIRST_SLOTS = 20
"""Longer paths are drawn up to here: a random walk would hide itself."""
MOST_GRID_LINES = 31
"""A finer voxel grid would be a grey sheet."""


def section(results: Results) -> Section | None:
    """A typical episode as all methods fly it whose UAVs meet; none of swarms, whose paths nobody could tell apart."""
    joint = results.without_bound()
    if not len(joint.paths) or results.recipe.game().num_uavs > len(UAV_COLOURS) * len(UAV_LINES):
        return None
    episode = typical_episode(joint)
    caption = _caption(episode)
    figures = {
        "trajectories": Picture(_from_above(joint, episode), caption),
        "trajectories_3d": Picture(_in_space(joint, episode), caption),
    }
    return Section("One episode, every method", figures)


class Flight(NamedTuple):
    """One test episode as one method flew it."""

    method: str
    """Its key in the recipe."""
    paths: list[Floats]
    """Positions of each UAV in metres, from its origin on [T_i + 1, 3]."""
    rows: pd.DataFrame
    """The evaluation's rows of the episode."""


class Episode(NamedTuple):
    """One test episode as all methods flew it."""

    seed: int
    number: int
    destinations: Floats
    """In metres [N, 3]."""
    flights: list[Flight]


def typical_episode(results: Results) -> Episode:
    """The traced test episode that shows the methods most as they are over all episodes and seeds.

    Left out are episodes in which more than ``TURNED`` of the pairs of methods stand the other way round by mean
    utility than there, of those pairs that are more than ``APART_MBPS`` apart there; or all but those with the fewest.
    Of the others it is the one with the smallest sum of distances to the mean utilities there. Those are looked at that
    most methods (all, as a rule) have paths of.
    """
    where = ["seed", "episode"]
    traced = results.paths.groupby(where)["method"].nunique()
    flown = results.episodes.groupby([*where, "method"])["utility_mbps"].mean().unstack("method")
    flown = flown.loc[traced[traced == traced.max()].sort_index().index, list(results.methods_in(results.paths))]
    mean = mean_utilities(results)[flown.columns].to_numpy()
    known = flown.fillna(dict(zip(flown.columns, mean, strict=True))).to_numpy()  # [E, methods]
    apart, own = mean[:, None] - mean, known[:, :, None] - known[:, None, :]
    counted = np.abs(apart) > APART_MBPS
    turned = ((own * apart < 0.0) & counted).sum(axis=(1, 2))
    like = turned <= max(TURNED * counted.sum(), turned.min())
    off = np.where(like, np.abs(known - mean).sum(axis=1), np.inf)
    seed, number = map(int, flown.index[int(off.argmin())])
    paths = results.paths[results.paths["seed"] == seed]
    rows = results.episodes[results.episodes["seed"] == seed]
    game = results.recipe.game()
    flights = []
    for key in results.methods_in(paths):
        own = paths[(paths["method"] == key) & (paths["episode"] == number)].sort_values(["uav", "slot"])
        voxels = [uav[list("xyz")].to_numpy() for _, uav in own.groupby("uav")]
        flown = rows[(rows["method"] == key) & (rows["episode"] == number)]
        flights.append(Flight(key, [game.voxel_centre(path) for path in voxels], flown))
    chosen = results.recipe.evaluation
    destinations = evaluation_missions(game, chosen.episodes, chosen.seed).destinations[number]
    return Episode(seed, number, game.voxel_centre(destinations), flights)


def mean_utilities(results: Results) -> pd.Series:
    """The mean utility of each method in Mbps, over all episodes and seeds."""
    return results.episodes.groupby("method")["utility_mbps"].mean()


def dot_sizes(scenario: Scenario, altitude_m: Floats) -> Floats:
    """Areas of the dots that mark slots, in square points: the higher, the larger."""
    span = scenario.max_altitude_m - scenario.min_altitude_m
    return np.asarray(5.0 + 25.0 * (altitude_m - scenario.min_altitude_m) / span)


def heading(results: Results, flight: Flight) -> str:
    """What stands above a panel: the method, its makespan and mean utility, here and of all, and how much is drawn."""
    slots = int(flight.rows["makespan_slots"].iloc[0])
    mean = mean_utilities(results)[flight.method]
    text = f"{slots} slots, U {flight.rows['utility_mbps'].mean():.1f} ({mean:.1f}) Mbps"
    if slots > FIRST_SLOTS:
        text = f"{FIRST_SLOTS} of {text}"
    return f"{results.recipe.methods[flight.method].label}\n{text}"


def _from_above(results: Results, episode: Episode) -> Figure:
    """A panel for each method, seen from above."""
    use_house_style()
    game = results.recipe.game()
    figure, palette = Figure(layout="compressed"), colours(results.recipe.methods)
    axes = panels(figure, len(episode.flights), 2.4, 2.75, "x (m)", "y (m)")
    for ax, flight in zip(axes, episode.flights, strict=True):
        _draw_area(ax, game)
        for i, path in enumerate(flight.paths):
            _draw_path(ax, game, i, path, episode.destinations[i])
        title_of(ax, heading(results, flight), palette[flight.method])
    legend_below(figure, _legend_handles(game, by_altitude=True), 1.9)
    return figure


def _draw_area(ax: Axes, game: Scenario) -> None:
    width, length = game.grid[0] * game.voxel_size_m, game.grid[1] * game.voxel_size_m
    ax.grid(visible=False)
    if max(game.grid[:2]) < MOST_GRID_LINES:
        for x in np.arange(1, game.grid[0]) * game.voxel_size_m:
            ax.axvline(x, color="0.93", linewidth=0.5, zorder=0)
        for y in np.arange(1, game.grid[1]) * game.voxel_size_m:
            ax.axhline(y, color="0.93", linewidth=0.5, zorder=0)
    ax.add_collection(LineCollection(list(cell_borders(game)), colors=BORDER_COLOUR, linestyles="--", linewidths=1.0))
    ax.plot(*game.gbs_positions[:, :2].T, "^", color=SITE_COLOUR, markersize=8, zorder=1)
    ax.set(xlim=(0, width), ylim=(0, length), aspect="equal")


def _draw_path(ax: Axes, game: Scenario, uav: int, path: Floats, destination: Floats) -> None:
    (colour, line), aside = uav_look(uav), offsets(game)[uav]
    cut = len(path) - 1 > FIRST_SLOTS
    drawn = path[: FIRST_SLOTS + 1]
    x, y = (drawn[:, :2] + aside).T
    ax.plot(x, y, line, color=colour, linewidth=0.6 if cut else 1.5, alpha=0.8, zorder=2)
    sizes = dot_sizes(game, drawn[1:, 2]) * (0.4 if cut else 1.0)
    ax.scatter(x[1:], y[1:], sizes, color=colour, linewidths=0, alpha=0.8, zorder=3)
    ax.plot(x[:1], y[:1], "o", color=colour, markerfacecolor="white", markersize=6, markeredgewidth=1.4, zorder=4)
    ax.plot(*(destination[:2] + aside)[:, None], "*", color=colour, markersize=10, markeredgecolor="white", zorder=5)


def _in_space(results: Results, episode: Episode) -> Figure:
    """A panel for each method, seen in space."""
    use_house_style()
    game, palette = results.recipe.game(), colours(results.recipe.methods)
    rows, columns = grid_shape(len(episode.flights))
    # The layout does not see the labels of a 3D panel: leave them room.
    layout = ConstrainedLayoutEngine(wspace=0.08, rect=(0.0, 0.0, 0.97, 1.0))
    figure = Figure(figsize=(0.6 + 2.6 * columns, 0.2 + 2.5 * rows), layout=layout)
    for k, flight in enumerate(episode.flights):
        ax = figure.add_subplot(rows, columns, k + 1, projection="3d")
        draw_space(ax, game)
        for i, path in enumerate(flight.paths):
            _draw_path_in_space(ax, game, i, path, episode.destinations[i])
        title_of(ax, heading(results, flight), palette[flight.method], height=0.9)
    legend_below(figure, _legend_handles(game, by_altitude=False), 1.6)
    return figure


def _draw_path_in_space(ax: Axes3D, game: Scenario, uav: int, path: Floats, destination: Floats) -> None:
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


def _legend_handles(scenario: Scenario, by_altitude: bool) -> list[Line2D]:
    """What the signs of a figure mean, for its legend; perhaps the size of a dot tells the altitude."""
    lowest, highest = (float(scenario.voxel_centre((0, 0, layer))[2]) for layer in (0, scenario.grid[2] - 1))
    looks = [uav_look(i) for i in range(min(scenario.num_uavs, len(UAV_COLOURS) * len(UAV_LINES)))]
    lines = [
        Line2D([], [], color=colour, linestyle=line, linewidth=2, label=f"UAV {i}")
        for i, (colour, line) in enumerate(looks)
    ]
    dots = [_mark("o", "end of a slot", 4)]
    if by_altitude:
        dots = [
            _mark("o", f"end of a slot, at {height:g} m", float(np.sqrt(dot_sizes(scenario, np.array(height)))))
            for height in sorted({lowest, highest})
        ]
    origin, destination = _mark("o", "origin", 6), _mark("*", "destination", 9)
    origin.set_markerfacecolor("white")
    gbs = _mark("^", "GBS", 8, SITE_COLOUR)
    border = Line2D([], [], color=BORDER_COLOUR, linestyle="--", linewidth=1, label="border of cells")
    return [*lines, origin, destination, *dots, gbs, border]


def _mark(marker: str, label: str, size: float, colour: str = "0.3") -> Line2D:
    return Line2D([], [], marker=marker, markersize=size, color=colour, linestyle="", label=label)


def _caption(episode: Episode) -> str:
    """What the figures of trajectories show."""
    return (
        f"Test episode {episode.number} of seed {episode.seed} as every method flies it: of the traced ones that with "
        "the methods' mean utilities U nearest to those over all episodes and seeds (smallest sum of distances), among "
        f"those in which at most {100 * TURNED:g} % of the pairs of methods, or else the fewest, stand the other way "
        f"round than there (pairs less than {APART_MBPS:g} Mbps apart there aside). A dot is the end of a slot; from "
        "above it is larger the higher the UAV flies. Paths are moved aside by "
        f"{OFFSET_VOXELS:g} voxels, so that those in the same voxels stay apart, and of long ones the first "
        f"{FIRST_SLOTS} slots are drawn. Above each panel: slots until the last UAV is done, and mean utility U, in "
        "parentheses that over all episodes and seeds. Seen in space, a flat airspace is stretched in height."
    )
