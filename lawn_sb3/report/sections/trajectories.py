"""One test episode as every method flies it: choosing it, and drawing it from above."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lawn_sb3.experiment.evaluation import evaluation_missions
from lawn_sb3.game.radio import radio_map
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.style import colours, legend_below, panels, title_of, use_house_style
from lawn_sb3.results.results import Results
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]

HEADING = "One episode, every method"
UAV_COLOURS = ("#1B1BFF", "#661100", "#A81FA0", "#94A000", "#E7298A")
"""Colour-blind readers can tell the first four apart by lightness and hue, and none is a method's colour."""
UAV_LINES: tuple[Literal["-", "--", ":"], ...] = ("-", "--", ":")
"""Beyond five UAVs the colours repeat with another line; beyond fifteen both do."""
SITE_COLOUR, BORDER_COLOUR = "0.55", "0.45"
FIRST_SLOTS = 20
"""Longer paths are drawn up to here: a random walk would hide itself."""
MOST_GRID_LINES = 31
"""A finer voxel grid would be a grey sheet."""
OFFSET_VOXELS = 0.16
"""How far paths are drawn from the voxel centres, so that those in the same voxels stay apart."""


def section(results: Results) -> Section | None:
    """An episode as all methods fly it whose UAVs meet."""
    joint = results.without_bound()
    if not len(joint.paths):
        return None
    return Section(HEADING, {"trajectories": Picture(_figure(joint), caption(joint))})


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


def longest_episode(results: Results) -> Episode:
    """Choose the traced test episode with the most to fly.

    :param results: what the runs left, with paths of at least one run
    :return: of the first seed that most methods (all, as a rule) have paths of, the episode with the largest sum of
        T_min over its UAVs
    """
    methods_of = results.paths.groupby("seed")["method"].nunique()
    seed = int(methods_of.index[int(methods_of.argmax())])
    paths = results.paths[results.paths["seed"] == seed]
    rows = results.episodes[results.episodes["seed"] == seed]
    first = rows[(rows["method"] == paths["method"].iloc[0]) & rows["episode"].isin(paths["episode"])]
    number = int(first.groupby("episode")["min_slots"].sum().idxmax())
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


def offsets(scenario: Scenario) -> Floats:
    """How far the path of each UAV is moved aside.

    :param scenario: the game
    :return: metres along x and y [N, 2]: points of a small circle, no two of them in line with a side of the area
    """
    angle = 2.0 * np.pi * np.arange(scenario.num_uavs) / scenario.num_uavs + 0.3
    return OFFSET_VOXELS * scenario.voxel_size_m * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def cell_borders(scenario: Scenario) -> Floats:
    """Where neighbouring voxels of the lowest layer belong to different GBSs.

    :param scenario: the game
    :return: line segments in metres [B, 2, 2]
    """
    cell, size = radio_map(scenario).cell[:, :, 0], scenario.voxel_size_m
    segments = [[(x + 1, y), (x + 1, y + 1)] for x, y in np.argwhere(cell[1:] != cell[:-1])]
    segments += [[(x, y + 1), (x + 1, y + 1)] for x, y in np.argwhere(cell[:, 1:] != cell[:, :-1])]
    return size * np.array(segments, dtype=np.float64).reshape(-1, 2, 2)


def uav_look(uav: int) -> tuple[str, Literal["-", "--", ":"]]:
    """Colour and line of a UAV's path."""
    return UAV_COLOURS[uav % len(UAV_COLOURS)], UAV_LINES[uav // len(UAV_COLOURS) % len(UAV_LINES)]


def dot_sizes(scenario: Scenario, altitude_m: Floats) -> Floats:
    """Areas of the dots that mark slots, in square points: the higher, the larger."""
    span = scenario.max_altitude_m - scenario.min_altitude_m
    return np.asarray(5.0 + 25.0 * (altitude_m - scenario.min_altitude_m) / span)


def heading(results: Results, flight: Flight) -> str:
    """What stands above a panel: the method, its makespan and mean utility, and how much of it is drawn."""
    slots = int(flight.rows["makespan_slots"].iloc[0])
    text = f"{slots} slots, U {flight.rows['utility_mbps'].mean():.1f} Mbps"
    if slots > FIRST_SLOTS:
        text = f"{FIRST_SLOTS} of {text}"
    return f"{results.recipe.methods[flight.method].label}\n{text}"


def _figure(results: Results) -> Figure:
    """A panel for each method, seen from above."""
    use_house_style()
    game, episode = results.recipe.game(), longest_episode(results)
    figure, palette = Figure(layout="compressed"), colours(results.recipe.methods)
    axes = panels(figure, len(episode.flights), 2.4, 2.75, "x (m)", "y (m)")
    for ax, flight in zip(axes, episode.flights, strict=True):
        _draw_area(ax, game)
        for i, path in enumerate(flight.paths):
            _draw_path(ax, game, i, path, episode.destinations[i])
        title_of(ax, heading(results, flight), palette[flight.method])
    legend_below(figure, legend_handles(game, by_altitude=True), 1.9)
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


def legend_handles(scenario: Scenario, by_altitude: bool) -> list[Line2D]:
    """What the signs of the figures mean.

    :param scenario: the game
    :param by_altitude: whether the size of a dot tells the altitude
    :return: handles for a legend: UAVs, origin, destination, dots, GBS and cell border
    """
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


def caption(results: Results) -> str:
    """What the figures of trajectories show."""
    episode = longest_episode(results)
    return (
        f"Test episode {episode.number} of seed {episode.seed} as every method flies it: of the traced ones that with "
        "the most to fly (largest sum of T_min). A dot is the end of a slot; from above it is larger the higher the "
        f"UAV flies. Paths are moved aside by {OFFSET_VOXELS:g} voxels, so that those in the same voxels stay apart, "
        f"and of long ones the first {FIRST_SLOTS} slots are drawn. Above each panel: slots until the last UAV is "
        "done, and mean utility U. Seen in space, a flat airspace is stretched in height."
    )
