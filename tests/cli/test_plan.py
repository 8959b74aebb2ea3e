"""The commands ``plan`` and ``ceiling``, and the regret that ``evaluate`` adds."""

import json
from pathlib import Path

import pandas as pd
import pytest

from lawn_sb3.experiment.registry import PLANNERS, REPOSITORY
from tests.cli.test_cli import lawn

EXPECTED = "method scenario episodes seed reward rate_mbps makespan_slots completion_slots success_percent"


@pytest.mark.parametrize("player", ["welfare", "bound"])
def test_plan_prints_one_json_object_and_nothing_else(player: str) -> None:
    done = lawn("plan", "--player", player, "--episodes", "5", "--seed", "1", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    figures = json.loads(done.stdout)
    assert {*EXPECTED.split(), "utility_mbps", "welfare_mbps"} <= set(figures)
    assert (figures["method"], figures["episodes"], figures["seed"]) == (player, 5, 1)


def test_a_mission_that_cannot_be_flown_in_time_names_the_uav() -> None:
    # From corner to corner of 10 x 10 x 3 voxels are 20 steps, 7 slots: among 400 missions some take more than 4.
    done = lawn("plan", "--player", "equilibrium", "--episodes", "100", "--set", "max_slots=4")
    assert done.returncode == 2
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert "UAV" in line
    assert "cannot fly its mission" in line
    assert "left of T_max = 4" in line


def test_rows_and_paths_are_written_where_asked(tmp_path: Path) -> None:
    done = lawn(
        "plan", "--player", "best-route", "--episodes", "5", "--rows", "rows.csv", "--paths", "paths.csv", cwd=tmp_path
    )
    assert done.returncode == 0
    rows, paths = (pd.read_csv(tmp_path / f"{name}.csv") for name in ("rows", "paths"))
    assert {"utility_mbps", "best_mbps", "best_slots"} <= set(rows.columns)
    assert len(paths) == (rows["slots"] + 1).sum()
    refused = lawn("plan", "--player", "best-route", "--rows", "nowhere/rows.csv", cwd=tmp_path)
    assert refused.returncode == 2
    assert refused.stderr == "lawn-sb3: 'nowhere/rows.csv' cannot be written: there is no folder 'nowhere'\n"


def test_a_misspelt_planner_gets_a_suggestion() -> None:
    done = lawn("plan", "--player", "equilibrum")
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert "did you mean 'equilibrium'" in line
    assert all(name in line for name in PLANNERS)


def test_evaluate_adds_the_regret() -> None:
    done = lawn("evaluate", "--player", "shortest-path", "--episodes", "5", "--regret", "--json")
    assert done.returncode == 0
    figures = json.loads(done.stdout)
    assert 0.0 < figures["regret_mbps"] <= figures["nash_gap_mbps"] <= figures["largest_regret_mbps"]
    refused = lawn("evaluate", "--player", "bound", "--episodes", "5", "--regret")
    assert refused.returncode == 2
    assert "never meet" in refused.stderr


def test_ceilings_are_printed_by_what_is_known_beside_what_players_earn() -> None:
    size = ["--set", "width_voxels=2", "--set", "length_voxels=2", "--set", "max_voxel_steps=1"]
    done = lawn("ceiling", *size, "--player", "shortest-path", "--player", "best-route", "--json")
    assert done.returncode == 0
    figures = json.loads(done.stdout)
    at_most = [bound for bound, _ in figures["ceilings"].values()]
    assert at_most == sorted(at_most)
    assert at_most[-1] == pytest.approx(figures["joint_optimum_mbps"], abs=1e-6)
    assert set(figures["earned"]) == {"shortest-path", "best-route"}
    for one in figures["earned"].values():
        assert one["late_percent"] == 0.0
        assert one["utility_mbps"] <= at_most[0] + 1e-9


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--scenario", "paper"], "num_uavs = 4: the ceiling is worked out for 2 UAVs"),
        (["--player", "forcast"], "did you mean 'forecast'"),
        (["--run", "nowhere"], "nowhere"),
        (["--run", "runs/reference/paper/mappo/seed-0"], "was trained on 'paper', not on 'tiny'"),
    ],
)
def test_a_ceiling_that_cannot_be_worked_out_is_refused_in_one_line(arguments: list[str], said: str) -> None:
    done = lawn("ceiling", *arguments, cwd=REPOSITORY)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert said in line
