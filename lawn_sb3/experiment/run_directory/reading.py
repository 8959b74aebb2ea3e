"""Reading back the tables of a finished run: each must be whole, and fit the run's other files.

All functions take the ``cell`` of the run, and those of tables that must fit its ``evaluation`` what
:func:`read_evaluation` returned. They give the rows in the order of their keys, and raise a UserError if the file is
not whole, or belongs to something else.
"""

from collections.abc import Iterable

import numpy as np
import pandas as pd

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluation_missions
from lawn_sb3.experiment.recipe import Scaling
from lawn_sb3.experiment.run_directory.columns import (
    EPISODE_KEY,
    PATH_KEY,
    costs_columns,
    evaluation_columns,
    paths_columns,
    regret_columns,
    scaling_columns,
    slots_columns,
)
from lawn_sb3.experiment.run_directory.csv_file import Columns, read_table
from lawn_sb3.experiment.run_directory.files import (
    COSTS_FILE,
    EVALUATION_FILE,
    PATHS_FILE,
    REGRET_FILE,
    SAMPLED_FILE,
    SCALING_FILE,
    SLOTS_FILE,
)

TOLERANCE = 1e-6
"""Files keep nine digits."""


def read_evaluation(cell: Cell, name: str = EVALUATION_FILE) -> pd.DataFrame:
    """Read the raw rows of an evaluation, from the file of that ``name``: one per episode and UAV."""
    game, episodes = cell.scenario, cell.evaluation.episodes
    columns = evaluation_columns(game, episodes)
    rows = read_table(cell.directory / name, columns, episodes * game.num_uavs, EPISODE_KEY)
    return rows.sort_values(EPISODE_KEY, ignore_index=True)


def read_sampled(cell: Cell, evaluation: pd.DataFrame) -> pd.DataFrame:
    """Read the raw rows of the test missions flown with sampled actions, like those of the evaluation."""
    rows = read_evaluation(cell, SAMPLED_FILE)
    if (rows["min_slots"] != evaluation["min_slots"]).any():
        raise UserError(f"{SAMPLED_FILE} has other missions than {EVALUATION_FILE}: min_slots must be the same in both")
    return rows


def read_slots(cell: Cell, evaluation: pd.DataFrame) -> pd.DataFrame:
    """Read how many UAVs flew where: one row per slot."""
    last = int(evaluation["slots"].max())
    columns = slots_columns(cell.scenario, last)
    rows = read_table(cell.directory / SLOTS_FILE, columns, last, ["slot"]).sort_values("slot", ignore_index=True)
    flying = (evaluation["slots"].to_numpy() >= rows["slot"].to_numpy()[:, None]).sum(axis=1)
    expected = flying / cell.evaluation.episodes
    for kind in ("gbs_", "load_"):
        names = [name for name in columns if name.startswith(kind)]
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
    """Read where the UAVs of the first episodes flew: one row per slot and UAV of each traced episode."""
    game, chosen = cell.scenario, cell.evaluation
    traced = min(chosen.traced_episodes, chosen.episodes)
    flown = evaluation.loc[evaluation["episode"] < traced, [*EPISODE_KEY, "slots"]]
    columns, num_rows = paths_columns(game, traced), int((flown["slots"] + 1).sum())
    rows = read_table(cell.directory / PATHS_FILE, columns, num_rows, PATH_KEY)
    late = rows.merge(flown, on=EPISODE_KEY).query("slot > slots")
    if len(late):
        first = late.iloc[0]
        raise UserError(
            f"{PATHS_FILE}: UAV {first['uav']:g} of episode {first['episode']:g} flies in slot {first['slot']:g}: "
            f"must end after the {first['slots']:g} slots of {EVALUATION_FILE}"
        )
    rows = rows.sort_values(PATH_KEY, ignore_index=True)
    origins = evaluation_missions(game, chosen.episodes, chosen.seed).origins[:traced].reshape(-1, 3)
    if (rows.loc[rows["slot"] == 0, list("xyz")].to_numpy() != origins).any():
        raise UserError(f"{PATHS_FILE} has other origins than the test missions of seed {chosen.seed}")
    return rows


def read_regrets(cell: Cell, evaluation: pd.DataFrame) -> pd.DataFrame:
    """Read what each UAV could have had by deviating alone: one row per episode and UAV."""
    game, episodes = cell.scenario, cell.evaluation.episodes
    columns = regret_columns(game, episodes)
    rows = read_table(cell.directory / REGRET_FILE, columns, episodes * game.num_uavs, EPISODE_KEY)
    rows = rows.sort_values(EPISODE_KEY, ignore_index=True)
    had, best = evaluation["utility_mbps"], rows["best_mbps"]
    differs = (rows["utility_mbps"] - had).abs() > TOLERANCE
    too_low = (best < had - TOLERANCE) & (evaluation["collisions"] == 0)
    wrong = (differs | too_low).to_numpy()
    if wrong.any():
        at = int(wrong.argmax())
        first = rows.iloc[at]
        what = f"UAV {first['uav']:g} of episode {first['episode']:g} had {first['utility_mbps']:g} Mbps"
        if differs[at]:
            raise UserError(f"{REGRET_FILE}: {what}: must be {had[at]:g} as in {EVALUATION_FILE}")
        raise UserError(f"{REGRET_FILE}: {what} without a collision: its best response cannot be worth {best[at]:g}")
    return rows


def read_scaling(cell: Cell, scaling: Scaling) -> pd.DataFrame:
    """Read what a player did among other numbers of UAVs, as the recipe asks by ``scaling``: one row for each."""
    rows, asked = _by_num_uavs(cell, scaling, SCALING_FILE, scaling_columns(cell.scenario)), scaling.flown_by(cell.key)
    if dict(zip(rows["num_uavs"], rows["episodes"], strict=True)) != asked:
        flown, must = (_listed(sorted(set(counts))) for counts in (rows["episodes"], asked.values()))
        raise UserError(f"{SCALING_FILE} is of {flown} episodes: must be {must}")
    welfare = rows["utility_mbps"] * rows["num_uavs"]
    wrong = (np.abs(rows["welfare_mbps"] - welfare) > TOLERANCE * (1.0 + welfare)).to_numpy()
    if wrong.any():
        at = int(wrong.argmax())
        raise UserError(
            f"{SCALING_FILE} line {at + 2}: welfare_mbps = {rows['welfare_mbps'].iloc[at]:g}: must be num_uavs times "
            f"utility_mbps, {welfare.iloc[at]:g}"
        )
    return rows.sort_values("num_uavs", ignore_index=True)


def read_costs(cell: Cell, scaling: Scaling) -> pd.DataFrame:
    """Read what a player's decisions cost among other numbers of UAVs: one row for each."""
    return _by_num_uavs(cell, scaling, COSTS_FILE, costs_columns()).sort_values("num_uavs", ignore_index=True)


def _by_num_uavs(cell: Cell, scaling: Scaling, name: str, columns: Columns) -> pd.DataFrame:
    """The rows of a table that has one for each number of UAVs that the recipe asks for."""
    asked = scaling.flown_by(cell.key)
    rows = read_table(cell.directory / name, columns, len(asked), ["num_uavs"])
    if sorted(rows["num_uavs"]) != sorted(asked):
        raise UserError(f"{name} is of {_listed(rows['num_uavs'])} UAVs: must be {_listed(asked)}")
    return rows


def _listed(numbers: Iterable[int]) -> str:
    return ", ".join(map(str, numbers))
