"""The command line in this process, and a recipe that runs in seconds."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml

from lawn_sb3.cli import main

QUICK = ["-params", "n_steps=32", "-params", "batch_size=64", "-params", "n_epochs=1"]
MAPPO: dict[str, Any] = {
    "label": "MAPPO",
    "algo": "mappo",
    "env_steps": 128,
    "num_games": 2,
    "settings": {"n_steps": 32, "batch_size": 64, "n_epochs": 1},
}
METHODS: dict[str, Any] = {"random": {"label": "Random", "paper_row": "Random", "player": "random"}, "mappo": MAPPO}
ABLATED = {**METHODS, "raw": {**MAPPO, "label": "V(o)", "policy": "local_critic", "baseline": "mappo"}}


class Said(NamedTuple):
    out: str
    err: str


Lawn = Callable[..., Said]
"""Runs a command, checks its exit status, 0 or ``status``, and hands back what it printed."""


def exit_status(*arguments: str | Path) -> int:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["lawn-sb3", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            main()
    return int(end.value.code or 0)


def recipe(folder: Path, **changes: object) -> Path:
    path = folder / "tiny.yaml"
    evaluation = {"episodes": 4, "record_every": 1, "watch_every": 200, "watch_episodes": 2}
    content = {"seeds": [0, 1], "evaluation": evaluation, "methods": METHODS, **changes}
    path.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
    return path
