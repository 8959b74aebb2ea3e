"""Fig. 1: the system model of a scenario, drawn in space from its constants."""

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D, proj3d  # type: ignore[import-untyped]
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection  # type: ignore[import-untyped]
from numpy.typing import NDArray

from lawn_sb3.game.airspace import Missions, draw_missions
from lawn_sb3.game.radio import cell_borders, radio_map, rb_share
from lawn_sb3.report.style import use_house_style
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]

GROUND = ("#56B4E9", "#E69F00", "#009E73", "#CC79A7", "#F0E442", "#0072B2", "#D55E00")
"""Okabe and Ito's colours, which repeat after seven cells; borders tell equal neighbours apart."""
UAV_COLOURS = ("#1B1BFF", "#661100", "#A81FA0", "#6B7500", "#E7298A", "#00747A", "#333333", "#C75100")
HALO = [withStroke(linewidth=2.5, foreground="white")]
MOST_LINES = 31
"""A finer voxel grid is drawn every so many voxels that no more lines are needed."""
FLATTEST = 0.3
"""An airspace flatter than this is drawn stretched to it: height over the longer side."""
TRIED = 300
"""Missions of which the clearest are drawn."""
LABELS = np.array([[-0.55, -0.3], [0.0, -0.3], [0.4, -0.3]])
"""From a GBS to the ends and the middle of what is written below it, in inches."""
MOST_NAMED = 8
"""With more GBSs or UAVs labels would cover each other."""


def airspace_figure(scenario: Scenario, seed: int) -> Figure:
    """Draw a scenario and one mission of each UAV.

    :param scenario: the scenario
    :param seed: picks the missions: of many random ones those whose marks keep furthest apart in the picture
    :return: airspace and voxels, cells on the ground, GBSs with their RBs and how these are shared where the UAVs
        start, UAVs with origins and destinations
    """
    use_house_style()
    figure = Figure(figsize=(10, 6.4))
    ax = figure.add_axes((0.0, -0.2, 1.0, 1.5), projection="3d", computed_zorder=False)
    _draw_box(ax, scenario)
    missions = _clear_missions(ax, scenario, seed)
    _draw_ground(ax, scenario)
    _draw_voxel(ax, scenario)
    _draw_gbss(ax, scenario, missions)
    _draw_uavs(ax, scenario, missions)
    figure.legend(handles=_handles(scenario), loc="lower center", ncols=4, frameon=False, bbox_to_anchor=(0.5, 0.01))
    return figure


def airspace_caption(scenario: Scenario) -> str:
    """What the figure shows."""
    width, length, height = scenario.grid
    flat = scenario.max_altitude_m - scenario.min_altitude_m < FLATTEST * max(_size(scenario))
    stretched = " The airspace is stretched in height." if flat else ""
    edges = " x ".join(f"{count * scenario.voxel_size_m:g}" for count in scenario.grid)
    return (
        f"The system model, drawn from the scenario {scenario.title}: an airspace of {edges} m in {width} x {length} x "
        f"{height} voxels of {scenario.voxel_size_m:g} m, {scenario.num_gbs} GBSs, and {scenario.num_uavs} UAVs at the "
        "origins of one random mission each, with their destinations. Coloured areas of the ground: cells, the voxels "
        "of the lowest layer that a GBS is nearest to. Dotted lines join a UAV to its GBS; all UAVs of a cell share "
        "its resource blocks (RBs) equally, rounded down. White and grey lines: voxels; one is drawn whole. d: "
        f"destination.{stretched}"
    )


def _clear_missions(ax: Axes3D, scenario: Scenario, seed: int) -> Missions:
    """Of many missions those whose origins and destinations keep furthest apart in the picture, and from its labels."""
    drawn = draw_missions(scenario, TRIED, np.random.default_rng(seed))
    ax.apply_aspect()
    gbs = _projected(ax, scenario.gbs_positions)
    voxel = _projected(ax, scenario.voxel_centre(np.array([[0, scenario.grid[1] - 1, scenario.grid[2] - 1]])))
    taken = np.concatenate([gbs, *(gbs + place for place in LABELS), voxel])
    widest, chosen = -1.0, 0
    for game in range(TRIED):
        own = _projected(ax, np.concatenate([scenario.voxel_centre(voxels[game]) for voxels in drawn]))
        gaps = np.linalg.norm(own[:, None] - np.concatenate([own, taken]), axis=-1)
        gaps[np.arange(len(own)), np.arange(len(own))] = np.inf
        if gaps.min() > widest:
            widest, chosen = float(gaps.min()), game
    return Missions(*(voxels[chosen : chosen + 1] for voxels in drawn))


def _projected(ax: Axes3D, points: Floats) -> Floats:
    """Where points in space are in the picture, in inches [P, 2]."""
    x, y, _ = proj3d.proj_transform(*points.T, ax.get_proj())
    return np.asarray(ax.transData.transform(np.stack([x, y], axis=-1)) / ax.get_figure().dpi, dtype=np.float64)


def _size(scenario: Scenario) -> tuple[float, float]:
    return scenario.grid[0] * scenario.voxel_size_m, scenario.grid[1] * scenario.voxel_size_m


def _steps(count: int) -> NDArray[np.int64]:
    """Grid lines along an edge of so many voxels."""
    return np.arange(0, count + 1, -(-count // MOST_LINES))


def _draw_box(ax: Axes3D, scenario: Scenario) -> None:
    (width, length), low, high = _size(scenario), scenario.min_altitude_m, scenario.max_altitude_m
    ax.set(xlim=(0, width), ylim=(0, length), zlim=(low, high), xlabel="x (m)", ylabel="y (m)", zlabel="altitude z (m)")
    longer = max(width, length)
    ax.set_box_aspect((width, length, max(high - low, FLATTEST * longer)), zoom=0.78)
    ax.view_init(elev=26, azim=-62)
    ax.grid(visible=False)
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_pane_color((1.0, 1.0, 1.0, 0.0))
        axis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    size = scenario.voxel_size_m
    layers = low + size * _steps(scenario.grid[2])
    lines = [[(x, length, low), (x, length, high)] for x in size * _steps(scenario.grid[0])]  # the two walls behind
    lines += [[(0.0, y, low), (0.0, y, high)] for y in size * _steps(scenario.grid[1])]
    lines += [[(0.0, length, z), (width, length, z)] for z in layers]
    lines += [[(0.0, 0.0, z), (0.0, length, z)] for z in layers]
    ax.add_collection3d(Line3DCollection(lines, colors="0.85", linewidths=0.6, zorder=0))
    corners = [(width, 0.0), (width, length), (0.0, 0.0), (0.0, length)]
    edges = [[(x, y, low), (x, y, high)] for x, y in corners]
    edges += [[(0.0, y, high), (width, y, high)] for y in (0.0, length)]
    edges += [[(x, 0.0, high), (x, length, high)] for x in (0.0, width)]
    ax.add_collection3d(Line3DCollection(edges, colors="0.55", linewidths=0.9, zorder=0))


def _draw_ground(ax: Axes3D, scenario: Scenario) -> None:
    """The cells in colour, the lines of the voxel grid, and the cells' borders."""
    cell, size, low = radio_map(scenario).cell[:, :, 0], scenario.voxel_size_m, scenario.min_altitude_m
    for gbs in range(scenario.num_gbs):
        squares = [_square(x, y, size, low) for x, y in np.argwhere(cell == gbs)]
        if squares:
            colour = GROUND[gbs % len(GROUND)]
            ax.add_collection3d(Poly3DCollection(squares, facecolors=colour, alpha=0.3, linewidths=0, zorder=1))
    width, length = _size(scenario)
    lines = [[(x, 0.0, low), (x, length, low)] for x in size * _steps(scenario.grid[0])]
    lines += [[(0.0, y, low), (width, y, low)] for y in size * _steps(scenario.grid[1])]
    ax.add_collection3d(Line3DCollection(lines, colors="white", linewidths=0.7, zorder=2))
    borders = [[(*start, low), (*end, low)] for start, end in cell_borders(scenario)]
    if borders:
        ax.add_collection3d(Line3DCollection(borders, colors="0.35", linestyles="--", linewidths=1.1, zorder=3))


def _square(x: int, y: int, size: float, z: float) -> list[tuple[float, float, float]]:
    return [(size * (x + i), size * (y + j), z) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]


def _draw_voxel(ax: Axes3D, scenario: Scenario) -> None:
    """One voxel, in the corner at the back above, with its size."""
    size, high = scenario.voxel_size_m, scenario.max_altitude_m
    far = scenario.grid[1] * size
    corners = np.array([[i * size, far - j * size, high - k * size] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
    sides = [corners[face] for face in faces]
    ax.add_collection3d(Poly3DCollection(sides, facecolors="0.5", edgecolors="0.3", alpha=0.15, linewidths=1, zorder=4))
    text = f"one voxel: {size:g} x {size:g} x {size:g} m"
    ax.text(size, far, high + 0.3 * size, text, va="bottom", fontsize=9, path_effects=HALO, zorder=9)


def _draw_gbss(ax: Axes3D, scenario: Scenario, missions: Missions) -> None:
    """Each GBS, its RBs, and how many of them each UAV of its cell gets at the origins."""
    cell = radio_map(scenario).cell[tuple(missions.origins[0].T)]
    low, named = scenario.min_altitude_m, scenario.num_gbs <= MOST_NAMED
    for gbs, (x, y, z) in enumerate(scenario.gbs_positions):
        colour, load, rbs = GROUND[gbs % len(GROUND)], int((cell == gbs).sum()), int(scenario.num_rbs[gbs])
        foot = min(z, low)
        ax.plot([x, x], [y, y], [foot, z], color="0.3", linewidth=1.2, zorder=5)
        ax.plot([x], [y], [z], "^", color=colour, markeredgecolor="black", markersize=11, zorder=6)
        if named:
            share = f"\n{load} UAV{'' if load == 1 else 's'}: {rb_share(rbs, load)} RBs each" if load else "\nno UAV"
            place = {"ha": "center", "va": "top", "fontsize": 8.5, "path_effects": HALO, "zorder": 8}
            drop = 0.05 * max(_size(scenario))
            ax.text(x, y - drop, foot, f"GBS {gbs}, {rbs} RBs{share}", **place)
    for gbs, position in zip(cell, scenario.voxel_centre(missions.origins[0]), strict=True):
        link = np.stack([position, scenario.gbs_positions[gbs]])
        ax.plot(*link.T, ":", color="0.35", linewidth=1.2, zorder=5)


def _draw_uavs(ax: Axes3D, scenario: Scenario, missions: Missions) -> None:
    """Each UAV at its origin, and its destination; thin lines drop to the ground below both."""
    origins, destinations = (scenario.voxel_centre(voxels[0]) for voxels in missions)
    named = scenario.num_uavs <= MOST_NAMED
    for i, (origin, destination) in enumerate(zip(origins, destinations, strict=True)):
        colour = UAV_COLOURS[i % len(UAV_COLOURS)]
        for x, y, z in (origin, destination):
            ax.plot([x, x], [y, y], [scenario.min_altitude_m, z], color=colour, linewidth=0.7, alpha=0.6, zorder=5)
        ax.plot(*np.stack([origin, destination]).T, "--", color=colour, linewidth=1.4, zorder=6)
        ax.plot(*origin[:, None], "o", color=colour, markersize=9, markeredgecolor="white", zorder=7)
        ax.plot(*destination[:, None], "*", color=colour, markersize=14, markeredgecolor="white", zorder=7)
        if named:
            lift = 0.06 * (scenario.max_altitude_m - scenario.min_altitude_m)
            place = {"ha": "center", "va": "bottom", "fontsize": 9, "color": colour, "path_effects": HALO, "zorder": 9}
            ax.text(origin[0], origin[1], origin[2] + lift, f"UAV {i}", **place)
            ax.text(destination[0], destination[1], destination[2] + lift, f"d$_{{{i}}}$", **place)


def _handles(scenario: Scenario) -> list[Line2D | Patch]:
    """What the signs mean."""
    marks = [("o", "UAV at its origin", 8), ("*", "its destination", 12), ("^", "GBS", 9)]
    shown: list[Line2D | Patch] = [
        Line2D([], [], marker=marker, color="0.35", markersize=size, linestyle="", label=label)
        for marker, label, size in marks
    ]
    return [
        *shown,
        Line2D([], [], color="0.35", linestyle="--", linewidth=1.4, label="straight way"),
        Line2D([], [], color="0.35", linestyle=":", linewidth=1.2, label="link to the nearest GBS"),
        Patch(facecolor=GROUND[0], alpha=0.3, edgecolor="0.35", linestyle="--", label="cell of a GBS, on the ground"),
        Line2D([], [], color="0.75", linewidth=0.8, label=f"voxels of {scenario.voxel_size_m:g} m"),
    ]
