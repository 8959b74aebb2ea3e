"""The tables of a run fit each other: those of another run, evaluation or recipe are refused, each in one line."""

import shutil

import pandas as pd
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluation_missions
from lawn_sb3.experiment.run_directory.reading import (
    read_evaluation,
    read_paths,
    read_regrets,
    read_sampled,
    read_scaling,
    read_slots,
)
from tests.experiment.run_directory.conftest import FLOWN


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
        ("makespan_slots", 20.5, "scaling.csv line 3: makespan_slots = '20.5': must be a finite number"),
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
