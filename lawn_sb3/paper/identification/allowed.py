"""What the games that the paper's figures allow together have in common, and what they leave open."""

from typing import Any

import pandas as pd

from lawn_sb3.paper.identification.candidates import PAPER, PRINTED
from lawn_sb3.paper.identification.random_row import LEAST

READ = {
    "grid": "airspace (voxels)",
    "max_voxel_steps": "v_max",
    "moves": "a move out of the airspace",
    "arrived_uav": "a UAV that is done",
    "arrival": "arrival counts",
    "gbs_layout": "GBS sites",
    "bias_horizon": "horizon of the bias correction",
}
"""Columns of the joint search that are readings, and what the page calls them."""
PRESET = {
    "grid": PAPER.grid,
    "max_voxel_steps": PAPER.max_voxel_steps,
    "moves": PAPER.out_of_bounds,
    "arrived_uav": PAPER.arrived_uav,
    "arrival": PAPER.arrival,
    "gbs_layout": PAPER.gbs_layout,
    "bias_horizon": PAPER.bias_horizon,
}
FITTED = ("tx_power_dbm", "nav_weight", "collision_penalty", "fail_penalty")


def consistent(games: pd.DataFrame) -> pd.DataFrame:
    """The games that the paper's figures are consistent with."""
    return games[games["verdict"] == "consistent"]


def joint_findings(games: pd.DataFrame) -> dict[str, str]:
    """Say what holds in all allowed games, and what is jointly not identified.

    :param games: what :func:`lawn_sb3.paper.identification.joint.joint_search` returned
    :return: a sentence or two by reading, then for ``constants``
    """
    allowed = consistent(games)
    fitted = games[games["gbs_layout"] != "any"]
    found = {}
    for name in READ:
        tried = games if name in ("grid", "max_voxel_steps", "moves", "arrived_uav", "arrival") else fitted
        counts = {value: int((allowed[name] == value).sum()) for value in dict.fromkeys(tried[name])}
        open_values = [f"{_shown(value)} ({count:,})" for value, count in counts.items() if count]
        never = [_shown(value) for value, count in counts.items() if not count]
        text = "the paper's figures are consistent with no value tried"
        if len(open_values) == 1:
            text = f"only {open_values[0]} is in games that the paper's figures are consistent with"
        elif open_values:
            text = f"jointly not identified: in consistent games are {', '.join(open_values)}"
        found[name] = f"{text}; in none: {', '.join(never)}." if never else f"{text}."
    return {**found, "constants": _constants(allowed)} if len(allowed) else found


def _constants(allowed: pd.DataFrame) -> str:
    """Between which values the fitted constants lie, and mean T_min."""
    ranges = [f"{name} {allowed[name].min():.4g} to {allowed[name].max():.4g}" for name in (*FITTED, LEAST)]
    return f"over the {len(allowed):,} consistent games: {', '.join(ranges)}."


def success_by_reading(games: pd.DataFrame) -> pd.DataFrame:
    """Random's success on every grid by v_max, move and arrival: all that decides it.

    :param games: what the joint search returned
    :return: texts: a row for each grid and v_max, a column for each reading of moves and arrivals; what the paper's
        figures are consistent with is set in bold
    """
    keys = ["grid", "max_voxel_steps", "moves", "arrival"]
    rows: dict[tuple[Any, Any], dict[str, str]] = {}
    for (grid, steps, moves, arrival), group in games.groupby(keys, sort=False):
        success = f"{group['success_percent'].iloc[0]:.1f}"
        held = (group["verdict"] == "consistent").any()
        rows.setdefault((grid, steps), {})[f"{moves}, {arrival}"] = f"**{success}**" if held else success
    readings = {"airspace (voxels)": [_shown(grid) for grid, _ in rows], "v_max": [steps for _, steps in rows]}
    return pd.DataFrame(readings).join(pd.DataFrame(list(rows.values())))


def examples(games: pd.DataFrame) -> pd.DataFrame:
    """For each reading that departs from the preset, the consistent game that departs least otherwise.

    :param games: what the joint search returned
    :return: rows of the search: the preset itself, one for each other value of a reading that a consistent game has,
        and the consistent games with the fewest and the most voxels
    """
    allowed = consistent(games).copy()
    if allowed.empty:
        return allowed
    apart = pd.DataFrame({name: allowed[name] != value for name, value in PRESET.items()})
    allowed = allowed.assign(departures=apart.sum(axis=1), off=allowed["z_success_percent"].abs())
    allowed = allowed.sort_values(["departures", "off"], kind="stable")
    chosen = list(allowed.index[:1])
    for name in READ:
        if name != "grid":
            for _, group in allowed[allowed[name] != PRESET[name]].groupby(name, sort=False):
                chosen.append(group.index[0])
    voxels = allowed["grid"].map(lambda grid: grid[0] * grid[1] * grid[2])
    for end in (voxels.min(), voxels.max()):
        chosen.append(allowed.index[voxels == end][0])
    return allowed.loc[list(dict.fromkeys(chosen))].drop(columns=["departures", "off"])


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return " x ".join(map(str, value)) + (" (as printed)" if value == PRINTED.grid else "")
    return str(value)
