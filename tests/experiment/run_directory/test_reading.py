"""The tables of a run: damage, and tables of another run or recipe, are named in one line, and none comes through."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluation_missions
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
        ("slots", -3, "a whole number from 1 to 100"),  # T_max of the small recipe
        ("slots", 2.5, "a whole number from 1 to 100"),
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


def test_slots_and_paths_of_another_run_are_refused(small_cells: list[Cell]) -> None:
    random, mappo = (next(cell for cell in small_cells if cell.key == key) for key in ("random", "mappo"))
    for name, read in (("slots.csv", read_slots), ("paths.csv", read_paths)):
        shutil.copy(random.directory / name, mappo.directory / name)
        with pytest.raises(UserError, match=f"^{name}"):
            read(mappo, read_evaluation(mappo))


def test_slots_must_add_up_to_the_uavs_that_fly(damaged: Cell) -> None:
    path = damaged.directory / "slots.csv"
    rows = pd.read_csv(path)
    rows["gbs_1"] += [0.5, *[0.0] * (len(rows) - 1)]
    rows.to_csv(path, index=False)
    expected = r"slots.csv: 4.5 UAVs fly in slot 1 by gbs_0 to gbs_3: must be 4 as in evaluation.csv"
    with pytest.raises(UserError, match=expected):
        read_slots(damaged, read_evaluation(damaged))


def test_a_path_must_end_when_its_mission_does(damaged: Cell) -> None:
    evaluation = read_evaluation(damaged)
    slots = evaluation["slots"].copy()
    slots[0], slots[1] = slots[0] - 1, slots[1] + 1  # the same number of rows, one slot at another UAV
    expected = f"paths.csv: UAV 0 of episode 0 flies in slot {slots[0] + 1}: must end after the {slots[0]} slots"
    with pytest.raises(UserError, match=expected):
        read_paths(damaged, evaluation.assign(slots=slots))


def test_paths_must_begin_at_the_test_missions_origins(damaged: Cell) -> None:
    path = damaged.directory / "paths.csv"
    rows = pd.read_csv(path)
    at_origin = (rows["episode"] == 0) & (rows["slot"] == 0)
    assert (
        rows.loc[at_origin, list("xyz")].to_numpy() == evaluation_missions(damaged.scenario, 6, 20_000).origins[0]
    ).all()
    rows.loc[at_origin, "x"] = 9 - rows.loc[at_origin, "x"]
    rows.to_csv(path, index=False)
    with pytest.raises(UserError, match=r"paths.csv has other origins than the test missions of seed 20000"):
        read_paths(damaged, read_evaluation(damaged))


def test_sampled_play_must_have_flown_the_same_missions(damaged: Cell) -> None:
    evaluation = read_evaluation(damaged)
    other = evaluation.assign(min_slots=evaluation["min_slots"] + 1)
    with pytest.raises(UserError, match=r"evaluation_sampled.csv has other missions than evaluation.csv"):
        read_sampled(damaged, other)


def test_regrets_must_be_of_the_same_utilities(damaged: Cell) -> None:
    evaluation, path = read_evaluation(damaged), damaged.directory / "regret.csv"
    rows = pd.read_csv(path).astype({"utility_mbps": float})
    assert (rows["utility_mbps"] == evaluation["utility_mbps"]).all()
    rows.loc[5, "utility_mbps"] = evaluation["utility_mbps"][5] + 1e-7  # rounding of the ninth digit
    rows.iloc[::-1].to_csv(path, index=False)
    assert read_regrets(damaged, evaluation)["uav"].tolist() == evaluation["uav"].tolist()  # whatever their order
    rows.loc[5, "utility_mbps"] = 99.5
    rows.to_csv(path, index=False)
    had = f"{evaluation['utility_mbps'][5]:g}"
    expected = f"regret.csv: UAV 1 of episode 1 had 99.5 Mbps: must be {had} as in evaluation.csv"
    with pytest.raises(UserError, match=expected):
        read_regrets(damaged, evaluation)


def test_a_best_response_is_worth_no_less_than_a_flight_without_collision(damaged: Cell) -> None:
    evaluation, path = read_evaluation(damaged), damaged.directory / "regret.csv"
    evaluation = evaluation.assign(utility_mbps=20.0, collisions=0)
    rows = pd.read_csv(path).assign(utility_mbps=20.0, best_mbps=21.0)
    rows.loc[5, "best_mbps"] = 0.5
    rows.to_csv(path, index=False)
    with pytest.raises(UserError, match=r"UAV 1 of episode 1 had 20 Mbps without a collision: .* cannot be worth 0\.5"):
        read_regrets(damaged, evaluation)
    evaluation.loc[5, "collisions"] = 1  # the best response avoids it
    assert read_regrets(damaged, evaluation)["best_mbps"][5] == 0.5


@pytest.mark.parametrize(
    ("column", "value", "expected"),
    [
        ("num_uavs", 8, "scaling.csv is of 1, 8 UAVs: must be 1, 3"),
        ("num_uavs", 1, "scaling.csv line 3 repeats num_uavs 1: must be there once"),
        ("episodes", 50, "scaling.csv is of 2, 50 episodes: must be 2"),
        ("success_percent", 101.5, "scaling.csv line 3: success_percent = '101.5': must be a finite number"),
        ("makespan_slots", 100.5, "scaling.csv line 3: makespan_slots = '100.5': must be a finite number"),
        ("welfare_mbps", 999, "scaling.csv line 3: welfare_mbps = 999: must be num_uavs times utility_mbps"),
    ],
)
def test_flights_with_other_numbers_of_uavs_are_those_of_the_recipe(
    scaled: Cell, column: str, value: float, expected: str
) -> None:
    path = scaled.directory / "scaling.csv"
    rows = pd.read_csv(path)
    rows.assign(**{column: [rows[column][0], value]}).to_csv(path, index=False)
    with pytest.raises(UserError, match=f"^{expected}"):
        read_scaling(scaled, FLOWN)
