"""The command line: JSON alone on standard output, one clear line for an error, the right exit status."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

from lawn_sb3.cli import main
from lawn_sb3.scenario import PRESETS, load_scenario

QUICK = ["-params", "n_steps=32", "-params", "batch_size=64", "-params", "n_epochs=1"]
TINY_RECIPE = {
    "seeds": [0, 1],
    "set": ["max_slots=20"],
    "evaluation": {"episodes": 4, "record_every": 1, "watch_every": 200, "watch_episodes": 2},
    "methods": {
        "random": {"label": "Random", "paper_row": "Random", "player": "random"},
        "mappo": {
            "label": "MAPPO",
            "algo": "mappo",
            "env_steps": 128,
            "num_games": 2,
            "settings": {"n_steps": 32, "batch_size": 64, "n_epochs": 1},
        },
    },
}


def lawn(*arguments: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run the command line in a process of its own."""
    command = [sys.executable, "-m", "lawn_sb3", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=cwd, check=False)


def recipe(folder: Path, **changes: object) -> Path:
    """A recipe that runs in seconds."""
    path = folder / "tiny.yaml"
    path.write_text(yaml.safe_dump({**TINY_RECIPE, **changes}, sort_keys=False), encoding="utf-8")
    return path


def test_help_shows_defaults_for_every_command() -> None:
    listed = lawn("--help")
    assert listed.returncode == 0
    for command in (
        "train",
        "evaluate",
        "plan",
        "verify",
        "reproduce",
        "ablate",
        "report",
        "export",
        "tune",
        "identify",
        "bench",
        "scenario",
    ):
        assert command in listed.stdout
        shown = lawn(command, "--help")
        assert shown.returncode == 0
        assert "default" in shown.stdout or command in ("bench", "verify")  # whose options are switches


def test_evaluate_prints_one_json_object_and_nothing_else() -> None:
    done = lawn("evaluate", "--player", "random", "--episodes", "20", "--json")
    assert done.returncode == 0
    figures = json.loads(done.stdout)
    expected = "method scenario episodes seed reward rate_mbps makespan_slots completion_slots success_percent"
    assert {*expected.split(), "utility_mbps", "welfare_mbps"} <= set(figures)
    assert figures["episodes"] == 20


def test_a_model_is_trained_and_evaluated(tmp_path: Path) -> None:
    run = tmp_path / "run"
    done = lawn("train", "--env-steps", "128", "--num-games", "2", *QUICK, "--set", "max_slots=20", "--out", run)
    assert done.returncode == 0, done.stderr
    first = lawn("evaluate", "--run", run, "--episodes", "10", "--json")
    assert json.loads(first.stdout)["method"] == "run"
    assert first.stdout == lawn("evaluate", "--run", run, "--episodes", "10", "--json").stdout
    rows = tmp_path / "rows.csv"
    sampled = lawn("evaluate", "--run", run, "--episodes", "10", "--sample", "--json", "--rows", rows)
    assert sampled.stdout != first.stdout
    assert len(rows.read_text().splitlines()) == 1 + 10 * 4
    elsewhere = lawn("evaluate", "--run", run, "--set", "gbs_grid=[3, 3]")
    assert elsewhere.returncode == 2
    assert "trained for 4 GBSs" in elsewhere.stderr


def test_reproduce_runs_what_is_missing_and_keeps_what_is_finished(tmp_path: Path) -> None:
    path = recipe(tmp_path)
    done = lawn("reproduce", path)
    assert done.returncode == 0, done.stderr
    assert "Table II" in done.stdout
    assert (tmp_path / "tiny" / "report" / "README.md").exists()
    kept = (tmp_path / "tiny" / "mappo" / "seed-0" / "provenance.json").read_bytes()
    (tmp_path / "tiny" / "mappo" / "seed-1" / "finished").unlink()
    again = lawn("reproduce", path)
    assert "3 of 4 runs are finished already" in again.stderr
    assert (tmp_path / "tiny" / "mappo" / "seed-0" / "provenance.json").read_bytes() == kept
    report = lawn("report", path)
    assert report.returncode == 0
    assert report.stdout == again.stdout


def test_one_method_of_a_recipe_can_be_trained_alone_and_reproduce_takes_the_run(tmp_path: Path) -> None:
    path = recipe(tmp_path, seeds=[0])
    run = tmp_path / "tiny" / "mappo" / "seed-0"
    trained = lawn("train", "--recipe", path, "--method", "mappo", "--seed", "0", "--out", run)
    assert trained.returncode == 0, trained.stderr
    assert "1 of 2 runs are finished already" in lawn("reproduce", path).stderr
    unknown = lawn("train", "--recipe", path, "--method", "mapo", "--out", tmp_path / "other")
    assert unknown.returncode == 2
    assert "did you mean 'mappo'" in unknown.stderr


def test_a_failed_run_leaves_the_others_finished_and_status_1(tmp_path: Path) -> None:
    bad = {"label": "Bad", "algo": "mappo", "env_steps": 128, "num_games": 2, "settings": {"target_kl": "abc"}}
    path = recipe(tmp_path, methods={**TINY_RECIPE["methods"], "bad": bad}, seeds=[0])  # type: ignore[dict-item]
    done = lawn("reproduce", path)
    assert done.returncode == 1
    assert "bad seed 0" in done.stderr
    assert "Traceback" not in done.stderr
    assert (tmp_path / "tiny" / "mappo" / "seed-0" / "finished").exists()
    assert "MAPPO" in done.stdout


def test_a_disk_without_room_for_a_model_loses_nothing_else(tmp_path: Path) -> None:
    path = recipe(tmp_path, seeds=[0])
    command = [sys.executable, "-m", "lawn_sb3", "reproduce", str(path)]
    most = 200_000  # bytes a file: enough for all but the model
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)),
    )
    assert done.returncode == 1
    assert "mappo seed 0: OSError" in done.stderr
    assert "finished runs are kept" in done.stderr
    assert "Traceback" not in done.stderr
    assert (tmp_path / "tiny" / "random" / "seed-0" / "finished").exists()
    assert not list(tmp_path.rglob("*part*"))
    again = lawn("reproduce", path)
    assert again.returncode == 0
    assert "1 of 2 runs are finished already" in again.stderr


def test_an_interrupt_is_answered_and_the_same_command_goes_on(tmp_path: Path) -> None:
    methods = {"mappo": {**TINY_RECIPE["methods"]["mappo"], "env_steps": 400_000}}  # type: ignore[index]
    path = recipe(tmp_path, methods=methods, seeds=[0])
    command = [sys.executable, "-m", "lawn_sb3", "reproduce", str(path)]
    process = subprocess.Popen(
        command,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a background job may ignore it
    )
    progress = tmp_path / "tiny" / "mappo" / "seed-0" / "progress.csv"
    for _ in range(600):
        if progress.exists() and progress.read_text():
            break
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "interrupted" in said
    assert "Traceback" not in said


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["evaluate"], "either --run DIR or --player NAME"),
        (["evaluate", "--player", "randon"], "did you mean 'random'"),
        (["evaluate", "--player", "random", "--scenario", "papre"], "did you mean 'paper'"),
        (["evaluate", "--player", "random", "--set", "rb_bandwidth_hz=-5"], "rb_bandwidth_hz = -5"),
        (["evaluate", "--player", "random", "--set", "num_uav=5"], "did you mean 'num_uavs'"),
        (["evaluate", "--player", "random", "--set", "num_uavs"], "expected key=value"),
        (["evaluate", "--run", "nowhere"], "holds no run"),
        (["train", "--out", "x", "--algo", "mapo"], "did you mean 'mappo'"),
        (["train", "--out", "x", "--policy", "stat_critic"], "did you mean 'state_critic'"),
        (["train", "--out", "x", "-params", "gama=1"], "did you mean 'gamma'"),
        (["reproduce", "nowhere.yaml"], "nowhere.yaml"),
        (["report", "nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_bad_input_gets_one_line_and_status_2(
    arguments: list[str],
    expected: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["lawn-sb3", *arguments])
    with pytest.raises(SystemExit) as end:
        main()
    said = capsys.readouterr()
    assert end.value.code == 2
    assert expected in said.err
    assert len(said.err.strip().splitlines()) == 1
    assert said.out == ""
    assert not (tmp_path / "x").exists()


def test_a_file_that_cannot_be_written_is_named_with_status_1(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    path = tmp_path / "file" / "rows.csv"
    done = lawn("evaluate", "--player", "random", "--episodes", "2", "--rows", path)
    assert done.returncode == 1
    assert str(path) in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


def test_rows_written_through_a_link_go_where_it_points(tmp_path: Path) -> None:
    (tmp_path / "link.csv").symlink_to(tmp_path / "rows.csv")
    done = lawn("evaluate", "--player", "random", "--episodes", "2", "--rows", tmp_path / "link.csv")
    assert done.returncode == 0
    assert (tmp_path / "link.csv").is_symlink()
    assert len((tmp_path / "rows.csv").read_text().splitlines()) == 1 + 2 * 4


def test_a_folder_that_holds_something_else_is_not_trained_into(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("keep me", encoding="utf-8")
    done = lawn("train", "--out", tmp_path)
    assert done.returncode == 2
    assert "holds other files than a run's" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_a_scenario_is_printed_as_yaml_that_reads_back(tmp_path: Path) -> None:
    done = lawn("scenario", "as-printed", "--set", "num_uavs=8", "--yaml")
    (tmp_path / "mine.yaml").write_text(done.stdout)
    assert load_scenario(str(tmp_path / "mine.yaml")) == PRESETS["as-printed"].changed(num_uavs=8)
