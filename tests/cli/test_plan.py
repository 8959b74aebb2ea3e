"""The commands ``plan`` and ``ceiling``, and the regret that ``evaluate`` adds."""

import json
from pathlib import Path

import pandas as pd
import pytest

from tests.cli.running import Lawn

EXPECTED = "method scenario episodes seed reward rate_mbps makespan_slots completion_slots success_percent"


@pytest.mark.parametrize("player", ["welfare", "bound"])
def test_plan_prints_one_json_object_and_nothing_else(lawn: Lawn, player: str) -> None:
    out, err = lawn("plan", "--player", player, "--episodes", "5", "--seed", "1", "--json")
    assert err == ""
    figures = json.loads(out)
    assert {*EXPECTED.split(), "utility_mbps", "welfare_mbps"} <= set(figures)
    assert (figures["method"], figures["episodes"], figures["seed"]) == (player, 5, 1)


def test_rows_and_paths_are_written_where_asked(lawn: Lawn, tmp_path: Path) -> None:
    files = [tmp_path / "rows.csv", tmp_path / "paths.csv"]
    lawn("plan", "--player", "best-route", "--episodes", "5", "--rows", files[0], "--paths", files[1])
    rows, paths = map(pd.read_csv, files)
    assert {"utility_mbps", "best_mbps", "best_slots"} <= set(rows.columns)
    assert len(paths) == (rows["slots"] + 1).sum()


def test_evaluate_adds_the_regret(lawn: Lawn) -> None:
    figures = json.loads(lawn("evaluate", "--player", "shortest-path", "--episodes", "5", "--regret", "--json").out)
    assert 0.0 < figures["regret_mbps"] <= figures["nash_gap_mbps"] <= figures["largest_regret_mbps"]


def test_ceilings_are_printed_by_what_is_known_beside_what_players_earn(lawn: Lawn) -> None:
    size = ["--set", "width_voxels=2", "--set", "length_voxels=2", "--set", "max_voxel_steps=1"]
    figures = json.loads(lawn("ceiling", *size, "--player", "shortest-path", "--player", "best-route", "--json").out)
    at_most = [bound for bound, _ in figures["ceilings"].values()]
    assert at_most == sorted(at_most)
    assert at_most[-1] == pytest.approx(figures["joint_optimum_mbps"], abs=1e-6)
    assert set(figures["earned"]) == {"shortest-path", "best-route"}
    for one in figures["earned"].values():
        assert one["late_percent"] == 0.0
        assert one["utility_mbps"] <= at_most[0] + 1e-9
