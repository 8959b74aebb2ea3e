"""What holds for the runs of every algorithm: they play as they were evaluated, and resume as if never interrupted."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.run_directory.configuration import load_run
from lawn_sb3.experiment.run_directory.csv_file import rows_as_text
from lawn_sb3.experiment.run_directory.files import EVALUATION_FILE, PROGRESS_FILE, SAMPLED_FILE
from lawn_sb3.experiment.train import run_cell
from tests.experiment.training import ignore, iql_cell, mappo_cell, qmix_cell, resumed

VARIANTS = ["masked", "recurrent", "separate_actors", "set_critic"]
Make = Callable[..., Cell]


@pytest.mark.parametrize(
    ("make", "settings", "logged"),
    [
        (mappo_cell, {}, "train/value_loss"),
        *((mappo_cell, {"policy": policy}, "train/value_loss") for policy in VARIANTS),
        (iql_cell, {}, "train/loss"),
        (qmix_cell, {}, "rollout/exploration_rate"),
    ],
)
def test_a_finished_run_plays_as_it_was_evaluated_and_has_its_curve(
    tmp_path: Path, make: Make, settings: dict[str, Any], logged: str
) -> None:
    cell = make(tmp_path / "run", **settings)
    run_cell(cell, ignore)
    again = load_run(cell.directory)
    assert again == cell
    given = again.scenario, again.evaluation.episodes, again.evaluation.seed, again.seed
    greedy, sampled = (evaluate(load_player(again, deterministic=choice), *given) for choice in (True, False))
    assert rows_as_text(greedy) == (cell.directory / EVALUATION_FILE).read_text(encoding="utf-8")
    assert rows_as_text(sampled) == (cell.directory / SAMPLED_FILE).read_text(encoding="utf-8")
    assert (sampled["reward"] != greedy["reward"]).any()
    curve = pd.read_csv(cell.directory / PROGRESS_FILE)
    assert {"missions/success_percent", "greedy/success_percent", logged} <= set(curve)


INTERRUPTED: list[tuple[Make, dict[str, Any], int, list[int]]] = [
    (mappo_cell, {}, 64, [128, 192, 256]),
    (mappo_cell, {"autocast": "bfloat16"}, 64, [192]),
    *((mappo_cell, {"policy": policy}, 64, [64, 192]) for policy in VARIANTS),
    (iql_cell, {}, 2, [8, 26]),  # the first amid random play
    (iql_cell, {"double_q": True}, 2, [40]),
    (iql_cell, {"share_parameters": True}, 2, [26]),
    (iql_cell, {"n_steps": 3, "train_freq": 2}, 2, [26]),
    (iql_cell, {"policy": "quantile_q"}, 2, [26]),
    (iql_cell, {"policy": "quantile_q", "share_parameters": True}, 2, [8]),
    # Before the first update; replay half full; replay overflown.
    (qmix_cell, {"policy": "monotonic_mixer"}, 3, [12, 51, 117]),
    (qmix_cell, {"policy": "additive_mixer"}, 3, [12, 51, 117]),
]
"""How a cell is made, env steps between two checkpoints, and after how many it is interrupted."""


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize(
    ("make", "settings", "every", "limit"),
    [(make, settings, every, limit) for make, settings, every, limits in INTERRUPTED for limit in limits],
)
def test_an_interrupted_training_resumes_as_if_nothing_had_happened(
    tmp_path: Path, make: Make, settings: dict[str, Any], every: int, limit: int
) -> None:
    assert resumed(make(tmp_path / "run", **settings), limit)[0] == limit - every
