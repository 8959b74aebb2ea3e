"""The commands about finished runs: report, export, verify, identify, and what reproduce ends with."""

import json
import shutil
from pathlib import Path

import pytest

from tests.cli.running import QUICK, Lawn, exit_status, recipe


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a tiny recipe and its finished runs."""
    folder = tmp_path_factory.mktemp("tiny")
    assert exit_status("reproduce", recipe(folder)) == 0
    return folder


@pytest.fixture(autouse=True)
def _folder(reproduced: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A copy of it to work in, as ``runs``."""
    shutil.copytree(reproduced, tmp_path / "runs")
    monkeypatch.chdir(tmp_path)


def test_exported_runs_rebuild_the_same_report_byte_for_byte(lawn: Lawn) -> None:
    lawn("export", "runs/tiny.yaml")
    reference = Path("runs/reference/tiny")
    assert (reference / "mappo" / "seed-0" / "weights.npz").exists()
    assert (reference / "checks" / "hovering.csv").exists()
    assert not list(reference.rglob("model.zip"))
    before = {path.name: path.read_bytes() for path in (reference / "report").iterdir()}
    shutil.rmtree(reference / "report")
    shutil.rmtree("runs/tiny")
    lawn("report", "runs/tiny.yaml", "--runs", reference)
    assert {path.name: path.read_bytes() for path in (reference / "report").iterdir()} == before


def test_reproduce_ends_with_the_comparison_to_the_reference(lawn: Lawn) -> None:
    assert "no reference results" in lawn("reproduce", "runs/tiny.yaml").err
    lawn("export", "runs/tiny.yaml")
    done = lawn("reproduce", "runs/tiny.yaml")
    assert done.out.count("equal to the last digit") == 2  # both methods
    assert Path("runs/tiny/report/against_reference.md").exists()
    rows = Path("runs/reference/tiny/mappo/seed-0/evaluation.csv")
    lines = rows.read_text(encoding="utf-8").splitlines()
    episode, uav, _, *others = lines[1].split(",")
    lines[1] = ",".join([episode, uav, "99", *others])
    rows.write_text("\n".join(lines) + "\n", encoding="utf-8")
    assert lawn("reproduce", "runs/tiny.yaml").out.count("equal to the last digit") == 1


def test_a_report_without_runs_points_to_the_reference(lawn: Lawn) -> None:
    lawn("export", "runs/tiny.yaml")
    shutil.rmtree("runs/tiny")
    assert "--runs runs/reference/tiny" in lawn("report", "runs/tiny.yaml", status=2).err


def test_an_unfinished_run_is_not_exported_and_what_is_kept_stays(lawn: Lawn) -> None:
    lawn("export", "runs/tiny.yaml")
    before = {path: path.read_bytes() for path in Path("runs/reference").rglob("*") if path.is_file()}
    Path("runs/tiny/mappo/seed-1/finished").unlink()
    assert "seed-1" in lawn("export", "runs/tiny.yaml", status=2).err
    assert {path: path.read_bytes() for path in Path("runs/reference").rglob("*") if path.is_file()} == before


def test_a_folder_that_is_no_export_is_not_written_to(lawn: Lawn) -> None:
    Path("mine/report").mkdir(parents=True)
    Path("mine/report/notes.txt").write_text("keep me", encoding="utf-8")
    assert "'mine' holds something else" in lawn("export", "runs/tiny.yaml", "--to", "mine", status=2).err
    assert [path.name for path in Path("mine").rglob("*.*")] == ["notes.txt"]


def test_a_whole_run_is_verified_and_a_forged_one_is_not(lawn: Lawn) -> None:
    run = Path("runs/tiny/mappo/seed-0")
    assert json.loads(lawn("verify", run, "--json").out)["rows_that_differ"] == 0
    rows = run / "evaluation.csv"
    text = rows.read_text()
    rows.write_text(text.replace("\n0,1,", "\n0,1,9", 1))
    assert "evaluation.csv not as the run left it" in lawn("verify", run, status=2).err
    (rows.parent / "manifest.json").unlink()  # as whoever forges may do
    assert "1 of 16 rows" in lawn("verify", run, status=1).err
    rows.write_text(text[:200])
    lawn("verify", run, status=2)


def test_kept_weights_are_verified_too(lawn: Lawn) -> None:
    lawn("export", "runs/tiny.yaml")
    lawn("verify", "runs/reference/tiny/mappo/seed-0")
    assert "model was not kept" in lawn("verify", "runs/reference/tiny/mappo/seed-1", status=2).err
    lawn("verify", "runs/reference/tiny/random/seed-1")  # there is no model to be kept


def test_identify_prints_one_json_object_and_writes_a_page(lawn: Lawn) -> None:
    done = lawn("identify", "--alone", "--episodes", "20", "--json", "--out", "found")
    assert json.loads(done.out)["episodes"] == 20
    assert json.loads(Path("found/identify.json").read_text(encoding="utf-8"))["findings"]
    assert Path("found/README.md").read_text(encoding="utf-8").startswith("# What the paper")
    assert "no trained players" in done.err


def test_identify_writes_the_page_again_from_what_it_kept(lawn: Lawn) -> None:
    lawn("identify", "--alone", "--episodes", "20", "--out", "found")
    assert "20 episodes a candidate" in lawn("identify", "--from", "found", "--out", "again").out
    for name in ("README.md", "identify.json"):
        assert Path("again", name).read_bytes() == Path("found", name).read_bytes()
    assert "holds no identify.json" in lawn("identify", "--from", "nowhere", status=2).err
    Path("again/identify.json").write_text('{"episodes": 20}', encoding="utf-8")
    assert "no identification that this version wrote" in lawn("identify", "--from", "again", status=2).err


def test_a_training_that_fails_ends_with_one_line_and_status_1(lawn: Lawn) -> None:
    small = ["--env-steps", "128", "--num-games", "2", *QUICK, "--set", "max_slots=20", "--no-progress"]
    said = lawn("train", *small, "-params", "learning_rate=1e30", "--out", "bad", status=1).err
    assert "training in 'bad' failed" in said
    assert "Traceback" not in said


BREAKS_IN_UPDATES = """
import torch as th

from lawn_sb3.algos.mappo import CTDEPolicy


class Late(CTDEPolicy):
    def critic_input(self, local, state):
        if len(local) == 48:
            local = local @ th.zeros(3, 4)
        return local
"""


def test_a_policy_that_breaks_in_training_is_told_with_its_file_and_line(lawn: Lawn) -> None:
    Path("policies").mkdir(exist_ok=True)
    Path("policies/late.py").write_text(BREAKS_IN_UPDATES, encoding="utf-8")
    small = ["--env-steps", "128", "--num-games", "2", *QUICK, "-params", "batch_size=48", "--no-progress"]
    said = lawn("train", *small, "--policy", "late", "--out", "late", status=1).err
    assert "policy 'late' (policies/late.py, line 10): RuntimeError: mat1 and mat2 shapes cannot be" in said
