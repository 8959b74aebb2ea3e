"""What the games that the paper's figures allow together have in common, and what they leave open."""

from typing import Any

import pandas as pd

from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.paper.identification.candidates import PAPER, PRINTED
from lawn_sb3.paper.identification.joint import WEIGHTS, Reading
from lawn_sb3.paper.identification.random_row import LEAST
from lawn_sb3.paper.printed_values import TABLE_II
from lawn_sb3.planning import ForecastPlayer, ShortestPathPlayer, WelfarePlayer
from lawn_sb3.scenario import Scenario

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
FITTED = ("tx_power_dbm", *WEIGHTS)


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
    return {**found, "constants": _constants(allowed, len(fitted))} if len(allowed) else found


def _constants(allowed: pd.DataFrame, fitted: int) -> str:
    """Between which values the fitted constants lie, and mean T_min."""
    ranges = [f"{name} {_span(allowed[name])}" for name in FITTED]
    return (
        f"over the {len(allowed):,} consistent games, of {fitted:,} that were fitted: {', '.join(ranges)}; mean T_min "
        f"{_span(allowed[LEAST])} slots."
    )


def _span(values: pd.Series) -> str:
    """From the least to the largest value."""
    return " to ".join(dict.fromkeys(f"{end:.4g}" for end in (values.min(), values.max())))


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


def as_game(row: pd.Series) -> Scenario:
    """The game of a row of the joint search, with what was fitted to it."""
    reading = Reading(*(row[name] for name in Reading._fields))
    return reading.game(**{name: row[name] for name in ("gbs_layout", "bias_horizon", *FITTED)})


def conclusions(chosen: pd.DataFrame, episodes: int, seed: int) -> pd.DataFrame:
    """What planners earn in some allowed games: which of this kit's conclusions hold in each, without any training.

    :param chosen: games, such as :func:`examples` gives
    :param episodes: joint episodes of each player
    :param seed: picks the missions
    :return: per game J and success of UAVs that fly straight, and the mean utility of these, of a planner that sees o_i
        (forecast), and of a welfare ascent, which sees everything
    """
    rows = []
    for _, row in chosen.iterrows():
        game = as_game(row)
        straight, forecast, welfare = (
            summarize(evaluate(player, game, episodes, seed))
            for player in (ShortestPathPlayer(), ForecastPlayer(), WelfarePlayer(starts=1))
        )
        figures = {f"straight_{name}": straight[name] for name in ("reward", "success_percent", "utility_mbps")}
        others = {"forecast_utility_mbps": forecast["utility_mbps"], "welfare_utility_mbps": welfare["utility_mbps"]}
        rows.append({name: row[name] for name in READ} | figures | others)
    return pd.DataFrame(rows)


def conclusion_findings(table: pd.DataFrame) -> dict[str, str]:
    """Say in how many of the games each conclusion holds.

    :param table: what :func:`conclusions` returned
    :return: a sentence by conclusion
    """
    if table.empty:
        return {}
    printed, straight = TABLE_II["CTDE-MAPPO"], table["straight_utility_mbps"]
    sight = table["forecast_utility_mbps"] / straight - 1.0
    network = table["welfare_utility_mbps"] / straight - 1.0
    beats = (table["straight_reward"] > printed.reward).sum()
    return {
        "straight flight": f"earns more than the {printed.reward:g} that the paper prints of CTDE-MAPPO in {beats} of "
        f"{len(table)} games (J̄ {table['straight_reward'].min():.2f} to {table['straight_reward'].max():.2f}), with "
        f"{_span(table['straight_success_percent'])} % success.",
        "heeding the loads": f"a planner that sees o_i alone earns more utility than straight flight in "
        f"{(sight > 0).sum()} of {len(table)} games, by {100 * sight.min():.0f} to {100 * sight.max():.0f} %.",
        "the network": f"joint flights for the welfare earn {100 * network.min():.0f} to {100 * network.max():.0f} % "
        "more utility than straight flight.",
    }


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return " x ".join(map(str, value)) + (" (as printed)" if value == PRINTED.grid else "")
    return str(value)
