"""An IQL run is complete, repeatable and resumed after an interruption: its replays come back with the checkpoint."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.recipe import Method
from lawn_sb3.experiment.run_directory.configuration import load_run
from lawn_sb3.experiment.run_directory.files import SAMPLED_FILE
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.scenario import PRESETS
from tests.experiment.conftest import SMALL_EVALUATION
from tests.experiment.training import assert_equal_runs, ignore, resumed


def small_iql_cell(directory: Path, policy: str = "local_q", **settings: Any) -> Cell:
    """Twenty vector steps on two games; the replay of eighteen wraps around."""
    method = Method(
        label="IQL",
        algo="iql",
        policy=policy,
        env_steps=40,
        num_games=2,
        settings={
            "buffer_size": 36, "learning_starts": 16, "batch_size": 16, "train_freq": 1, "target_update_interval": 6,
            "exploration_fraction": 0.5, "learning_rate": "lin_1e-3", "policy_kwargs": {"net_arch": [16]}, **settings,
        },
    )  # fmt: skip
    scenario = PRESETS["paper"].changed(max_slots=8)
    return Cell("iql", method, 3, scenario, SMALL_EVALUATION, directory)


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize(
    ("limit", "settings"),
    [
        (8, {}),  # amid random play
        (26, {}),
        (40, {"double_q": True}),
        (26, {"share_parameters": True}),
        (26, {"n_steps": 3, "train_freq": 2}),
        (26, {"policy": "quantile_q"}),
        (8, {"policy": "quantile_q", "share_parameters": True}),
    ],
)
def test_an_interrupted_training_resumes_as_if_nothing_had_happened(
    tmp_path: Path, limit: int, settings: dict[str, Any]
) -> None:
    assert 0 < resumed(small_iql_cell(tmp_path / "iql", **settings), limit)[0] < limit


def test_equal_cells_leave_equal_bytes(tmp_path: Path) -> None:
    cell = small_iql_cell(tmp_path / "one")
    twin = replace(cell, directory=tmp_path / "twin")
    for each in (cell, twin):
        run_cell(each, ignore)
    assert_equal_runs(cell, twin)


def test_a_finished_run_plays_as_it_was_evaluated(tmp_path: Path) -> None:
    cell = small_iql_cell(tmp_path / "one")
    run_cell(cell, ignore)
    again = load_run(cell.directory)
    rows = [
        evaluate(load_player(one), one.scenario, one.evaluation.episodes, one.evaluation.seed, one.seed)
        for one in (cell, again)
    ]
    assert rows[0].equals(rows[1])
    exploring = load_player(again, deterministic=False)
    sampled = evaluate(exploring, again.scenario, again.evaluation.episodes, again.evaluation.seed, again.seed)
    saved = pd.read_csv(cell.directory / SAMPLED_FILE)
    assert (sampled["slots"] == saved["slots"]).all()
    assert (sampled["reward"] != rows[0]["reward"]).any()
