"""A replay as a page: the airspace in space, slot by slot, and below it what the UAVs had."""

from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray
from plotly.offline import get_plotlyjs

from lawn_sb3.game.radio import cell_borders, radio_map
from lawn_sb3.report.space import FLATTEST, UAV_COLOURS, UAV_COLOURS_IN_THE_DARK, UAV_LINES, offsets
from lawn_sb3.report.style import colours
from lawn_sb3.report.web.page import as_page, own
from lawn_sb3.results.tracks import Flown, Replay, Track

ROWS = ("reward", "rate_mbps", "slots", "min_slots", "arrived", "utility_mbps", "collisions")
"""Columns of the raw rows that the page shows."""
DASHES = {"-": "solid", "--": "dash", ":": "dot"}
"""How Plotly calls lines."""


def replay_page(replay: Replay, title: str, command: str) -> str:
    """Write a replay as HTML.

    :param replay: what is shown
    :param title: its heading
    :param command: the command that makes the page again
    :return: the page; it fetches nothing
    """
    body = own("replay.html").replace("{{title}}", escape(title)).replace("{{command}}", escape(command))
    styles, scripts = [own("base.css"), own("replay.css")], [get_plotlyjs(), own("replay.js")]
    return as_page(title, body, styles, scripts, replay_data(replay))


def replay_data(replay: Replay) -> dict[str, Any]:
    """All that the page's script draws, as JSON can hold it: lengths in metres, rates in Mbps, nine digits."""
    game, methods = replay.game, colours([one.key for one in replay.flown])
    return {
        "seed": replay.seed,
        "total": replay.total,
        "game": {
            "title": game.title,
            "grid": game.grid,
            "voxel": game.voxel_size_m,
            "low": game.min_altitude_m,
            "maxSlots": game.max_slots,
            "flattest": FLATTEST,
            "cells": radio_map(game).cell[:, :, 0].tolist(),
            "borders": cell_borders(game).tolist(),
            "gbs": game.gbs_positions.tolist(),
            "rbs": game.num_rbs.tolist(),
        },
        "looks": {
            "light": UAV_COLOURS,
            "dark": UAV_COLOURS_IN_THE_DARK,
            "dashes": [DASHES[line] for line in UAV_LINES],
            "offsets": _digits(offsets(game)),
        },
        "episodes": [{"number": k, "destinations": replay.missions.destinations[k].tolist()} for k in replay.episodes],
        "methods": [_method(one, methods[one.key]) for one in replay.flown],
    }


def _method(flown: Flown, colour: str) -> dict[str, Any]:
    means = {name: _digits(np.array(value)) for name, value in flown.means.items()}
    return {
        "title": flown.title,
        "colour": colour,
        "means": means,
        "tracks": [_track(track) for track in flown.tracks],
    }


def _track(track: Track) -> dict[str, Any]:
    return {
        "slots": track.slots,
        "voxels": track.voxels.tolist(),
        "cell": track.cell.tolist(),
        "loads": track.cell_load.tolist(),
        "rate": _digits(track.rate_mbps),
        "ema": _digits(track.ema_rate_mbps),
        "utility": _digits(track.utility_mbps),
        "rows": {name: _digits(track.rows[name].to_numpy()) for name in ROWS},
    }


def _digits(values: NDArray[Any]) -> Any:
    """Numbers as the raw rows have them, with nine digits; none for a gap."""
    if values.ndim:
        return [_digits(value) for value in values]
    if values.dtype.kind != "f":
        return values.item()
    return None if np.isnan(values) else float(f"{values:.9g}")
