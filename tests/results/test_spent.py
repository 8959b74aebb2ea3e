"""What runs cost is the sum of what they say."""

import json
from pathlib import Path

import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.run_directory.files import PROVENANCE_FILE
from lawn_sb3.results.spent import time_spent


def test_the_time_of_all_runs_is_told_and_how_many_say(small_cells: list[Cell]) -> None:
    for cell in small_cells:
        record = {"train_seconds": 84.0, "evaluate_seconds": 6.0, "hardware": {"processor": "A processor"}}
        (cell.directory / PROVENANCE_FILE).write_text(json.dumps(record), encoding="utf-8")
    assert time_spent(small_cells) == (
        "Training and evaluating all 4 runs took 6.0 minutes in all, each on one core of A processor."
    )
    (small_cells[0].directory / PROVENANCE_FILE).unlink()
    assert "evaluating 3 of the 4 runs took 4.5 minutes" in time_spent(small_cells)


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"train_seconds": 1}'])
def test_runs_that_do_not_say_are_not_counted(small_cells: list[Cell], text: str) -> None:
    for cell in small_cells:
        path: Path = cell.directory / PROVENANCE_FILE
        path.write_text(text, encoding="utf-8")
    assert time_spent(small_cells) == ""
