"""One game seen from above, as text and as a picture."""

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lawn_sb3.game.state import State
from lawn_sb3.scenario import Scenario

UAV_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442", "#000000")
"""Okabe and Ito's colours, which colour-blind readers can tell apart; they repeat after eight UAVs."""


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


def draw_picture(scenario: Scenario, state: State, game: int = 0) -> NDArray[np.uint8]:
    """Draw a game from above as a picture: GBS cells, UAVs (dots), their destinations (crosses), altitude in metres.

    :param scenario: the scenario
    :param state: state of the games
    :param game: which of them
    :return: [480, 480, 3]
    """
    figure = Figure(figsize=(4.8, 4.8), dpi=100, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    position = scenario.voxel_centre(state.position[game])
    destination = scenario.voxel_centre(state.destination[game])
    gbs = scenario.gbs_positions
    axes.plot(gbs[:, 0], gbs[:, 1], "^", color="0.4", markersize=12, label="GBS")
    for i in range(scenario.num_uavs):
        colour = UAV_COLOURS[i % len(UAV_COLOURS)]
        faded = 1.0 if state.flying[game, i] else 0.3
        axes.plot(*destination[i, :2], "x", color=colour, markersize=9, markeredgewidth=2, alpha=faded)
        axes.plot(*position[i, :2], "o", color=colour, markersize=9, alpha=faded)
        x_m, y_m, z_m = position[i]
        axes.annotate(f"{i} at {z_m:.0f} m", (x_m, y_m), (7, 5), textcoords="offset points", fontsize=8)
    width_m, length_m = scenario.grid[0] * scenario.voxel_size_m, scenario.grid[1] * scenario.voxel_size_m
    axes.set(xlim=(0, width_m), ylim=(0, length_m), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    axes.set_title("triangles GBSs, dots UAVs, crosses destinations", fontsize=9)
    axes.grid(alpha=0.3)
    canvas.draw()  # type: ignore[no-untyped-call]
    rgba = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
    return rgba[..., :3].copy()
