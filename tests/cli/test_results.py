"""The commands about finished runs: report, export, verify, identify, and what reproduce ends with."""

import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from lawn_sb3.cli import main
from tests.cli.test_cli import QUICK, recipe


class Said(NamedTuple):
    """What a command printed, and its exit status."""

    out: str
    err: str
    status: int


Command = Callable[..., Said]


@pytest.fixture
def lawn(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """Runs a command in this process."""

    def run(*arguments: str | Path) -> Said:
        monkeypatch.setattr(sys, "argv", ["lawn-sb3", *map(str, arguments)])
        with pytest.raises(SystemExit) as end:
            main()
        said = capsys.readouterr()
        return Said(said.out, said.err, int(end.value.code or 0))

    return run


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a tiny recipe and its finished runs."""
    folder = tmp_path_factory.mktemp("tiny")
    path = recipe(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["lawn-sb3", "reproduce", str(path)])
        with pytest.raises(SystemExit) as end:
            main()
    assert not end.value.code
    return folder


@pytest.fixture
def folder(reproduced: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it to work in, as ``runs``."""
    shutil.copytree(reproduced, tmp_path / "runs")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.usefixtures("folder")
def test_exported_runs_rebuild_the_same_report_byte_for_byte(lawn: Command) -> None:
    kept = lawn("export", "runs/tiny.yaml")
    assert kept.status == 0
    reference = Path("runs/reference/tiny")
    assert (reference / "mappo" / "seed-0" / "weights.npz").exists()
    assert (reference / "checks" / "hovering.csv").exists()
    assert not list(reference.rglob("model.zip"))
    before = {path.name: path.read_bytes() for path in (reference / "report").iterdir()}
    shutil.rmtree(reference / "report")
    shutil.rmtree("runs/tiny")
    again = lawn("report", "runs/tiny.yaml", "--runs", reference)
    assert again.status == 0
    assert {path.name: path.read_bytes() for path in (reference / "report").iterdir()} == before


@pytest.mark.usefixtures("folder")
def test_reproduce_ends_with_the_comparison_to_the_reference(lawn: Command) -> None:
    assert "no reference results" in lawn("reproduce", "runs/tiny.yaml").err
    lawn("export", "runs/tiny.yaml")
    done = lawn("reproduce", "runs/tiny.yaml")
    assert done.out.count("equal to the last digit") == 2  # both methods
    assert Path("runs/tiny/report/against_reference.md").exists()
    rows = Path("runs/reference/tiny/mappo/seed-0/evaluation.csv")
    lines = rows.read_text().splitlines()
    episode, uav, _, *others = lines[1].split(",")
    lines[1] = ",".join([episode, uav, "99", *others])
    rows.write_text("\n".join(lines) + "\n")
    assert lawn("reproduce", "runs/tiny.yaml").out.count("equal to the last digit") == 1


@pytest.mark.usefixtures("folder")
def test_a_report_without_runs_points_to_the_reference(lawn: Command) -> None:
    lawn("export", "runs/tiny.yaml")
    shutil.rmtree("runs/tiny")
    refused = lawn("report", "runs/tiny.yaml")
    assert refused.status == 2
    assert "--runs runs/reference/tiny" in refused.err


@pytest.mark.usefixtures("folder")
def test_an_unfinished_run_is_not_exported_and_what_is_kept_stays(lawn: Command) -> None:
    lawn("export", "runs/tiny.yaml")
    before = {path: path.read_bytes() for path in Path("runs/reference").rglob("*") if path.is_file()}
    Path("runs/tiny/mappo/seed-1/finished").unlink()
    refused = lawn("export", "runs/tiny.yaml")
    assert refused.status == 2
    assert "seed-1" in refused.err
    assert {path: path.read_bytes() for path in Path("runs/reference").rglob("*") if path.is_file()} == before


@pytest.mark.usefixtures("folder")
def test_a_folder_that_is_no_export_is_not_written_to(lawn: Command) -> None:
    Path("mine/report").mkdir(parents=True)
    Path("mine/report/notes.txt").write_text("keep me")
    refused = lawn("export", "runs/tiny.yaml", "--to", "mine")
    assert refused.status == 2
    assert "'mine' holds something else" in refused.err
    assert [path.name for path in Path("mine").rglob("*.*")] == ["notes.txt"]


@pytest.mark.usefixtures("folder")
def test_a_whole_run_is_verified_and_a_forged_one_is_not(lawn: Command) -> None:
    run = Path("runs/tiny/mappo/seed-0")
    whole = lawn("verify", run, "--json")
    assert whole.status == 0
    assert json.loads(whole.out)["rows_that_differ"] == 0
    rows = run / "evaluation.csv"
    text = rows.read_text()
    rows.write_text(text.replace("\n0,1,", "\n0,1,9", 1))
    forged = lawn("verify", run)
    assert forged.status == 1
    assert "1 of 16 rows" in forged.err
    rows.write_text(text[:200])
    assert lawn("verify", run).status == 2


@pytest.mark.usefixtures("folder")
def test_kept_weights_are_verified_too(lawn: Command) -> None:
    lawn("export", "runs/tiny.yaml")
    assert lawn("verify", "runs/reference/tiny/mappo/seed-0").status == 0
    assert "model was not kept" in lawn("verify", "runs/reference/tiny/mappo/seed-1").err
    assert lawn("verify", "runs/reference/tiny/random/seed-1").status == 0  # there is no model to be kept


@pytest.mark.usefixtures("folder")
def test_identify_prints_one_json_object_and_writes_a_page(lawn: Command) -> None:
    done = lawn("identify", "--episodes", "20", "--json", "--out", "found")
    assert done.status == 0
    assert json.loads(done.out)["episodes"] == 20
    assert json.loads(Path("found/identify.json").read_text())["findings"]
    assert Path("found/README.md").read_text(encoding="utf-8").startswith("# What the paper")
    assert "no trained players" in done.err


@pytest.mark.usefixtures("folder")
def test_a_training_that_fails_ends_with_one_line_and_status_1(lawn: Command) -> None:
    small = ["--env-steps", "128", "--num-games", "2", *QUICK, "--set", "max_slots=20", "--no-progress"]
    failed = lawn("train", *small, "-params", "target_kl=abc", "--out", "bad")
    assert failed.status == 1
    assert "training in 'bad' failed" in failed.err
    assert "Traceback" not in failed.err
