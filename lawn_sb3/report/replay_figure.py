"""A replay as a picture of one slot, and as a film of all: players side by side in space, and below what they had."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]
from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

from lawn_sb3.game.radio import radio_map
from lawn_sb3.report.space import Floats, draw_space, offsets, uav_look
from lawn_sb3.report.style import colours, title_of, use_house_style
from lawn_sb3.results.tracks import Flown, Replay, Track
from lawn_sb3.whole_files import whole_file

LOADS = LinearSegmentedColormap.from_list("loads", ["#E3E9F1", "#B23C00"])
"""Colours of cells, from no UAV to the most."""
QUANTITIES = {"rate_mbps": "rate\n(Mbps)", "ema_rate_mbps": "EMA rate\n(Mbps)", "utility_mbps": "utility U\n(Mbps)"}
"""What is drawn over the slots, beside the loads."""
FRAMES_A_SECOND = 2
FILM_DPI = 100
LAST_FRAMES = 4
"""How often a film shows its last slot before it begins anew."""
ROOM_FOR_Z = 0.1
"""Between the last airspace and the bar of loads, for a label that no layout knows of: share of one airspace."""
MOST_NAMED = 12
"""With more GBSs or UAVs names would cover each other."""


def replay_figure(replay: Replay, slot: int | None = None) -> Figure:
    """Draw the first episode of a replay as it stands in one slot.

    :param replay: what is shown
    :param slot: the slot; by default, or beyond it, the last of each player
    :return: a column for each player: the airspace with the paths so far and the cells coloured by load, and below it
        loads, rates, EMA rates and utilities over the slots, with the slot marked
    """
    use_house_style()
    figure = Figure(figsize=(0.8 + 3.4 * len(replay.flown), 8.6), layout="constrained")
    halves: Any = figure.subfigures(2, 1, height_ratios=[1.0, 1.4])
    top, below = halves
    most = max(int(track.cell_load.max()) for track in _first(replay))
    palette = colours([one.key for one in replay.flown])
    scenes = []
    for k, flown in enumerate(replay.flown):
        ax = top.add_subplot(1, len(replay.flown), k + 1, projection="3d")
        _draw_scene(ax, replay, flown.tracks[0], slot, max(most, 1))
        title_of(ax, f"{flown.title}\n{_standing(flown, slot)}", palette[flown.key], height=0.93)
        scenes.append(ax)
    shade = ScalarMappable(Normalize(0, max(most, 1)), LOADS)
    bar = top.colorbar(shade, ax=scenes, shrink=0.5, pad=ROOM_FOR_Z / len(scenes), label="UAVs in the cell")
    bar.locator = MaxNLocator(integer=True)
    bar.update_ticks()
    _draw_charts(below, replay, slot, max(most, 1))
    return figure


def save_film(replay: Replay, path: Path, advance: Callable[[str, int], None]) -> None:
    """Write the first episode of a replay slot by slot: a GIF, or an MP4 where ffmpeg is there, by the ending.

    :param replay: what is shown
    :param path: the file
    :param advance: called after each slot with what is being done, and how many slots there are
    """
    last = max(track.slots for track in _first(replay))
    slots = [*range(last + 1), *[last] * LAST_FRAMES]
    # Pictures of the same size, drawn anew one by one: who moves is a small part of what 3D axes have to draw.
    writer: Any = (PillowWriter if path.suffix == ".gif" else FFMpegWriter)(fps=FRAMES_A_SECOND)
    figure = replay_figure(replay, 0)
    with whole_file(path) as part, writer.saving(figure, part, FILM_DPI):
        for slot in slots:
            writer.fig = replay_figure(replay, slot)
            writer.grab_frame()
            advance("drawing", len(slots))


def _first(replay: Replay) -> list[Track]:
    return [flown.tracks[0] for flown in replay.flown]


def _at(track: Track, slot: int | None) -> int:
    """The slot that shows how things stand then: none is later than the last."""
    return track.slots if slot is None else min(slot, track.slots)


def _standing(flown: Flown, slot: int | None) -> str:
    track = flown.tracks[0]
    mean = track.rows["utility_mbps"].mean()
    return f"slot {_at(track, slot)} of {track.slots}, U {mean:.1f} ({flown.means['utility_mbps']:.1f}) Mbps"


def _draw_scene(ax: Axes3D, replay: Replay, track: Track, slot: int | None, most: int) -> None:
    """The airspace with the floor coloured by load, and the UAVs with the paths that they have flown."""
    game, now = replay.game, _at(track, slot)
    ax.computed_zorder = False
    cell, size, low = radio_map(game).cell[:, :, 0], game.voxel_size_m, game.min_altitude_m
    for gbs in range(game.num_gbs):
        squares = [
            [(size * (x + i), size * (y + j), low) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
            for x, y in np.argwhere(cell == gbs)
        ]
        if squares:
            colour = LOADS(track.cell_load[now, gbs] / most)
            ax.add_collection3d(Poly3DCollection(squares, facecolors=colour, edgecolors=colour, zorder=0))
    draw_space(ax, game)
    aside = np.pad(offsets(game), ((0, 0), (0, 1)))
    goals = game.voxel_centre(replay.missions.destinations[track.episode]) + aside
    for uav in range(game.num_uavs):
        (colour, line), path = uav_look(uav), game.voxel_centre(track.voxels[: now + 1, uav]) + aside[uav]
        here = path[-1]
        ax.plot(*path.T, line, color=colour, linewidth=1.6, zorder=3)
        ax.plot(*path[:1].T, "o", color=colour, markerfacecolor="white", markersize=5, zorder=4)
        ax.plot(*goals[uav][:, None], "x", color=colour, markersize=6, markeredgewidth=1.8, zorder=4)
        if track.flying[now, uav]:
            _draw_link(ax, here, game.gbs_positions[track.cell[now, uav]])
        ax.plot(*here[:, None], "o", color=colour, markeredgecolor="white", markersize=8, zorder=5)
        if game.num_uavs <= MOST_NAMED:
            ax.text(here[0], here[1], here[2] + 0.35 * size, str(uav), color=colour, ha="center", fontsize=9, zorder=6)


def _draw_link(ax: Axes3D, uav: Floats, gbs: Floats) -> None:
    ax.plot(*np.stack([uav, gbs]).T, ":", color="0.35", linewidth=1.0, zorder=2)


def _draw_charts(figure: Any, replay: Replay, slot: int | None, most: int) -> None:
    """Loads and what each UAV had over the slots, a column for each player, all to the same scales."""
    rows = 1 + len(QUANTITIES)
    axes = figure.subplots(rows, len(replay.flown), sharex="col", sharey="row", squeeze=False)
    for k, track in enumerate(_first(replay)):
        loads = axes[0][k]
        loads.imshow(track.cell_load.T, aspect="auto", cmap=LOADS, vmin=0, vmax=most, origin="lower")
        loads.grid(visible=False)
        loads.yaxis.set_major_locator(MaxNLocator(integer=True, nbins=5))
        for ax, name in zip(axes[1:, k], QUANTITIES, strict=True):
            _draw_lines(ax, getattr(track, name))
        for ax in axes[:, k]:
            ax.axvline(_at(track, slot), color="0.2", linewidth=1.2)
            ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes[-1][k].set_xlabel("slot")
        axes[-1][k].set_xlim(-0.5, track.slots + 0.5)
    for ax, label in zip(axes[:, 0], ("cell of\nGBS", *QUANTITIES.values()), strict=True):
        ax.set_ylabel(label)
    for ax in axes[1:, 0]:
        ax.set_ylim(bottom=0.0)
    count = replay.game.num_uavs
    if count <= MOST_NAMED:
        looks = [uav_look(uav) for uav in range(count)]
        handles = [Line2D([], [], color=c, linestyle=line, label=f"UAV {uav}") for uav, (c, line) in enumerate(looks)]
        figure.legend(handles=handles, loc="outside lower center", ncols=min(count, 6), frameon=False)


def _draw_lines(ax: Axes, values: Floats) -> None:
    for uav, own in enumerate(values.T):
        colour, line = uav_look(uav)
        ax.plot(own, line, color=colour, marker="o", markersize=3, linewidth=1.3)
