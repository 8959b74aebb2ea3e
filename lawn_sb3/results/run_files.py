"""What each file of a finished run must hold: the rows of this cell's evaluation, and of no other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import FLIGHT_FILES, REGRET_FILE, SAMPLED_FILE, SCALING_FILE
from lawn_sb3.experiment.evaluation import COLUMNS, PATH_COLUMNS
from lawn_sb3.experiment.recipe import Cell, Evaluation, Scaling
from lawn_sb3.experiment.regret import COLUMNS as REGRET_COLUMNS
from lawn_sb3.experiment.regret_files import is_too_low
from lawn_sb3.game.airspace import Missions, draw_missions
from lawn_sb3.results.csv_file import Allowed, checked_values, read_table, read_text_columns
from lawn_sb3.scenario import Scenario

EVALUATION_FILE, SLOTS_FILE, PATHS_FILE = FLIGHT_FILES
PROGRESS_FILE = "progress.csv"
EPISODE_KEY = ["episode", "uav"]
PATH_KEY = [*EPISODE_KEY, "slot"]
TOLERANCE = 1e-6
"""Files keep nine digits."""
SCALING_MEANS = (
    "reward", "rate_mbps", "makespan_slots", "completion_slots", "utility_mbps", "success_percent", "collisions",
    "welfare_mbps",
)  # fmt: skip
"""Columns of ``scaling.csv`` with means over the episodes."""


def read_evaluation(cell: Cell, name: str = EVALUATION_FILE) -> pd.DataFrame:
    """Read the raw rows of an evaluation.

    :param cell: the cell of the run
    :param name: the file
    :return: one row an episode and UAV, in this order, with the columns ``COLUMNS``
    :raises UserError: if the file is not whole
    """
    game, episodes = cell.scenario, cell.evaluation.episodes
    slots = Allowed(1, game.max_slots, whole=True)
    columns = {
        **dict.fromkeys(COLUMNS, Allowed()),
        "episode": Allowed(0, episodes - 1, whole=True),
        "uav": Allowed(0, game.num_uavs - 1, whole=True),
        "rate_mbps": Allowed(0),
        "slots": slots,
        "min_slots": Allowed(1, sum(game.grid), whole=True),
        "arrived": Allowed(flag=True),
        "utility_mbps": Allowed(0),
        "collisions": Allowed(0, game.max_slots, whole=True),
        "makespan_slots": slots,
        "mean_cell_load": Allowed(1, game.num_uavs),
    }
    rows = read_table(cell.directory / name, columns, episodes * game.num_uavs, EPISODE_KEY)
    return rows.sort_values(EPISODE_KEY, ignore_index=True)


def read_sampled(cell: Cell, evaluation: pd.DataFrame) -> pd.DataFrame:
    """Read the raw rows of the test missions flown with sampled actions.

    :param cell: the cell of the run
    :param evaluation: what :func:`read_evaluation` returned
    :return: rows like those of the evaluation
    :raises UserError: if the file is not whole, or of other missions
    """
    rows = read_evaluation(cell, SAMPLED_FILE)
    if (rows["min_slots"] != evaluation["min_slots"]).any():
        raise UserError(f"{SAMPLED_FILE} has other missions than {EVALUATION_FILE}: min_slots must be the same in both")
    return rows


def read_slots(cell: Cell, evaluation: pd.DataFrame) -> pd.DataFrame:
    """Read how many UAVs flew where in each slot.

    :param cell: the cell of the run
    :param evaluation: what :func:`read_evaluation` returned
    :return: one row a slot, ``slot, gbs_0, gbs_1..., load_1, load_2...``: UAVs, means over the episodes
    :raises UserError: if the file is not whole, or of another evaluation
    """
    game, last = cell.scenario, int(evaluation["slots"].max())
    by_gbs = [f"gbs_{b}" for b in range(game.num_gbs)]
    by_load = [f"load_{k}" for k in range(1, game.num_uavs + 1)]
    columns = {"slot": Allowed(1, last, whole=True), **dict.fromkeys(by_gbs + by_load, Allowed(0, game.num_uavs))}
    rows = read_table(cell.directory / SLOTS_FILE, columns, last, ["slot"]).sort_values("slot", ignore_index=True)
    flying = (evaluation["slots"].to_numpy() >= rows["slot"].to_numpy()[:, None]).sum(axis=1)
    expected = flying / cell.evaluation.episodes
    for names in (by_gbs, by_load):
        total = rows[names].sum(axis=1).to_numpy()
        wrong = np.abs(total - expected) > TOLERANCE
        if wrong.any():
            at = int(wrong.argmax())
            raise UserError(
                f"{SLOTS_FILE}: {total[at]:g} UAVs fly in slot {at + 1} by {names[0]} to {names[-1]}: "
                f"must be {expected[at]:g} as in {EVALUATION_FILE}"
            )
    return rows


def read_paths(cell: Cell, evaluation: pd.DataFrame) -> pd.DataFrame:
    """Read where the UAVs of the first episodes flew.

    :param cell: the cell of the run
    :param evaluation: what :func:`read_evaluation` returned
    :return: one row a slot and UAV of each traced episode, slot 0 the origin, with the columns ``PATH_COLUMNS``
    :raises UserError: if the file is not whole, or of another evaluation
    """
    game, chosen = cell.scenario, cell.evaluation
    traced = min(chosen.traced_episodes, chosen.episodes)
    flown = evaluation.loc[evaluation["episode"] < traced, [*EPISODE_KEY, "slots"]]
    columns = {
        **dict.fromkeys(PATH_COLUMNS, Allowed()),
        "episode": Allowed(0, traced - 1, whole=True),
        "uav": Allowed(0, game.num_uavs - 1, whole=True),
        "slot": Allowed(0, game.max_slots, whole=True),
        **{axis: Allowed(0, size - 1, whole=True) for axis, size in zip("xyz", game.grid, strict=True)},
        "cell": Allowed(0, game.num_gbs - 1, whole=True),
        "cell_load": Allowed(1, game.num_uavs, whole=True),
        "rate_mbps": Allowed(0),
    }
    rows = read_table(cell.directory / PATHS_FILE, columns, int((flown["slots"] + 1).sum()), PATH_KEY)
    late = rows.merge(flown, on=EPISODE_KEY).query("slot > slots")
    if len(late):
        first = late.iloc[0]
        raise UserError(
            f"{PATHS_FILE}: UAV {first['uav']:g} of episode {first['episode']:g} flies in slot {first['slot']:g}: "
            f"must end after the {first['slots']:g} slots of {EVALUATION_FILE}"
        )
    rows = rows.sort_values(PATH_KEY, ignore_index=True)
    origins = draw_test_missions(game, chosen).origins[:traced].reshape(-1, 3)
    if (rows.loc[rows["slot"] == 0, list("xyz")].to_numpy() != origins).any():
        raise UserError(f"{PATHS_FILE} has other origins than the test missions of seed {chosen.seed}")
    return rows


def read_regrets(cell: Cell, evaluation: pd.DataFrame) -> pd.DataFrame:
    """Read what each UAV could have had by deviating alone.

    :param cell: the cell of the run
    :param evaluation: what :func:`read_evaluation` returned
    :return: one row an episode and UAV, in this order: the utility it had, that of its best response, and its slots
    :raises UserError: if the file is not whole, or of another evaluation
    """
    game, episodes = cell.scenario, cell.evaluation.episodes
    columns = {
        **dict.fromkeys(REGRET_COLUMNS, Allowed(0)),
        "episode": Allowed(0, episodes - 1, whole=True),
        "uav": Allowed(0, game.num_uavs - 1, whole=True),
        "best_slots": Allowed(0, game.max_slots, whole=True),
    }
    rows = read_table(cell.directory / REGRET_FILE, columns, episodes * game.num_uavs, EPISODE_KEY)
    rows = rows.sort_values(EPISODE_KEY, ignore_index=True)
    wrong = ((rows["utility_mbps"] - evaluation["utility_mbps"]).abs() > TOLERANCE).to_numpy()
    if wrong.any():
        at = int(wrong.argmax())
        row, expected = rows.iloc[at], evaluation["utility_mbps"].iloc[at]
        raise UserError(
            f"{REGRET_FILE}: UAV {row['uav']:g} of episode {row['episode']:g} had {row['utility_mbps']:g} Mbps: "
            f"must be {expected:g} as in {EVALUATION_FILE}"
        )
    low = is_too_low(rows, evaluation)
    if low.any():
        row = rows.iloc[int(low.argmax())]
        raise UserError(
            f"{REGRET_FILE}: UAV {row['uav']:g} of episode {row['episode']:g} had {row['utility_mbps']:g} Mbps without "
            f"a collision: its best response cannot be worth {row['best_mbps']:g}"
        )
    return rows


def read_scaling(cell: Cell, scaling: Scaling) -> pd.DataFrame:
    """Read what a run did among other numbers of UAVs.

    :param cell: the cell of the run
    :param scaling: what its recipe flies
    :return: one row for each number of UAVs: ``num_uavs, episodes`` and the columns of ``SCALING_MEANS``
    :raises UserError: if the file is not whole, or of other flights
    """
    slots = Allowed(1, cell.scenario.max_slots)
    columns = {
        "num_uavs": Allowed(1, whole=True),
        "episodes": Allowed(1, whole=True),
        **dict.fromkeys(SCALING_MEANS, Allowed()),
        "rate_mbps": Allowed(0),
        "makespan_slots": slots,
        "completion_slots": slots,
        "success_percent": Allowed(0, 100),
        "utility_mbps": Allowed(0),
        "welfare_mbps": Allowed(0),
        "collisions": Allowed(0, cell.scenario.max_slots),
    }
    rows = read_table(cell.directory / SCALING_FILE, columns, len(scaling.num_uavs), ["num_uavs"])
    flown = rows["num_uavs"].tolist()
    if sorted(flown) != sorted(scaling.num_uavs):
        raise UserError(f"{SCALING_FILE} is of {_listed(flown)} UAVs: must be {_listed(scaling.num_uavs)}")
    episodes = sorted(set(rows["episodes"]))
    if episodes != [scaling.episodes]:
        raise UserError(f"{SCALING_FILE} is of {_listed(episodes)} episodes: must be {scaling.episodes}")
    welfare = rows["utility_mbps"] * rows["num_uavs"]
    wrong = (np.abs(rows["welfare_mbps"] - welfare) > TOLERANCE * (1.0 + welfare)).to_numpy()
    if wrong.any():
        at = int(wrong.argmax())
        raise UserError(
            f"{SCALING_FILE} line {at + 2}: welfare_mbps = {rows['welfare_mbps'].iloc[at]:g}: must be num_uavs times "
            f"utility_mbps, {welfare.iloc[at]:g}"
        )
    return rows.sort_values("num_uavs", ignore_index=True)


def _listed(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers))


def draw_test_missions(scenario: Scenario, evaluation: Evaluation) -> Missions:
    """The missions that every method and seed of a recipe is tested on.

    :param scenario: the game
    :param evaluation: how players are scored
    :return: origins and destinations in voxels [E, N, 3]
    """
    return draw_missions(scenario, evaluation.episodes, np.random.default_rng(evaluation.seed))


def read_progress(cell: Cell) -> pd.DataFrame:
    """Read a training curve.

    :param cell: the cell of the run
    :return: one row a record: ``time/env_steps``, and columns that may have gaps
    :raises UserError: if the file is not whole
    """
    texts = read_text_columns(cell.directory / PROGRESS_FILE, ["time/env_steps"])
    allowed = {column: Allowed(gaps=True) for column in texts} | {"time/env_steps": Allowed(1, whole=True)}
    rows = pd.DataFrame({name: checked_values(texts[name], allowed[name], PROGRESS_FILE) for name in texts})
    steps, last = rows["time/env_steps"].to_numpy(), 0
    gap = cell.method.env_steps
    if len(steps):  # the first record comes after the first rollout, the next ones after whole rollouts
        last, gap = int(steps[-1]), -(-cell.evaluation.record_every // int(steps[0])) * int(steps[0])
    if last + gap <= cell.method.env_steps:
        raise UserError(f"{PROGRESS_FILE} is cut off: it ends after {last:,} of {cell.method.env_steps:,} env steps")
    return rows
