"""Checking a finished run: its model flies the test missions again, and the rows have to come out the same."""

from collections.abc import Collection
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from lawn_sb3.errors import UserError, first_line
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.run_directory.configuration import load_finished_run
from lawn_sb3.experiment.run_directory.csv_file import rows_as_text
from lawn_sb3.experiment.run_directory.files import EVALUATION_FILE, MODEL_FILE, WEIGHTS_FILE
from lawn_sb3.experiment.run_directory.manifest import check_unaltered
from lawn_sb3.experiment.weights import are_rounded

FEW = 0.01
"""Share of the rows that rounding the weights may change."""


class Verification(NamedTuple):
    """What flying again gave."""

    rows: int
    """Rows of the evaluation, one per episode and UAV."""
    rows_that_differ: int
    reward: float
    """Mean accumulated reward that the run left."""
    reward_again: float
    """The same, flown again."""
    rounded_weights: bool
    """Whether the model was kept in half precision, so that a few near ties may be decided otherwise."""

    @property
    def passed(self) -> bool:
        """Whether the run holds: every row the same, or all but a few where weights were rounded."""
        return self.rows_that_differ <= (FEW * self.rows if self.rounded_weights else 0)


def verify_run(directory: Path, trusted: Collection[str] = ()) -> Verification:
    """Fly the test missions of a finished run again.

    :param directory: the run
    :param trusted: policies that it may name though they do not come with the kit
    :return: how many rows differ
    :raises UserError: if the run is not finished or not as it was left, or its model or rows are missing or damaged
    """
    cell = load_finished_run(directory, trusted)
    check_unaltered(directory)
    chosen, path = cell.evaluation, directory / EVALUATION_FILE
    player = load_player(cell, deterministic=chosen.deterministic)
    again = evaluate(player, cell.scenario, chosen.episodes, chosen.seed, cell.seed)
    try:
        left = path.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError) as error:
        raise UserError(f"{str(path)!r} cannot be read: {first_line(error)}") from None
    flown = rows_as_text(again).splitlines()
    if len(left) != len(flown) or left[0] != flown[0]:
        raise UserError(f"{str(path)!r} has other rows or columns than an evaluation of this run")
    reward = float(pd.to_numeric(pd.read_csv(path)["reward"], errors="coerce").mean())
    differ = sum(one != other for one, other in zip(left, flown, strict=True))
    kept_weights = cell.method.algo is not None and not (directory / MODEL_FILE).exists()
    rounded = kept_weights and are_rounded(directory / WEIGHTS_FILE)
    return Verification(len(again), differ, reward, float(again["reward"].mean()), rounded)
