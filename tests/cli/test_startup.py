"""Who asks for help, or misspelt something, does not wait for torch: what is heavy is imported once there is work."""

import json
import shlex
import subprocess
import sys
from pathlib import Path

from lawn_sb3.cli.commands import app
from tests.cli.refused import REFUSED, write_what_is_refused

ASKED = ["--help", "--version", *(f"{one.name or one.callback.__name__} --help" for one in app.registered_commands)]  # type: ignore[union-attr]
HEAVY = (
    "torch",
    "stable_baselines3",
    "sb3_contrib",
    "scipy",
    "pandas",
    "pandera",
    "matplotlib",
    "numba",
    "gymnasium",
    "safetensors",
)
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
    said = {command: answers[command][1] for command in REFUSED}
    assert {command: said[command] for command, words in REFUSED.items() if words not in said[command]} == {}
    ours = [line for line in said.values() if line.startswith("lawn-sb3: ")]
    assert [line for line in ours if line.count("\n") != 1] == []
    assert "stable" in answers["--help"][1].lower()
    assert not (tmp_path / "new").exists()
