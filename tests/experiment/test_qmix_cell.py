"""A cell of QMIX: whole games by default, and resumed as if never interrupted, replay included."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.recipe import parse_method
from lawn_sb3.experiment.run_directory.configuration import load_run
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.scenario import PRESETS
from tests.experiment.conftest import SMALL_EVALUATION
from tests.experiment.training import assert_equal_runs, ignore, resumed

SETTINGS = {
    "buffer_size": 60, "learning_starts": 80, "batch_size": 16, "target_update_interval": 7,
    "learning_rate": "lin_1e-3", "gamma": 0.85, "policy_kwargs": {"net_arch": [16]},
}  # fmt: skip


@pytest.fixture
def team_cell(tmp_path: Path) -> Cell:
    """Forty vector steps of QMIX on three games, with a replay that overflows."""
    values = {"label": "QMIX", "algo": "qmix", "env_steps": 120, "num_games": 3, "settings": SETTINGS}
    scenario = PRESETS["paper"].changed(max_slots=9)
    return Cell("qmix", parse_method(values), 3, scenario, SMALL_EVALUATION, tmp_path / "qmix" / "seed-3")


def test_renewed_missions_are_refused_in_one_line(team_cell: Cell) -> None:
    bad = team_cell.method.model_copy(update={"continuation": "mission"})
    with pytest.raises(UserError, match=r"qmix refuses its settings: .*continuation='episode'"):
        build_model(replace(team_cell, method=bad))


@pytest.mark.parametrize("policy", ["monotonic_mixer", "additive_mixer"])
@pytest.mark.parametrize("limit", [12, 51, 117])  # before the first update; replay half full; replay overflown
def test_an_interrupted_training_resumes_as_if_nothing_had_happened(
    team_cell: Cell, checkpoint_every: Callable[[int], None], limit: int, policy: str
) -> None:
    checkpoint_every(3)
    cell = replace(team_cell, method=team_cell.method.model_copy(update={"policy": policy}))
    assert resumed(cell, limit)[0] == limit - 3


def test_equal_cells_leave_equal_bytes_and_play_as_they_were_evaluated(team_cell: Cell, tmp_path: Path) -> None:
    twin = replace(team_cell, directory=tmp_path / "twin")
    for cell in (team_cell, twin):
        run_cell(cell, ignore)
    assert_equal_runs(team_cell, twin)
    again = load_run(team_cell.directory)
    assert again == team_cell
    rows = evaluate(load_player(again), again.scenario, again.evaluation.episodes, again.evaluation.seed, again.seed)
    saved = pd.read_csv(team_cell.directory / "evaluation.csv")
    np.testing.assert_allclose(rows["reward"], saved["reward"], rtol=1e-8)
    curve = pd.read_csv(team_cell.directory / "progress.csv")
    assert {"missions/success_percent", "greedy/success_percent", "train/loss", "rollout/exploration_rate"} <= set(
        curve
    )
