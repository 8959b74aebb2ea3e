"""Files are UTF-8 whatever the machine's locale is, and a terminal that knows ASCII alone is no reason to stop."""

import ast
import os
import subprocess
import sys

import pytest

from lawn_sb3.experiment.registry import REPOSITORY

SOURCES = [path for folder in ("lawn_sb3", "policies") for path in sorted((REPOSITORY / folder).rglob("*.py"))]
POSITION = {"read_text": 0, "write_text": 1, "open": 2}
"""Functions that open text files, and where the encoding stands if it is not named."""


def opened_without_encoding(source: str) -> list[int]:
    """Lines that leave it to the locale how a text file is read or written."""
    lines = []
    for call in ast.walk(ast.parse(source)):
        if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Attribute | ast.Name):
            continue
        name = call.func.attr if isinstance(call.func, ast.Attribute) else call.func.id
        binary = any(isinstance(one, ast.Constant) and "b" in str(one.value) for one in call.args[:2])
        named = any(keyword.arg == "encoding" for keyword in call.keywords) or len(call.args) > POSITION.get(name, 99)
        if name in POSITION and not named and not (name == "open" and binary):
            lines.append(call.lineno)
    return lines


def test_every_text_file_is_opened_with_its_encoding() -> None:
    assert opened_without_encoding("path.read_text()") == [1]
    assert opened_without_encoding("path.read_text('utf-8')") == []
    found = {path.name: opened_without_encoding(path.read_text("utf-8")) for path in SOURCES}
    assert {name: lines for name, lines in found.items() if lines} == {}


@pytest.mark.parametrize("command", ["evaluate --player random --episodes 3", "scenario tiny"])
def test_commands_run_in_an_ascii_locale(command: str) -> None:
    plain = {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONIOENCODING"} | plain
    arguments = [sys.executable, "-m", "lawn_sb3", *command.split()]
    done = subprocess.run(arguments, capture_output=True, text=True, env=environment, check=False)
    assert (done.returncode, done.stderr.count("Error")) == (0, 0), done.stderr
