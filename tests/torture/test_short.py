"""The short form of the campaign of damages, and that the one of kills sees what it looks for."""

import shutil
from collections import Counter
from pathlib import Path

import pytest

from lawn_sb3.experiment.checkpoint import Checkpoints
from lawn_sb3.experiment.train import run_cell
from tests.experiment.training import ignore, mappo_cell
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


def test_what_kills_may_do_to_runs_is_seen(tmp_path: Path) -> None:
    whole, killed = tmp_path / "whole", tmp_path / "killed"
    run_cell(mappo_cell(whole / "mappo" / "seed-3"), ignore)
    shutil.copytree(whole, killed)
    raw_files, models = kills.compare(whole, killed)
    assert (raw_files, models) == (6, 1)
    run = killed / "mappo" / "seed-3"
    for name in ("progress.csv", "model.zip", "config.yaml"):
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
