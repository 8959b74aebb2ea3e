"""``progress.csv`` and ``tensorboard/``: the training curve, one row per record, written while a method trains.

``time/env_steps`` counts the joint slots of all games. ``missions/...`` are means of the training missions that ended
since the last record, ``greedy/...`` of greedy play on missions of their own, ``train/...`` and ``rollout/...`` what
Stable-Baselines3 records. All but the first may have gaps.
"""

import csv
import shutil
import threading
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from stable_baselines3.common.logger import KVWriter, TensorBoardOutputFormat

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.run_directory.csv_file import checked, number, read_texts, whole
from lawn_sb3.experiment.run_directory.files import PROGRESS_FILE
from lawn_sb3.whole_files import named

STEPS = "time/env_steps"
NOT_REPEATABLE = {"time/fps", "time/time_elapsed", "time/iterations"}
"""What Stable-Baselines3 records that differs between equal trainings of which one was interrupted and resumed."""


class ProgressCSV(KVWriter):
    """Writes the curve with sorted columns and no wall-clock time: equal runs, equal bytes.

    :param path: the file
    :param before: its content up to the checkpoint that the training resumes from
    """

    def __init__(self, path: Path, before: str = "") -> None:
        self.path = path
        self.rows: list[dict[str, str]] = list(csv.DictReader(before.splitlines()))
        self.columns = list(self.rows[0]) if self.rows else []
        with named(path):
            path.write_text(before, encoding="utf-8")

    def write(self, key_values: dict[str, Any], key_excluded: dict[str, tuple[str, ...]], step: int = 0) -> None:
        """Append one row.

        :param key_values: names and values
        :param key_excluded: formats that leave a name out
        :param step: agent steps so far
        """
        row = {key: str(value) for key, value in key_values.items() if key not in NOT_REPEATABLE}
        self.rows.append(row)
        new = sorted(set(row) - set(self.columns))
        self.columns += new
        with named(self.path), self.path.open("w" if new else "a", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, self.columns, restval="", lineterminator="\n")
            if new:  # rows written before lack the new columns
                table.writeheader()
            table.writerows(self.rows if new else [row])

    def close(self) -> None:
        """Nothing is kept open."""


class TensorBoardCurve(TensorBoardOutputFormat):
    """The same curve for TensorBoard, against env steps; a resumed training begins it anew, with the rows so far.

    :param folder: the folder of event files
    :param before: rows of ``progress.csv`` up to the checkpoint that the training resumes from
    """

    def __init__(self, folder: Path, before: Sequence[Mapping[str, str]] = ()) -> None:
        shutil.rmtree(folder, ignore_errors=True)  # else rows that came after the checkpoint would be there twice
        self.folder = folder
        if not isinstance(threading.excepthook, _AllButTensorBoard):
            threading.excepthook = _AllButTensorBoard(threading.excepthook)
        with named(folder):
            super().__init__(str(folder))
        for row in before:
            self.write({key: float(text) for key, text in row.items() if text}, {})

    def write(self, key_values: dict[str, Any], key_excluded: dict[str, tuple[str, ...]], step: int = 0) -> None:
        """Add one point to each curve.

        :param key_values: names and values, with the env steps so far
        :param key_excluded: unused: all of ``progress.csv`` is shown
        :param step: agent steps so far, unused: the axis is env steps
        """
        shown = {key: value for key, value in key_values.items() if key not in NOT_REPEATABLE}
        with named(self.folder):
            super().write(shown, dict.fromkeys(shown, ()), int(key_values[STEPS]))

    def close(self) -> None:
        """Close the event file."""
        with named(self.folder):
            super().close()


class _AllButTensorBoard:
    """Tells of what a thread ended by, but for the one that writes events: the next write raises its error again.

    :param tell: who is told of the others
    """

    def __init__(self, tell: Callable[[threading.ExceptHookArgs], object]) -> None:
        self.tell = tell

    def __call__(self, failure: threading.ExceptHookArgs) -> None:
        if not type(failure.thread).__module__.startswith("tensorboard."):
            self.tell(failure)


def read_progress(cell: Cell) -> pd.DataFrame:
    """Read a training curve.

    :param cell: the cell of the run
    :return: one row per record
    :raises UserError: if the file is not whole, or ends before the training did
    """
    texts = read_texts(cell.directory / PROGRESS_FILE, [STEPS])
    columns = {str(name): number("", gaps=True) for name in texts}
    columns[STEPS] = whole("joint slots played so far, over all games", "slots", 1)
    rows = checked(texts, columns, PROGRESS_FILE)
    steps, last = rows[STEPS].to_numpy(), 0
    gap = budget = cell.method.env_steps
    if len(steps):  # the first record comes after the first rollout, the next ones after whole rollouts
        last, gap = int(steps[-1]), -(-cell.evaluation.record_every // int(steps[0])) * int(steps[0])
    if last + gap <= budget:
        raise UserError(f"{PROGRESS_FILE} is cut off: it ends after {last:,} of {budget:,} env steps")
    return rows
