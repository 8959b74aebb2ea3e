"""The page about run directories names every file and every column that there is."""

import re

import pytest

from lawn_sb3.experiment.run_directory import files
from lawn_sb3.experiment.run_directory.columns import (
    costs_columns,
    evaluation_columns,
    paths_columns,
    regret_columns,
    scaling_columns,
    slots_columns,
)
from lawn_sb3.experiment.run_directory.csv_file import Columns
from lawn_sb3.paper.checks.checks import CHECKS, Check
from lawn_sb3.scenario import PRESETS
from tests.docs.pages import PAGES
from tests.handmade import recipe_of

PAGE = PAGES["docs/run-directory.md"]
GAME = PRESETS["tiny"].changed(gbs_grid=(2, 1), rbs_per_gbs=2)


def test_every_file_is_there() -> None:
    names = {value for name, value in vars(files).items() if name.endswith(("_FILE", "_FOLDER"))}
    names |= {f"{check.name}.csv" for check in CHECKS}
    named = set(re.findall(r"`([\w.]+)/?`", PAGE))
    assert names <= named
    assert {name for name in named if name.endswith((".csv", ".json", ".zip", ".npz", ".pt", ".safetensors"))} <= names


@pytest.mark.parametrize(
    ("name", "columns"),
    [
        (files.EVALUATION_FILE, evaluation_columns(GAME, 1)),
        (files.SLOTS_FILE, slots_columns(GAME, 1)),
        (files.PATHS_FILE, paths_columns(GAME, 1)),
        (files.REGRET_FILE, regret_columns(GAME, 1)),
        (files.SCALING_FILE, scaling_columns(GAME)),
        (files.COSTS_FILE, costs_columns()),
    ],
)
def test_every_column_is_there(name: str, columns: Columns) -> None:
    (own,) = (part for part in re.split(r"\n\n(?=`\w+\.csv`)", PAGE) if part.startswith(f"`{name}`"))
    assert set(columns) - set(re.findall(r"`(\w+)`", own)) == set()


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.name)
def test_every_column_of_a_check_is_there(check: Check) -> None:
    (row,) = re.findall(rf"\| `{check.name}\.csv` \|(.*)", PAGE)
    columns, named_above = set(check.columns(recipe_of(2, ("random",)), [])), set(evaluation_columns(GAME, 1))
    own = columns - named_above if columns >= named_above else columns
    assert own <= set(re.findall(r"`(\w+)`", row))
    assert ("as in `evaluation.csv`" in row) == (columns >= named_above)
