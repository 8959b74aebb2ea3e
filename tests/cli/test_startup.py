"""Who asks for help, or misspelt something, does not wait for torch: what is heavy is imported once there is work."""

import json
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import yaml

from lawn_sb3.cli.commands import app
from lawn_sb3.experiment.registry import REPOSITORY
from tests.cli.running import METHODS, recipe

KEPT = REPOSITORY / "runs" / "reference" / "paper"
ASKED = ["--help", "--version", *(f"{one.name or one.callback.__name__} --help" for one in app.registered_commands)]  # type: ignore[union-attr]
REFUSED = [
    "halp",
    "train",
    "train --out new --sed 1",
    "train --out new --algo mapo",
    "train --out new --policy stat_critic",
    "train --out new -params gama=1",
    "train --out new -params learning_rate=lin_x",
    "train --out new --scenario papre",
    "train --out new --set rb_bandwidth_hz=-5",
    "train --out new --env-steps 0",
    "train --out new --recipe tiny.yaml --method mapo",
    "train --out new --recipe tiny.yaml",
    "train --out .",
    "train --out tiny.yaml",
    "evaluate",
    "evaluate --player randon",
    "evaluate --player random --set num_uav=5",
    "evaluate --player random --set num_uavs",
    "evaluate --player random --scenario nowhere.yaml",
    "evaluate --player random --seed -1",
    "evaluate --player bound --regret",
    "evaluate --run nowhere",
    "evaluate --run unfinished",
    f"evaluate --run {KEPT}/random/seed-0 --set gbs_grid=[3,3]",
    "verify nowhere",
    "verify unfinished",
    "plan --player equilibrum",
    "plan --player shortest-path --slack 1",
    "plan --player welfare --rows nowhere/rows.csv",
    "ceiling --player forcast",
    "ceiling --run nowhere",
    f"ceiling --run {KEPT}/mappo/seed-0",
    "scenario papre",
    "scenario --set arrival=never",
    "scenario --picture airspace.txt",
    "reproduce nowhere.yaml",
    "reproduce no_yaml.yaml",
    "reproduce misspelt_key.yaml",
    "reproduce misspelt_setting.yaml",
    "reproduce unknown_algorithm.yaml",
    "reproduce unknown_player.yaml",
    "reproduce unknown_policy.yaml",
    "reproduce unknown_credit.yaml",
    "reproduce unknown_scenario.yaml",
    "reproduce negative_bandwidth.yaml",
    "reproduce negative_seed.yaml",
    "ablate nobody",
    "ablate state_critic --recipe nowhere.yaml",
    "report nowhere.yaml",
    "report tiny.yaml",
    "report tiny.yaml --runs nowhere",
    "export tiny.yaml",
    "export tiny.yaml --to .",
    "tune nowhere.yaml",
    "tune reported_seed.yaml",
    "tune misspelt_space.yaml",
]
HEAVY = ("torch", "stable_baselines3", "sb3_contrib", "scipy", "pandas", "pandera", "matplotlib", "numba", "gymnasium")
ONE_AFTER_THE_OTHER = """
import contextlib, io, json, sys
from lawn_sb3.cli import main
heavy, *commands = json.load(sys.stdin)
answers = []
for command in commands:
    sys.argv, said = ["lawn-sb3", *command], io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            main()
        except SystemExit as end:
            status = end.code or 0
    answers.append([status, said.getvalue(), [name for name in heavy if name in sys.modules]])
json.dump(answers, sys.stdout)
"""


def write_what_is_refused(folder: Path) -> None:
    """Recipes and searches with one mistake each, and a run that is not finished."""
    mappo: dict[str, Any] = METHODS["mappo"]
    mistakes: dict[str, dict[str, Any]] = {
        "misspelt_key": {"seads": [0]},
        "misspelt_setting": {"methods": {"mappo": {**mappo, "settings": {"gama": 1}}}},
        "unknown_algorithm": {"methods": {"mappo": {**mappo, "algo": "mapo"}}},
        "unknown_player": {"methods": {"random": {"label": "Random", "player": "randon"}}},
        "unknown_policy": {"methods": {"mappo": {**mappo, "policy": "stat_critic"}}},
        "unknown_credit": {"methods": {"mappo": {**mappo, "credit": "ours"}}},
        "unknown_scenario": {"scenario": "papre"},
        "negative_bandwidth": {"set": ["rb_bandwidth_hz=-5"]},
        "negative_seed": {"seeds": [-1]},
    }
    for name, mistake in mistakes.items():
        recipe(folder, **mistake).rename(folder / f"{name}.yaml")
    recipe(folder)
    (folder / "no_yaml.yaml").write_text("methods: [", encoding="utf-8")
    search = {"recipe": "tiny.yaml", "seeds": [100], "space": {"mappo": {"gamma": [0.9]}}}
    wrong: dict[str, Any] = {"reported_seed": {"seeds": [0]}, "misspelt_space": {"space": {"mappo": {"gama": [1]}}}}
    for name, change in wrong.items():
        (folder / f"{name}.yaml").write_text(yaml.safe_dump({**search, **change}), encoding="utf-8")
    (folder / "unfinished").mkdir()
    (folder / "unfinished" / "config.yaml").write_bytes((KEPT / "mappo" / "seed-0" / "config.yaml").read_bytes())


def test_help_and_refusals_come_without_the_heavy_libraries(tmp_path: Path) -> None:
    write_what_is_refused(tmp_path)
    commands = [shlex.split(command) for command in (*ASKED, *REFUSED)]
    done = subprocess.run(
        [sys.executable, "-c", ONE_AFTER_THE_OTHER],
        input=json.dumps([HEAVY, *commands]),
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
    )
    answers = dict(zip((*ASKED, *REFUSED), json.loads(done.stdout), strict=True))
    assert {command: said for command, (_, said, loaded) in answers.items() if loaded} == {}
    assert {command: said for command, (status, said, _) in answers.items() if status != 2 * (command in REFUSED)} == {}
    assert "stable" in answers["--help"][1].lower()
    assert not (tmp_path / "new").exists()
