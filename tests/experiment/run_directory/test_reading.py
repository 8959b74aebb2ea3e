"""The tables of a run, each by itself: every kind of damage is named in one line, and nothing damaged comes through."""

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.run_directory.progress import read_progress
from lawn_sb3.experiment.run_directory.reading import (
    read_evaluation,
    read_paths,
    read_regrets,
    read_sampled,
    read_scaling,
    read_slots,
)
from tests.experiment.run_directory.conftest import FLOWN

READERS: dict[str, Callable[[Cell], pd.DataFrame]] = {
    "evaluation.csv": read_evaluation,
    "evaluation_sampled.csv": lambda cell: read_sampled(cell, read_evaluation(cell)),
    "slots.csv": lambda cell: read_slots(cell, read_evaluation(cell)),
    "paths.csv": lambda cell: read_paths(cell, read_evaluation(cell)),
    "progress.csv": read_progress,
    "regret.csv": lambda cell: read_regrets(cell, read_evaluation(cell)),
    "scaling.csv": lambda cell: read_scaling(cell, FLOWN),
}


def remove(path: Path) -> None:
    path.unlink()


def empty(path: Path) -> None:
    path.write_text("", encoding="utf-8")


def cut_inside_the_last_number(path: Path) -> None:
    content = path.read_text(encoding="utf-8").rstrip("\n")
    path.write_text(content[:-1], encoding="utf-8")


def cut_the_last_line(path: Path) -> None:
    path.write_text("".join(path.read_text(encoding="utf-8").splitlines(keepends=True)[:-1]), encoding="utf-8")


def fill_with_garbage(path: Path) -> None:
    path.write_bytes(bytes(range(255, -1, -1)))


def replace_by_another_table(path: Path) -> None:
    path.write_text("city,people\nBath,94000\n", encoding="utf-8")


def replace_by_a_directory(path: Path) -> None:
    path.unlink()
    path.mkdir()


DAMAGES: dict[Callable[[Path], None], str] = {
    remove: "cannot be read: No such file",
    empty: "cannot be read: it is empty",
    cut_inside_the_last_number: "is cut off: line",
    cut_the_last_line: "is cut off:",
    fill_with_garbage: "cannot be read: it is no text",
    replace_by_another_table: "lacks the columns",
    replace_by_a_directory: "cannot be read: Is a directory",
}


@pytest.mark.parametrize("damage", DAMAGES, ids=lambda damage: damage.__name__)
@pytest.mark.parametrize("name", READERS)
def test_a_damaged_file_is_named(scaled: Cell, name: str, damage: Callable[[Path], None]) -> None:
    assert len(READERS[name](scaled))
    damage(scaled.directory / name)
    with pytest.raises(UserError, match=f"^{name} {DAMAGES[damage]}") as refusal:
        READERS[name](scaled)
    assert "\n" not in str(refusal.value)


def test_an_evaluation_from_before_the_cell_loads_is_named_so(damaged: Cell) -> None:
    path = damaged.directory / "evaluation.csv"
    pd.read_csv(path).drop(columns="mean_cell_load").to_csv(path, index=False)
    with pytest.raises(UserError, match=r"evaluation.csv lacks the columns mean_cell_load$"):
        read_evaluation(damaged)


@pytest.mark.parametrize(
    ("column", "value", "allowed"),
    [
        ("slots", -3, "a whole number from 1 to 20"),  # T_max of the small recipe
        ("slots", 2.5, "a whole number from 1 to 20"),
        ("episode", 6, "a whole number from 0 to 5"),  # 6 test episodes
        ("uav", 4, "a whole number from 0 to 3"),
        ("rate_mbps", -1, "a finite number of at least 0"),
        ("reward", "", "a finite number"),
        ("utility_mbps", "inf", "a finite number of at least 0"),
        ("arrived", "yes", "True or False"),
        ("mean_cell_load", 0.5, "a finite number from 1 to 4"),
        ("min_slots", 24, "a whole number from 1 to 23"),  # no two voxels of 10 x 10 x 3 are 24 steps apart
    ],
)
def test_values_out_of_range_are_named_with_their_line(damaged: Cell, column: str, value: object, allowed: str) -> None:
    path = damaged.directory / "evaluation.csv"
    rows = pd.read_csv(path, dtype=str)
    rows.loc[3, column] = str(value)  # the heading is line 1
    rows.to_csv(path, index=False)
    with pytest.raises(UserError, match=f"^evaluation.csv line 5: {column} = '{value}': must be {allowed}$"):
        read_evaluation(damaged)


def test_an_episode_and_uav_that_are_there_twice_are_named(damaged: Cell) -> None:
    path = damaged.directory / "evaluation.csv"
    rows = pd.read_csv(path)
    rows.iloc[7] = rows.iloc[2]  # the right number of rows, but episode 1, UAV 3 is missing
    rows.to_csv(path, index=False)
    with pytest.raises(UserError, match=r"evaluation.csv line 9 repeats episode 0, uav 2: must be there once"):
        read_evaluation(damaged)


def test_shuffled_rows_are_put_in_order(damaged: Cell) -> None:
    ordered = read_evaluation(damaged)
    for name in ("evaluation.csv", "slots.csv", "paths.csv"):
        path = damaged.directory / name
        pd.read_csv(path).iloc[::-1].to_csv(path, index=False)
    pd.testing.assert_frame_equal(read_evaluation(damaged), ordered)
    assert read_slots(damaged, ordered)["slot"].is_monotonic_increasing
    read_paths(damaged, ordered)


def test_a_curve_must_reach_the_training_budget(damaged: Cell) -> None:
    # 2 games of 32 slots a rollout, and a record after each: 64, 128 and 192 of 192 env steps.
    path = damaged.directory / "progress.csv"
    assert read_progress(damaged)["time/env_steps"].tolist() == [64, 128, 192]
    lines = path.read_text().splitlines(keepends=True)
    for kept, last in ((3, 128), (2, 64), (1, 0)):
        path.write_text("".join(lines[:kept]))
        with pytest.raises(UserError, match=f"progress.csv is cut off: it ends after {last} of 192 env steps"):
            read_progress(damaged)


def test_a_curve_may_have_gaps_but_only_numbers(damaged: Cell) -> None:
    path = damaged.directory / "progress.csv"
    rows = pd.read_csv(path)
    rows.assign(**{"missions/reward": float("nan")}).to_csv(path, index=False)
    assert read_progress(damaged)["missions/reward"].isna().all()
    rows.assign(**{"missions/reward": "good"}).to_csv(path, index=False)
    with pytest.raises(UserError, match=r"progress.csv line 2: missions/reward = 'good': must be a finite number"):
        read_progress(damaged)
