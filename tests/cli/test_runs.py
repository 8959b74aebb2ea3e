"""Runs at hand: they are listed as they stand, compared on the same missions, and trained by seeds."""

import json
import os
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

from lawn_sb3.experiment.run_directory.files import CHECKPOINT_FILE, EVALUATION_FILE, FINISHED_FILE, LOCK_FILE
from lawn_sb3.results.statistics import crossed_t, paired_t
from tests.cli.running import QUICK, Lawn


def listed(lawn: Lawn, folder: Path) -> dict[str, dict[str, object]]:
    rows = json.loads(lawn("runs", folder, "--json").out)["runs"]
    return {Path(row["run"]).relative_to(folder).as_posix(): row for row in rows}


def test_runs_are_listed_with_what_came_out(lawn: Lawn, runs: Path) -> None:
    found = listed(lawn, runs / "small")
    assert len(found) == 8  # four methods, two seeds
    row, rows = found["mappo/seed-1"], pd.read_csv(runs / "small" / "mappo" / "seed-1" / EVALUATION_FILE)
    assert (row["method"], row["flown_by"], row["game"]) == ("mappo", "mappo, centralized_critic", "paper")
    assert (row["seed"], row["state"]) == (1, "finished")
    assert row["utility_mbps"] == pytest.approx(rows["utility_mbps"].mean())
    assert row["success_percent"] == pytest.approx(100.0 * rows["arrived"].mean())
    shown = lawn("runs", runs / "small").out
    assert "8 runs in" in shown
    assert "│ mappo/seed-1 " in shown
    assert "no runs in" in lawn("runs", runs / "small" / "mappo" / "seed-1" / "tensorboard").err


def test_a_run_is_listed_as_far_as_it_is(lawn: Lawn, runs: Path) -> None:
    run = runs / "small" / "random"
    (run / "seed-0" / FINISHED_FILE).unlink()
    (run / "seed-1" / FINISHED_FILE).write_text("0123456789abcdef\n")
    states = {name: row["state"] for name, row in listed(lawn, run).items()}
    assert states == {"seed-0": "begun", "seed-1": "finished, but its policy or the version has changed since"}
    (run / "seed-0" / CHECKPOINT_FILE).touch()
    (run / "seed-1" / LOCK_FILE).write_text('{"host": "elsewhere", "pid": 1, "since": "now"}')
    states = {name: row["state"] for name, row in listed(lawn, run).items()}
    assert states == {"seed-0": "interrupted", "seed-1": "running"}
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    holder = {"host": socket.gethostname(), "pid": ended.pid, "since": "now"}
    (run / "seed-0" / LOCK_FILE).write_text(json.dumps(holder))
    (run / "seed-1" / LOCK_FILE).write_text(json.dumps(holder | {"pid": os.getpid()}))
    states = {name: row["state"] for name, row in listed(lawn, run).items()}
    assert states == {"seed-0": "interrupted", "seed-1": "running"}  # whoever held the first has ended
    (run / "seed-0" / "config.yaml").write_text("seed: [")
    assert "is not the configuration of a run" in str(listed(lawn, run)["seed-0"]["state"])


def test_methods_with_several_seeds_are_compared_over_seeds_and_missions(
    lawn: Lawn, runs: Path, tmp_path: Path
) -> None:
    folders = [runs / "small" / name for name in ("random", "mappo", "equilibrium")]
    said = json.loads(lawn("compare", *folders, "--figure", tmp_path / "one.png", "--json").out)
    assert [row["key"] for row in said["rows"]] == ["random", "mappo", "equilibrium"]
    assert "t over seeds and missions" in said["caption"]
    scores = [utilities(folder) for folder in folders]
    for row, own in zip(said["rows"][1:], scores[1:], strict=True):
        value, low, high = crossed_t(own, scores[0]).interval
        given = [row[f"utility_mbps_difference{end}"] for end in ("", "_low", "_high")]
        assert given == pytest.approx([value, low, high], abs=1e-6)
    assert (tmp_path / "one.png").stat().st_size > 1000
    assert "J̄" in lawn("compare", *folders[:2]).out


def test_single_runs_are_compared_over_missions_in_pairs(lawn: Lawn, runs: Path) -> None:
    folders = [runs / "small" / name / "seed-0" for name in ("random", "equilibrium")]
    said = json.loads(lawn("compare", *folders, "--json").out)
    first, other = (utilities(folder.parent)[0] for folder in folders)
    value, low, high = paired_t(other, first)
    row = said["rows"][1]
    given = [row[f"utility_mbps_difference{end}"] for end in ("", "_low", "_high")]
    assert given == pytest.approx([value, low, high], abs=1e-6)
    assert "says nothing of other seeds" in said["caption"]


def utilities(folder: Path) -> list[list[float]]:
    """Mean utilities of the episodes, by seed."""
    tables = [pd.read_csv(path) for path in sorted(folder.glob(f"seed-*/{EVALUATION_FILE}"))]
    return [rows.groupby("episode")["utility_mbps"].mean().tolist() for rows in tables]


def test_runs_of_other_missions_or_methods_are_not_compared(lawn: Lawn, runs: Path, tmp_path: Path) -> None:
    own = runs / "small" / "random" / "seed-0"
    other = tmp_path / "other"
    lawn("train", "--out", other, "--env-steps", 64, "--num-games", 2, *QUICK, "--no-progress")
    said = lawn("compare", own, other, status=2).err
    assert "has flown other missions than" in said
    shutil.copytree(own, runs / "small" / "mappo" / "seed-9")
    assert "holds runs of several methods" in lawn("compare", own, runs / "small" / "mappo", status=2).err
    assert "holds two runs of the same seed" in lawn("compare", own, twice(runs), status=2).err


def twice(runs: Path) -> Path:
    shutil.copytree(runs / "small" / "random" / "seed-0", runs / "small" / "random" / "seed-0-again")
    return runs / "small" / "random"


@pytest.mark.slow
def test_seeds_are_trained_side_by_side_as_alone(lawn: Lawn, tmp_path: Path) -> None:
    short = ["--env-steps", 64, "--num-games", 2, *QUICK]
    said = lawn("train", "--out", tmp_path / "many", "--seeds", "3,5", "--jobs", 2, *short)
    assert "2 runs in" in said.out
    lawn("train", "--out", tmp_path / "alone", "--seed", 5, *short, "--no-progress")
    for name in (EVALUATION_FILE, "progress.csv", "model.zip"):
        assert (tmp_path / "many" / "seed-5" / name).read_bytes() == (tmp_path / "alone" / name).read_bytes(), name
    assert "2 of 2 runs are finished already" in lawn("train", "--out", tmp_path / "many", "--seeds", "3,5", *short).err
    assert {path.name for path in (tmp_path / "many").iterdir()} == {"seed-3", "seed-5"}
