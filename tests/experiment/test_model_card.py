"""The card of a trained model says what was trained, on which game, what came out, and how to go on from there."""

import re
import shlex
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from lawn_sb3.experiment import provenance
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.experiment.model_card import model_card
from tests.cli.running import QUICK, Lawn
from tests.experiment.training import iql_cell, mappo_cell, qmix_cell

RECORD: dict[str, Any] = {
    "command": "lawn-sb3 train --out runs/mine",
    "commit": "abc",
    "python": "3.12.1",
    "versions": {"lawn-sb3": "0.2.0", "torch": "2.13.0"},
    "trained_env_steps": 1_024,
    "started": "2026-01-02T03:04:05+00:00",
    "train_seconds": 12.5,
}
FLOWN = pd.DataFrame(
    {
        "episode": [0, 0, 1, 1], "uav": [0, 1, 0, 1], "reward": [3.0, 4.0, 2.0, 1.5], "rate_mbps": 30.0,
        "slots": [3, 5, 4, 4], "arrived": [True, True, True, False], "utility_mbps": [40.0, 30.0, 20.5, 0.0],
        "collisions": 0, "makespan_slots": [5, 5, 4, 4],
    }
)  # fmt: skip


def test_it_has_the_row_the_game_the_commands_and_the_versions_and_no_times(tmp_path: Path) -> None:
    cell = mappo_cell(tmp_path)
    card = model_card(replace(cell, scenario=cell.scenario.changed(num_uavs=2)), RECORD, FLOWN)
    # Means: 10.5 / 4 = 2.625, 90.5 / 4 = 22.625, (5 + 4) / 2 = 4.5, 3 of 4.
    assert "| 2.62 | 22.6 | 4.5 | 75.0 |" in card
    assert "Greedy actions on the 5 test episodes of seed 20000, means over 4 missions" in card
    assert "# MAPPO, seed 3\n" in card
    assert "mappo with the policy `centralized_critic`, trained by lawn-sb3 0.2.0 for 1,024 env steps" in card
    assert "- Game: paper, num_uavs=2, max_slots=20\n" in card
    assert "\nlawn-sb3 train --out runs/mine\n" in card
    assert "\nlawn-sb3 evaluate --run DIR --episodes 5 --seed 20000\nlawn-sb3 verify DIR\n" in card
    assert "lawn-sb3 0.2.0, torch 2.13.0, Python 3.12.1; commit abc" in card
    assert "2026" not in card
    assert "12.5" not in card


def test_a_game_of_ones_own_is_told_by_what_differs_from_the_papers(tmp_path: Path) -> None:
    cell = mappo_cell(tmp_path)
    mine = replace(cell, scenario=cell.scenario.changed(name="mine", num_uavs=2))
    assert "- Game: mine, which is paper, num_uavs=2, max_slots=20\n" in model_card(mine, RECORD, FLOWN)


def test_a_name_that_is_no_unicode_does_not_keep_it_from_being_written(tmp_path: Path) -> None:
    card = model_card(mappo_cell(tmp_path), {**RECORD, "command": "lawn-sb3 train --out \udcff"}, FLOWN)
    assert "\nlawn-sb3 train --out ?\n" in card
    assert card.encode()


def test_who_flies_a_policy_that_does_not_come_with_the_kit_is_told_to_trust_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "policies").mkdir()
    (tmp_path / "policies" / "of_mine.py").touch()
    cell = mappo_cell(tmp_path, policy="of_mine")
    sampled = replace(cell, evaluation=cell.evaluation.model_copy(update={"deterministic": False}))
    card = model_card(sampled, RECORD, FLOWN)
    assert "--seed 20000 --sample --trust of_mine\nlawn-sb3 verify DIR --trust of_mine\n" in card
    assert "the policy is its author's, and not in it" in card
    assert "Sampled actions" in card


@pytest.mark.parametrize(
    ("make", "settings", "words"),
    [
        (mappo_cell, {}, "actor and critic"),
        (iql_cell, {}, "`learners.K` is the network of UAV K"),
        (iql_cell, {"share_parameters": True}, "`learners.0` is the network of all UAVs"),
        (qmix_cell, {}, "`q_net` is the network that acts"),
    ],
)
def test_it_says_what_the_tensors_are(make: Callable[..., Cell], settings: dict[str, Any], words: str) -> None:
    assert words in model_card(make(Path("run"), **settings), RECORD, FLOWN)


def test_its_commands_make_the_same_run_again_and_fly_the_row_that_it_has_and_its_example_reads_the_tensors(
    lawn: Lawn, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(provenance, "_commit", lambda: "abc")  # somebody may be editing this checkout
    lawn("train", "--no-progress", "--out", "mine", "--num-games", "2", "--env-steps", "64", "--seed", "5", *QUICK)
    card, tensors = Path("mine/README.md").read_text("utf-8"), Path("mine/weights.safetensors").read_bytes()
    ((make,), (fly, verify)) = (block.splitlines() for block in re.findall(r"```\n(.*?)```", card, flags=re.DOTALL))
    Path("mine").rename("before")
    lawn(*shlex.split(make)[1:])
    assert Path("mine/weights.safetensors").read_bytes() == tensors
    assert Path("mine/README.md").read_text("utf-8") == card
    lawn(*shlex.split(fly.replace("DIR", "mine"))[1:], "--rows", "rows.csv")
    assert Path("rows.csv").read_bytes() == Path("mine/evaluation.csv").read_bytes()
    lawn(*shlex.split(verify.replace("DIR", "mine"))[1:])
    row = summarize(pd.read_csv("rows.csv"))
    assert f"| {row['reward']:.2f} | {row['utility_mbps']:.1f} |" in card
    (code,) = re.findall(r"```python\n(.*?)```", card, flags=re.DOTALL)
    monkeypatch.chdir("mine")
    exec(compile(code, "README.md", "exec"), {})
    assert "action_net.bias (63,)" in capfd.readouterr().out.splitlines()
