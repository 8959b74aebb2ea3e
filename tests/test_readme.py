"""What the README shows works as it stands there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from lawn_sb3.experiment.registry import REPOSITORY, find_policy

README = (REPOSITORY / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)


def test_the_policy_example_is_found_by_its_file_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = next(block for block in BLOCKS if "CTDEPolicy" in block)
    (tmp_path / "policies").mkdir()
    (tmp_path / "policies" / "mine.py").write_text(example, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert find_policy("mine").__name__ == "LoadCriticPolicy"


def test_the_environment_example_runs(capsys: pytest.CaptureFixture[str]) -> None:
    example = next(block for block in BLOCKS if "make_vec_env" in block)
    exec(compile(example, "README.md", "exec"), {})
    assert "flying" in capsys.readouterr().out


def test_every_make_target_and_command_it_names_exists() -> None:
    makefile = (REPOSITORY / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"make ([a-z]+)\b", README):
        assert re.search(rf"^{target}:", makefile, flags=re.MULTILINE), target
    cli = (REPOSITORY / "lawn_sb3" / "cli.py").read_text(encoding="utf-8")
    for command in re.findall(r"lawn-sb3 ([a-z]+)\b", README):
        assert f"def {command}" in cli, command
