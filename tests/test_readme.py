"""What the README shows works as it stands there."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from lawn_sb3.cli import main
from lawn_sb3.cli.commands import app
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.paper.claims import load_claims
from tests.cli.test_ablation import METHODS
from tests.cli.test_cli import recipe

README = (REPOSITORY / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)


def test_the_policy_example_is_short_complete_and_trained_by_the_command_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    example = next(block for block in BLOCKS if "CTDEPolicy" in block)
    assert len(example.splitlines()) < 40
    (name,) = set(re.findall(r"policies/(\w+)\.py`, in the folder", README))
    assert f"lawn-sb3 ablate {name}\n" in README
    (tmp_path / "policies").mkdir()
    (tmp_path / "policies" / f"{name}.py").write_text(example, encoding="utf-8")
    recipe(tmp_path, methods=METHODS)
    monkeypatch.chdir(tmp_path)
    for command in (["reproduce", "tiny.yaml"], ["ablate", name, "--recipe", "tiny.yaml"]):
        monkeypatch.setattr(sys, "argv", ["lawn-sb3", *command])
        with pytest.raises(SystemExit) as end:
            main()
        assert not end.value.code
    assert name in (tmp_path / "tiny" / name / "report" / "effects.md").read_text(encoding="utf-8")


def test_the_environment_example_runs(capsys: pytest.CaptureFixture[str]) -> None:
    example = next(block for block in BLOCKS if "make_vec_env" in block)
    exec(compile(example, "README.md", "exec"), {})
    assert "flying" in capsys.readouterr().out


def test_the_planner_example_runs(capsys: pytest.CaptureFixture[str]) -> None:
    example = next(block for block in BLOCKS if "PlanPlayer" in block)
    exec(compile(example, "README.md", "exec"), {})
    first, second = (float(text) for text in re.findall(r"mean U (\d+\.\d) Mbps", capsys.readouterr().out))
    assert 30.0 < first < second < 55.0


def test_every_make_target_and_command_it_names_exists() -> None:
    makefile = (REPOSITORY / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"make ([a-z]+)\b", README):
        assert re.search(rf"^{target}:", makefile, flags=re.MULTILINE), target
    known = {command.name or command.callback.__name__ for command in app.registered_commands if command.callback}
    used = re.findall(r"lawn-sb3 ([a-z]+)\b", README)
    assert set(used) <= known
    assert known <= set(used), "a command that the README does not name"


def test_another_projects_trainer_learns_and_writes_no_files(tmp_path: Path) -> None:
    example = next(block for block in BLOCKS if "skrl" in block)
    command = [sys.executable, "-c", f"import torch\ntorch.set_num_threads(1)\n{example}"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    untrained, trained = map(float, re.findall(r"(-?\d+\.\d+) (?:untrained|after)", done.stdout))
    assert trained > untrained
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["table2", "claims_headlines"])
def test_its_tables_are_those_of_the_reference_results(name: str) -> None:
    table = REPOSITORY / "runs" / "reference" / "paper" / "report" / f"{name}.md"
    assert table.read_text(encoding="utf-8") in README


def test_its_tally_of_the_claims_is_that_of_the_reference_results() -> None:
    report = json.loads((REPOSITORY / "runs" / "reference" / "paper" / "report" / "report.json").read_text("utf-8"))
    (tally,) = report["summary"]
    assert tally.removeprefix("The paper's claims: ") in " ".join(README.split())
    assert f"{len(load_claims())} checkable claims" in README


def test_no_placeholder_is_left() -> None:
    assert not re.findall(r"\b(TODO|FIXME|XXX|TALLY|HEADLINES|SENSITIVITY)\b", README)


def test_every_picture_and_page_it_links_to_is_there() -> None:
    links = re.findall(r"\]\(([^)#]+)", README)
    assert [link for link in links if not link.startswith("http") and not (REPOSITORY / link).exists()] == []
