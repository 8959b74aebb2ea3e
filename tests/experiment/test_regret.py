"""Regret of finished runs: what each UAV could have gained alone, worked out once and kept beside the run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from lawn_sb3.experiment.cell import REGRET_FILE, run_cell
from lawn_sb3.experiment.evaluation import evaluation_games, fly
from lawn_sb3.experiment.recipe import Cell, Method
from lawn_sb3.experiment.regret import add_regrets, has_regrets, regrets, summarize_regrets
from lawn_sb3.game.player import RandomPlayer
from lawn_sb3.planning import EquilibriumPlayer, ShortestPathPlayer
from lawn_sb3.planning.guarantee import guaranteed_utilities_mbps
from lawn_sb3.scenario import PRESETS
from tests.experiment.test_cell import ignore

PAPER = PRESETS["paper"]
QUIET = Console(quiet=True)


def planned(cell: Cell, player: str) -> Cell:
    """The run of a player without training."""
    return replace(
        cell, key=player, method=Method(label=player, player=player), directory=cell.directory.parent / player
    )


def test_nobody_regrets_an_equilibrium() -> None:
    flights = fly(EquilibriumPlayer(), PAPER, 20, 3, traced=20)
    rows = regrets(flights, PAPER, 3)
    np.testing.assert_allclose(rows["best_mbps"], rows["utility_mbps"], atol=1e-9)
    assert summarize_regrets(rows, flights.rows)["equilibria_percent"] == 100.0


def test_a_failed_mission_is_regretted_by_all_that_could_have_been_had() -> None:
    flights = fly(RandomPlayer(), PAPER, 20, 3, traced=20)
    rows = regrets(flights, PAPER, 3)
    failed = ~flights.rows["arrived"]
    assert failed.any()
    assert (rows.loc[failed, "utility_mbps"] == 0.0).all()
    games = evaluation_games(PAPER, 20, 3)
    safe_mbps = guaranteed_utilities_mbps(games.rules, games.state, PAPER.max_slots)
    assert safe_mbps.min() > 0.0
    assert (rows["best_mbps"] >= safe_mbps.ravel() - 1e-9).all()
    assert (rows["best_slots"] >= flights.rows["min_slots"]).all()


def test_a_uav_alone_regrets_what_its_path_lacks_to_the_best_one() -> None:
    alone = PAPER.changed(num_uavs=1)
    flights = fly(ShortestPathPlayer(), alone, 30, 3, traced=30)
    rows = regrets(flights, alone, 3)
    bound = fly(EquilibriumPlayer(), alone, 30, 3).rows
    np.testing.assert_allclose(rows["best_mbps"], bound["utility_mbps"])
    assert (rows["best_mbps"] >= rows["utility_mbps"] - 1e-9).all()


def test_means_and_gaps_of_three_episodes_worked_out_by_hand() -> None:
    rows = pd.DataFrame(
        {
            "episode": [0, 0, 1, 1, 2, 2, 3, 3],
            "uav": [0, 1] * 4,
            "utility_mbps": [10.0, 20.0, 30.0, 30.0, 5.0, 40.0, 20.0, 20.0],
            "best_mbps": [13.0, 20.0, 30.0, 30.0, 11.0, 39.0, 20.0, 20.0],
        }
    )
    # Regrets 3, 0 | 0, 0 | 6, 0 | 0, 0: UAV 1 of episode 2 collided and had more than it could without. Largest: 3, 0,
    # 6, 0. Nobody could gain in episodes 1 and 3, but in the latter the UAVs collide.
    flown = rows.assign(collisions=[0, 0, 0, 0, 0, 1, 1, 1])
    assert summarize_regrets(rows, flown) == {
        "regret_mbps": 9.0 / 8.0,
        "nash_gap_mbps": 9.0 / 4.0,
        "largest_regret_mbps": 6.0,
        "equilibria_percent": 25.0,
    }


def test_runs_get_their_regrets_once(small_cell: Cell, monkeypatch: pytest.MonkeyPatch) -> None:
    cells = [small_cell, *(planned(small_cell, player) for player in ("forecast", "bound"))]
    for cell in cells:
        run_cell(cell, ignore)
    unfinished = replace(small_cell, seed=4, directory=small_cell.directory.with_name("seed-4"))
    add_regrets([*cells, unfinished], QUIET)
    for cell in cells[:2]:
        rows, evaluation = (pd.read_csv(cell.directory / name) for name in (REGRET_FILE, "evaluation.csv"))
        assert (rows["utility_mbps"] == evaluation["utility_mbps"]).all()
        assert (rows[["episode", "uav"]] == evaluation[["episode", "uav"]]).all(axis=None)
    assert not has_regrets(cells[2])
    assert not (cells[2].directory / REGRET_FILE).exists()
    assert not unfinished.directory.exists()
    monkeypatch.setattr("lawn_sb3.experiment.regret.fly", None)  # flying again would fail
    add_regrets(cells, QUIET)


def test_a_damaged_file_is_made_anew(small_cell: Cell) -> None:
    cell = planned(small_cell, "shortest-path")
    run_cell(cell, ignore)
    add_regrets([cell], QUIET)
    path: Path = cell.directory / REGRET_FILE
    whole = path.read_bytes()
    for damaged in (whole[: len(whole) // 2], whole.replace(b"\n0,1,", b"\n0,1,9", 1), b""):
        path.write_bytes(damaged)
        add_regrets([cell], QUIET)
        assert path.read_bytes() == whole


def test_a_run_made_anew_has_no_regrets_of_the_old_one(small_cell: Cell) -> None:
    cell = planned(small_cell, "shortest-path")
    run_cell(cell, ignore)
    add_regrets([cell], QUIET)
    run_cell(replace(cell, evaluation=cell.evaluation.model_copy(update={"seed": 1})), ignore)
    assert not (cell.directory / REGRET_FILE).exists()
