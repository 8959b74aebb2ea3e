"""An airspace in space and the UAVs in it, as every picture of flights draws them."""

from typing import Literal

import numpy as np
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]
from numpy.typing import NDArray

from lawn_sb3.game.radio import cell_borders
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]

UAV_COLOURS = ("#1B1BFF", "#661100", "#A81FA0", "#94A000", "#E7298A")
"""Colour-blind readers can tell the first four apart by lightness and hue, and none is a method's colour."""
UAV_COLOURS_IN_THE_DARK = ("#8F9BFF", "#E0875A", "#E58BDD", "#C3CF4A", "#FF7FB8")
"""The same on a dark ground."""
UAV_LINES: tuple[Literal["-", "--", ":"], ...] = ("-", "--", ":")
"""Beyond five UAVs the colours repeat with another line; beyond fifteen both do."""
SITE_COLOUR, BORDER_COLOUR = "0.55", "0.45"
OFFSET_VOXELS = 0.16
"""How far paths are drawn from the voxel centres, so that those in the same voxels stay apart."""
FLATTEST = 0.5
"""In space, an airspace flatter than this is drawn stretched to it: height over the longer side."""


def offsets(scenario: Scenario) -> Floats:
    """How far the path of each UAV is moved aside, in metres along x and y [N, 2].

    These are points of a small circle, no two of them in line with a side of the area.
    """
    angle = 2.0 * np.pi * np.arange(scenario.num_uavs) / scenario.num_uavs + 0.3
    return OFFSET_VOXELS * scenario.voxel_size_m * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def uav_look(uav: int) -> tuple[str, Literal["-", "--", ":"]]:
    """Colour and line of a UAV's path."""
    return UAV_COLOURS[uav % len(UAV_COLOURS)], UAV_LINES[uav // len(UAV_COLOURS) % len(UAV_LINES)]


def draw_space(ax: Axes3D, game: Scenario) -> None:
    """Draw an airspace with the borders of its cells on the ground and its GBSs, and set axes and view."""
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
