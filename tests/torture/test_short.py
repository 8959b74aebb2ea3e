"""The short forms of the campaigns of damages and of kills, and that the one of kills sees what it looks for."""

import shutil
import time
from collections import Counter
from pathlib import Path

import pytest
import yaml

from lawn_sb3.experiment.checkpoint import Checkpoints
from lawn_sb3.experiment.train import run_cell
from tests.cli.running import exit_status
from tests.experiment.training import ignore, interrupt, mappo_cell
from tests.torture import damages, kills


def test_checkpoints_damaged_alone_and_both_leave_what_others_leave(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Checkpoints.__init__, "__defaults__", (1,))
    ends = damages.torture("mappo", 5, tmp_path)
    assert ends == {"the one before is used": 4, "the training starts anew": 1}
    assert damages.line("mappo", ends + Counter(ends)) == (
        "mappo: 10 damages noticed, 8 resumed from the checkpoint before, 2 begun anew; all raw files and weights equal"
    )


def test_a_training_killed_after_its_first_checkpoint_leaves_what_others_leave(tmp_path: Path) -> None:
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    recipe = tmp_path / "short.yaml"
    method = {"label": "MAPPO", "env_steps": 4_000, "num_games": 8, **kills.METHODS["mappo"]}
    recipe.write_text(yaml.safe_dump({"seeds": [0], "evaluation": kills.EVALUATION, "methods": {"mappo": method}}))
    train: list[str | Path] = ["train", "--recipe", recipe, "--method", "mappo"]
    began = time.monotonic()
    assert exit_status(*train, "--no-progress", "--out", whole / "mappo" / "seed-0") == 0
    pace = kills.Pace(0.0, 0.3 * (time.monotonic() - began))  # a part of what is left after the first checkpoint
    result = kills.kill([*train, "--seeds", "0", "--out", killed / "mappo"], whole, killed, 1, pace, early_every=0)
    assert result.kills == {"group": 1}
    assert (result.later, result.resumed, result.raw_files, result.models) == (1, 1, 6, 1)


def test_what_kills_may_do_to_runs_is_seen(tmp_path: Path) -> None:
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    run_cell(mappo_cell(whole / "mappo" / "seed-3"), ignore)
    shutil.copytree(whole, killed)
    raw_files, models = kills.compare(whole, killed)
    assert (raw_files, models) == (6, 1)
    run = killed / "mappo" / "seed-3"
    for name in ("progress.csv", "model.zip", "config.yaml", "weights.safetensors"):
        content = (run / name).read_bytes()
        (run / name).write_bytes(content[:-1] + bytes([content[-1] ^ 1]))
        with pytest.raises(AssertionError, match=rf"different: .*{name}"):
            kills.compare(whole, killed)
        (run / name).write_bytes(content)
    for name in ("part-model.zip", "lock", "checkpoint_before.bin"):
        (run / name).touch()
        with pytest.raises(AssertionError, match=f"left over: .*{name}"):
            kills.compare(whole, killed)
        (run / name).unlink()


def test_a_run_that_lost_its_checkpoint_to_a_kill_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Checkpoints.__init__, "__defaults__", (1,))
    anew, gone_on = (mappo_cell(tmp_path / "mappo" / f"seed-{seed}") for seed in (3, 4))
    interrupt(gone_on, 192)
    (gone_on.directory / "lock").write_text('{"pid": 12}')
    assert kills.being_made(tmp_path, [11, 12]) == [gone_on.directory]
    assert kills.being_made(tmp_path, [11]) == []
    assert kills.have_checkpoints([anew.directory, gone_on.directory]) == [gone_on.directory]
    (gone_on.directory / "lock").unlink()
    for cell in (anew, gone_on):
        run_cell(cell, ignore)
    assert kills.check_resumed(tmp_path, {gone_on.directory}) == 1
    with pytest.raises(AssertionError, match=r"begun anew: \['.*seed-3'\]"):
        kills.check_resumed(tmp_path, {anew.directory, gone_on.directory})
