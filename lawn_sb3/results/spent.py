"""What runs cost: the time that they say it took."""

import json
from collections.abc import Sequence

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.run_directory.configuration import is_finished
from lawn_sb3.experiment.run_directory.files import PROVENANCE_FILE


def time_spent(cells: Sequence[Cell]) -> str:
    """Say how long training and evaluation of the finished runs took, and on what.

    :param cells: the cells
    :return: a sentence; empty if no run says
    """
    seconds, processors = [], set()
    for cell in cells:
        if is_finished(cell):
            try:
                record = json.loads((cell.directory / PROVENANCE_FILE).read_text(encoding="utf-8"))
                seconds.append(float(record["train_seconds"]) + float(record["evaluate_seconds"]))
                processors.add(str(record["hardware"]["processor"]))
            except (OSError, ValueError, KeyError, TypeError):  # it has none, or one that says less
                continue
    if not seconds:
        return ""
    minutes = sum(seconds) / 60.0
    which = f"all {len(cells)}" if len(seconds) == len(cells) else f"{len(seconds)} of the {len(cells)}"
    return (
        f"Training and evaluating {which} runs took {minutes:,.1f} minutes in all, each on "
        f"one core of {' or '.join(sorted(processors))}."
    )
