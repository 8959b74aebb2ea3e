"""The columns of each table that a run leaves, with unit and bounds; all are CSV with nine digits."""

from lawn_sb3.experiment.run_directory.csv_file import Columns, flag, number, whole
from lawn_sb3.scenario import Scenario

EPISODE_KEY = ["episode", "uav"]
PATH_KEY = [*EPISODE_KEY, "slot"]


def evaluation_columns(game: Scenario, episodes: int) -> Columns:
    """One row per test episode and UAV."""
    return {
        **episode_and_uav(game, episodes),
        "reward": number("accumulated reward J"),
        "rate_mbps": number("bias-corrected moving average of the rate when the mission ended", "Mbps", 0),
        "slots": whole("flight time T_i", "slots", 1, game.max_slots),
        "min_slots": whole("shortest possible flight time T_i^min", "slots", 1, sum(game.grid)),
        "arrived": flag("whether the UAV arrived by the deadline T_max"),
        "utility_mbps": number("utility U_i, 0 for a failed mission", "Mbps", 0),
        "collisions": whole("slots in which it collided", "slots", 0, game.max_slots),
        "makespan_slots": whole("flight time of the last UAV of the episode", "slots", 1, game.max_slots),
        "mean_cell_load": number("load of its own cell, mean over its slots", "UAVs", 1, game.num_uavs),
    }


def slots_columns(game: Scenario, last: int) -> Columns:
    """One row per slot, up to the last one that was flown: means over all test episodes."""
    by_gbs = {f"gbs_{b}": number(f"UAVs in the cell of GBS {b}", "UAVs", 0, game.num_uavs) for b in range(game.num_gbs)}
    by_load = {
        f"load_{k}": number(f"UAVs in a cell with {k} UAVs", "UAVs", 0, game.num_uavs)
        for k in range(1, game.num_uavs + 1)
    }
    return {"slot": whole("slot, from 1", "slots", 1, last), **by_gbs, **by_load}


def paths_columns(game: Scenario, traced: int) -> Columns:
    """One row per slot and UAV of the first test episodes, from the origin (slot 0) to where its mission ended."""
    width, length, height = game.grid
    return {
        **episode_and_uav(game, traced),
        "slot": whole("slots flown so far", "slots", 0, game.max_slots),
        "x": whole("position", "voxels", 0, width - 1),
        "y": whole("position", "voxels", 0, length - 1),
        "z": whole("position", "voxels", 0, height - 1),
        "cell": whole("GBS that serves the UAV", "", 0, game.num_gbs - 1),
        "cell_load": whole("UAVs in its cell, itself included", "UAVs", 1, game.num_uavs),
        "rate_mbps": number("rate in this slot, 0 at the origin", "Mbps", 0),
    }


def regret_columns(game: Scenario, episodes: int) -> Columns:
    """One row per test episode and UAV; the others keep the trajectories that they flew."""
    return {
        **episode_and_uav(game, episodes),
        "utility_mbps": number("utility U_i that the UAV had", "Mbps", 0),
        "best_mbps": number("utility of its best response", "Mbps", 0),
        "best_slots": whole("flight time of its best response", "slots", 0, game.max_slots),
    }


def scaling_columns(game: Scenario) -> Columns:
    """One row per number of UAVs: means over episodes and UAVs."""
    return {
        "num_uavs": whole("number of UAVs N", "UAVs", 1),
        "episodes": whole("joint episodes flown", "", 1),
        "reward": number("accumulated reward J of a UAV"),
        "rate_mbps": number("rate of a UAV", "Mbps", 0),
        "makespan_slots": number("flight time of an episode's last UAV", "slots", 1, game.max_slots),
        "completion_slots": number("flight time of a UAV", "slots", 1, game.max_slots),
        "success_percent": number("UAVs that arrived by the deadline", "%", 0, 100),
        "utility_mbps": number("utility U_i of a UAV", "Mbps", 0),
        "welfare_mbps": number("sum of the utilities of an episode", "Mbps", 0),
        "collisions": number("slots in which a UAV collided", "slots", 0, game.max_slots),
    }


def costs_columns() -> Columns:
    """One row per number of UAVs: what the player takes for a game."""
    return {
        "num_uavs": whole("number of UAVs N", "UAVs", 1),
        "decision_ms": number("time for one move of one UAV, planning before the first one included", "ms", 0),
        "memory_mb": number("peak memory of the process, that of Python and the libraries included", "MB", 0),
    }


def episode_and_uav(game: Scenario, episodes: int) -> Columns:
    """The columns that tell the UAVs of test episodes apart."""
    return {
        "episode": whole("test episode, from 0", "", 0, max(episodes - 1, 0)),
        "uav": whole("UAV of the episode, from 0", "", 0, game.num_uavs - 1),
    }
