"""One game seen from above, as text and as a picture."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from lawn_sb3.game.radio import cell_borders, radio_map
from lawn_sb3.game.state import State
from lawn_sb3.scenario import Scenario

UAV_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442", "#000000")
"""Okabe and Ito's colours, which colour-blind readers can tell apart; they repeat after eight UAVs."""
SIZE_INCHES = (4.8, 4.8)
DPI = 100
"""Of a picture: 480 pixels wide and high."""
DARKEST = 1 / 3
"""How far towards black a cell is that serves all UAVs."""
ASIDE_VOXELS = 0.16
"""How far UAVs are drawn from the voxel centres, so that those in the same voxels stay apart."""


def draw_text(scenario: Scenario, state: State, game: int = 0) -> str:
    """Draw a game from above as text: north is up, digits are UAVs, letters their destinations, ``^`` a GBS.

    :param scenario: the scenario
    :param state: state of the games
    :param game: which of them
    :return: one line per row of voxels, then one line per UAV
    """
    width, length, _ = scenario.grid
    rows = [["." for _ in range(width)] for _ in range(length)]
    for x_m, y_m, _ in scenario.gbs_positions:
        column = min(max(int(x_m / scenario.voxel_size_m), 0), width - 1)
        row = min(max(int(y_m / scenario.voxel_size_m), 0), length - 1)
        rows[row][column] = "^"
    lines = []
    for i in range(scenario.num_uavs):
        (x, y, z), (dx, dy, dz) = state.position[game, i], state.destination[game, i]
        status = "flying" if state.flying[game, i] else "done"
        rows[dy][dx] = chr(ord("a") + i % 26)
        lines.append(f"{i % 10}: ({x}, {y}, {z}) to {chr(ord('a') + i % 26)}: ({dx}, {dy}, {dz}), {status}")
    for i in range(scenario.num_uavs):
        x, y, _ = state.position[game, i]
        rows[y][x] = str(i % 10)
    return "\n".join(["".join(row) for row in reversed(rows)] + lines)


def draw_picture(
    scenario: Scenario, state: State, game: int = 0, trail: Sequence[NDArray[np.int64]] = ()
) -> NDArray[np.uint8]:
    """Draw a game from above as a picture.

    Cells with their borders, the darker the more UAVs they serve, and at each GBS (triangle) how many these are and how
    many RBs they share; UAVs (dots) with their altitude, where they came from (lines), and their destinations
    (crosses). Paths are drawn a little aside, so that those in the same voxels stay apart.

    :param scenario: the scenario
    :param state: state of the games
    :param game: which of them
    :param trail: where its UAVs were after each slot so far, in voxels, each [N, 3]; none by default
    :return: [480, 480, 3]
    """
    figure = Figure(figsize=SIZE_INCHES, dpi=DPI, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    width_m, length_m = scenario.grid[0] * scenario.voxel_size_m, scenario.grid[1] * scenario.voxel_size_m
    load = state.cell_load[game]
    cell = load[radio_map(scenario).cell[:, :, 0]]
    extent = (0.0, width_m, 0.0, length_m)
    axes.imshow(cell.T, cmap="Greys", vmin=0, vmax=scenario.num_uavs / DARKEST, origin="lower", extent=extent)
    axes.add_collection(LineCollection(list(cell_borders(scenario)), colors="0.3", linestyles="--", linewidths=1.0))
    for (x_m, y_m, _), of_cell, rbs in zip(scenario.gbs_positions, load, scenario.num_rbs, strict=True):
        axes.plot(x_m, y_m, "^", color="0.4", markersize=11)
        text = f"{of_cell} UAV{'' if of_cell == 1 else 's'}, {rbs} RBs"
        place: dict[str, Any] = {"xytext": (0, -9), "textcoords": "offset points", "ha": "center", "va": "top"}
        axes.annotate(text, (x_m, y_m), fontsize=7, color="0.25", **place)
    _draw_uavs(axes, scenario, state, game, trail)
    axes.set(xlim=(0, width_m), ylim=(0, length_m), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    axes.set_title("dots UAVs, crosses destinations, triangles GBSs; darker cells serve more", fontsize=8)
    canvas.draw()  # type: ignore[no-untyped-call]
    rgba = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
    return rgba[..., :3].copy()


def _draw_uavs(axes: Axes, scenario: Scenario, state: State, game: int, trail: Sequence[NDArray[np.int64]]) -> None:
    """Each UAV with its trail and its destination; those that are done are faded."""
    angle = 2.0 * np.pi * np.arange(scenario.num_uavs) / scenario.num_uavs + 0.3
    aside_m = ASIDE_VOXELS * scenario.voxel_size_m * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    destination = scenario.voxel_centre(state.destination[game])[:, :2] + aside_m
    path = scenario.voxel_centre(np.stack([*trail, state.position[game]]))  # [T, N, 3]
    drawn = path[..., :2] + aside_m
    for i in range(scenario.num_uavs):
        colour = UAV_COLOURS[i % len(UAV_COLOURS)]
        faded = 1.0 if state.flying[game, i] else 0.35
        edge: dict[str, Any] = {
            "path_effects": [withStroke(linewidth=2.5, foreground="white")]
        }  # pale colours show on pale cells too
        axes.plot(*drawn[:, i].T, "-", color=colour, linewidth=1.4, alpha=faded)
        axes.plot(*drawn[:-1, i].T, "o", color=colour, markersize=2.5, alpha=faded)
        axes.plot(*destination[i], "x", color=colour, markersize=8, markeredgewidth=2, alpha=faded, **edge)
        axes.plot(*drawn[-1, i], "o", color=colour, markersize=9, markeredgecolor="white", alpha=faded)
        right = path[-1, i, 0] > 0.8 * scenario.grid[0] * scenario.voxel_size_m
        offset, across = ((-7, 5), "right") if right else ((7, 5), "left")
        place: dict[str, Any] = {"xytext": offset, "textcoords": "offset points", "ha": across}
        axes.annotate(f"{i} at {path[-1, i, 2]:.0f} m", tuple(drawn[-1, i]), fontsize=8, **edge, **place)
