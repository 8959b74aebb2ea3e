"""Flying finished players with other numbers of UAVs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from rich.console import Console

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import SCALING_FILE, claim_directory, run_cell
from lawn_sb3.experiment.evaluation import evaluate, summarize
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.recipe import Cell, Method, Scaling
from lawn_sb3.experiment.scaling import fly_scaled, has_flown, scale_out
from tests.experiment.test_cell import ignore

SCALING = Scaling(num_uavs=(1, 4, 6), episodes=5, methods=("mappo",))


@pytest.fixture
def finished(small_cell: Cell) -> Cell:
    run_cell(small_cell, ignore)
    return small_cell


def test_at_the_n_of_training_it_is_the_evaluation_itself(finished: Cell) -> None:
    rows = fly_scaled(finished, SCALING)
    assert list(rows["num_uavs"]) == [1, 4, 6]
    flown = evaluate(load_player(finished), finished.scenario, 5, finished.evaluation.seed, finished.seed)
    at_four = rows[rows["num_uavs"] == 4].iloc[0]
    for name, value in summarize(flown).items():
        assert at_four[name] == value


def test_alone_in_the_air_nobody_collides(finished: Cell) -> None:
    assert fly_scaled(finished, SCALING).set_index("num_uavs").loc[1, "collisions"] == 0.0


def test_what_was_flown_is_kept_and_what_is_asked_anew_is_flown(
    finished: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert not has_flown(finished, SCALING)
    scale_out([finished], SCALING, Console(quiet=True))
    assert has_flown(finished, SCALING)
    assert not has_flown(finished, SCALING.model_copy(update={"episodes": 6}))
    assert not has_flown(finished, SCALING.model_copy(update={"num_uavs": (1, 4)}))
    kept = (finished.directory / SCALING_FILE).read_bytes()
    monkeypatch.setattr("lawn_sb3.experiment.scaling.fly_scaled", None)  # flying again would fail
    scale_out([finished], SCALING, Console(quiet=True))
    assert (finished.directory / SCALING_FILE).read_bytes() == kept


def test_a_damaged_file_is_flown_again(finished: Cell) -> None:
    (finished.directory / SCALING_FILE).write_text("num_uavs,reward\n1,", encoding="utf-8")
    assert not has_flown(finished, SCALING)
    scale_out([finished], SCALING, Console(quiet=True))
    assert len(pd.read_csv(finished.directory / SCALING_FILE)) == 3


def test_methods_that_were_not_chosen_or_not_finished_are_not_flown(finished: Cell, tmp_path: Path) -> None:
    other = replace(finished, key="other")
    unfinished = replace(finished, directory=tmp_path / "nothing")
    scale_out([other, unfinished], SCALING, Console(quiet=True))
    assert not (finished.directory / SCALING_FILE).exists()
    assert not unfinished.directory.exists()


def test_a_run_that_is_made_anew_loses_what_its_model_flew(finished: Cell) -> None:
    scale_out([finished], SCALING, Console(quiet=True))
    claim_directory(finished)
    assert not (finished.directory / SCALING_FILE).exists()


def test_players_without_training_fly_too_and_more_uavs_than_fit_are_refused(small_cell: Cell, tmp_path: Path) -> None:
    method = Method(label="Random", player="random")
    cell = replace(small_cell, key="random", method=method, directory=tmp_path / "random")
    assert list(fly_scaled(cell, SCALING)["num_uavs"]) == [1, 4, 6]
    with pytest.raises(UserError, match=r"num_uavs = 151 .* at most 150 UAVs"):
        fly_scaled(cell, Scaling(num_uavs=(151,), episodes=1, methods=("random",)))
