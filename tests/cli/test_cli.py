"""The command line: JSON alone on standard output, one clear line for an error, the right exit status."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from lawn_sb3.cli.commands import app
from lawn_sb3.experiment.benchmark import Speeds
from lawn_sb3.experiment.registry import PLANNERS, REPOSITORY
from lawn_sb3.scenario import PRESETS, load_scenario
from tests.cli.running import MAPPO, METHODS, QUICK, Lawn, recipe

APART = [sys.executable, "-m", "lawn_sb3"]
"""The command line in a process of its own."""


def test_help_shows_defaults_for_every_command(lawn: Lawn) -> None:
    listed = lawn("--help").out
    for command in app.registered_commands:
        name = str(command.name or command.callback.__name__)  # type: ignore[union-attr]
        assert name in listed
        only_switches = name in ("bench", "compare", "verify")
        assert only_switches or "default" in lawn(name, "--help").out


def test_evaluate_prints_one_json_object_and_nothing_else() -> None:
    command = [*APART, "evaluate", "--player", "random", "--episodes", "20", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    figures = json.loads(done.stdout)
    expected = "method scenario episodes seed reward rate_mbps makespan_slots completion_slots success_percent"
    assert {*expected.split(), "utility_mbps", "welfare_mbps"} <= set(figures)
    assert figures["episodes"] == 20


def test_a_model_is_trained_and_evaluated(lawn: Lawn, tmp_path: Path) -> None:
    run, rows = tmp_path / "run", tmp_path / "rows.csv"
    lawn("train", "--env-steps", "128", "--num-games", "2", *QUICK, "--set", "max_slots=20", "--out", run)
    evaluate = ("evaluate", "--run", run, "--episodes", "10", "--json")
    first = lawn(*evaluate).out
    assert json.loads(first)["method"] == "run"
    assert lawn(*evaluate).out == first
    assert lawn(*evaluate, "--sample", "--rows", rows).out != first
    assert len(rows.read_text().splitlines()) == 1 + 10 * 4
    assert "trained for 4 GBSs" in lawn("evaluate", "--run", run, "--set", "gbs_grid=[3, 3]", status=2).err


def test_reproduce_runs_what_is_missing_and_keeps_what_is_finished(lawn: Lawn, tmp_path: Path) -> None:
    path = recipe(tmp_path)
    assert "Table II" in lawn("reproduce", path).out
    assert (tmp_path / "tiny" / "report" / "README.md").exists()
    kept = (tmp_path / "tiny" / "mappo" / "seed-0" / "provenance.json").read_bytes()
    (tmp_path / "tiny" / "mappo" / "seed-1" / "finished").unlink()
    again = lawn("reproduce", path)
    assert "3 of 4 runs are finished already" in again.err
    assert (tmp_path / "tiny" / "mappo" / "seed-0" / "provenance.json").read_bytes() == kept
    assert lawn("report", path).out == again.out


def test_one_method_of_a_recipe_can_be_trained_alone_and_reproduce_takes_the_run(lawn: Lawn, tmp_path: Path) -> None:
    path = recipe(tmp_path, seeds=[0])
    train = ("train", "--recipe", path, "--method")
    lawn(*train, "mappo", "--seed", "0", "--out", tmp_path / "tiny" / "mappo" / "seed-0")
    assert "1 of 2 runs are finished already" in lawn("reproduce", path).err
    assert "did you mean 'mappo'" in lawn(*train, "mapo", "--out", tmp_path / "other", status=2).err


def test_a_failed_run_leaves_the_others_finished_and_status_1(lawn: Lawn, tmp_path: Path) -> None:
    bad = {**MAPPO, "label": "Bad", "settings": {**MAPPO["settings"], "learning_rate": 1e30}}
    done = lawn("reproduce", recipe(tmp_path, methods={**METHODS, "bad": bad}, seeds=[0]), status=1)
    assert "bad seed 0" in done.err
    assert "Traceback" not in done.err
    assert (tmp_path / "tiny" / "mappo" / "seed-0" / "finished").exists()
    assert "MAPPO" in done.out


def test_a_disk_without_room_for_a_model_loses_nothing_else(lawn: Lawn, tmp_path: Path) -> None:
    path = recipe(tmp_path, seeds=[0])
    most = 200_000  # bytes a file: enough for all but the model
    done = subprocess.run(
        [*APART, "reproduce", path],
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
    assert "1 of 2 runs are finished already" in lawn("reproduce", path).err


@pytest.mark.parametrize(
    ("number", "of_group", "heeds_interrupts", "status"),
    [
        (signal.SIGINT, True, True, 130),
        (signal.SIGTERM, False, False, 143),  # as a background job, which may ignore Ctrl-C
    ],
)
def test_an_interrupt_is_answered_and_the_same_command_goes_on(
    tmp_path: Path, number: signal.Signals, of_group: bool, heeds_interrupts: bool, status: int
) -> None:
    path = recipe(tmp_path, methods={"mappo": {**MAPPO, "env_steps": 400_000}}, seeds=[0])
    answer = signal.SIG_DFL if heeds_interrupts else signal.SIG_IGN
    process = subprocess.Popen(
        [*APART, "reproduce", path],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, answer),
    )
    run = tmp_path / "tiny" / "mappo" / "seed-0"
    for _ in range(3000):
        if (run / "progress.csv").exists() and (run / "progress.csv").read_text():
            break
        time.sleep(0.1)
    beside = subprocess.run([*APART, "reproduce", path], capture_output=True, text=True, check=False)
    assert beside.returncode == 1
    assert f"is being written by process {process.pid} on " in beside.stderr.splitlines()[-1]
    (os.killpg if of_group else os.kill)(process.pid, number)
    _, said = process.communicate(timeout=60)
    assert process.returncode == status
    assert "the same command goes on from there" in said.splitlines()[-1]
    assert "Traceback" not in said


def interrupted(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


def test_bench_keeps_what_it_measured_in_a_folder_that_it_makes(
    lawn: Lawn, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    row = {"grows": "games", "num_uavs": 4, "num_gbs": 4, "build_s": 0.1, "exponent": 1.0}
    growth = pd.DataFrame([{**row, "num_games": n, "agent_steps_per_s": 1e6 * n} for n in (1, 2)])
    speeds = Speeds({"simulator_ratio": 300.0}, growth)
    monkeypatch.setattr("lawn_sb3.experiment.benchmark.benchmark", lambda methods, quick, advance: speeds)
    lawn("bench", "--quick", "--out", str(tmp_path / "a" / "b"))
    kept = json.loads((tmp_path / "a" / "b" / "bench.json").read_text("utf-8"))
    assert (kept["figures"], kept["quick"], len(kept["growth"])) == ({"simulator_ratio": 300.0}, True, 2)
    assert {"versions", "hardware", "commit"} <= set(kept)
    assert (tmp_path / "a" / "b" / "growth.png").stat().st_size > 0


@pytest.mark.parametrize(
    ("arguments", "work"),
    [
        ("evaluate --player random", "experiment.evaluation.fly"),
        ("verify runs/reference/paper/random/seed-0", "experiment.verification.verify_run"),
        ("plan --player welfare", "experiment.plan_episodes.plan_episodes"),
        ("ceiling", "experiment.ceilings.ceilings"),
        ("identify", "paper.identification.identify"),
        ("bench", "experiment.benchmark.benchmark"),
        ("report --runs runs/reference/paper", "report.contents.build_report"),
        ("reproduce", "cli.recipes.run_cells"),
    ],
)
def test_an_interrupt_of_any_command_ends_with_one_line_and_status_130(
    lawn: Lawn, monkeypatch: pytest.MonkeyPatch, arguments: str, work: str
) -> None:
    monkeypatch.chdir(REPOSITORY)
    monkeypatch.setattr("lawn_sb3.cli.recipes._try_methods", lambda todo: None)
    monkeypatch.setattr(f"lawn_sb3.{work}", interrupted)
    said = lawn(*arguments.split(), status=130).err
    assert said.splitlines()[-1].startswith("lawn-sb3: interrupted")
    assert "Traceback" not in said


def terminated(*_: object, **__: object) -> None:
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(60)


def test_a_termination_ends_in_order_too_also_where_interrupts_are_ignored(
    lawn: Lawn, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lawn_sb3.experiment.evaluation.fly", terminated)
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    said = lawn("evaluate", "--player", "random", status=143).err
    signal.signal(signal.SIGINT, before)
    assert said == "lawn-sb3: interrupted; what was not finished is not kept, the same command begins anew\n"


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ("evaluate", "either --run DIR or --player NAME"),
        ("evaluate --player randon", "did you mean 'random'"),
        ("evaluate --player random --scenario papre", "did you mean 'paper'"),
        ("evaluate --player random --set rb_bandwidth_hz=-5", "rb_bandwidth_hz = -5"),
        ("evaluate --player random --set num_uav=5", "did you mean 'num_uavs'"),
        ("evaluate --player random --set num_uavs", "expected key=value"),
        ("evaluate --player bound --episodes 5 --regret", "never meet"),
        ("evaluate --run nowhere", "holds no run"),
        ("train --out x --algo mapo", "did you mean 'mappo'"),
        ("train --out x --policy stat_critic", "did you mean 'state_critic'"),
        ("train --out x -params gama=1", "did you mean 'gamma'"),
        ("reproduce nowhere.yaml", "nowhere.yaml"),
        ("report nowhere.yaml", "nowhere.yaml"),
        ("ablate state_critic", "recipe 'ablation' has policy 'state_critic' already"),  # found from any folder
        ("plan --player equilibrum", f"did you mean 'equilibrium'?); known: {', '.join(sorted(PLANNERS))}"),
        # From corner to corner of 10 x 10 x 3 voxels are 20 steps, 7 slots: of 400 missions some take more than 4.
        ("plan --player equilibrium --episodes 100 --set max_slots=4", "cannot fly its mission"),
        (
            "plan --player best-route --rows nowhere/rows.csv",
            "lawn-sb3: 'nowhere/rows.csv' cannot be written: there is no folder 'nowhere'\n",
        ),
        ("ceiling --scenario paper", "num_uavs = 4: the ceiling is worked out for 2 UAVs"),
        ("ceiling --player forcast", "did you mean 'forecast'"),
        ("ceiling --run nowhere", "nowhere"),
        (f"ceiling --run {REPOSITORY}/runs/reference/paper/mappo/seed-0", "was trained on 'paper', not on 'tiny'"),
    ],
)
def test_bad_input_gets_one_line_and_status_2(
    lawn: Lawn, arguments: str, expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert expected in lawn(*arguments.split(), status=2).err
    assert not list(tmp_path.iterdir())


def test_a_file_that_cannot_be_written_is_named_with_status_1(lawn: Lawn, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    path = tmp_path / "file" / "rows.csv"
    said = lawn("evaluate", "--player", "random", "--episodes", "2", "--rows", path, status=1).err
    assert str(path) in said
    assert len(said.splitlines()) == 1


def test_rows_written_through_a_link_go_where_it_points(lawn: Lawn, tmp_path: Path) -> None:
    (tmp_path / "link.csv").symlink_to(tmp_path / "rows.csv")
    lawn("evaluate", "--player", "random", "--episodes", "2", "--rows", tmp_path / "link.csv")
    assert (tmp_path / "link.csv").is_symlink()
    assert len((tmp_path / "rows.csv").read_text().splitlines()) == 1 + 2 * 4


def test_a_folder_that_holds_something_else_is_not_trained_into(lawn: Lawn, tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("keep me", encoding="utf-8")
    assert "holds other files than a run's" in lawn("train", "--out", tmp_path, status=2).err
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_a_scenario_is_printed_as_yaml_that_reads_back(lawn: Lawn, tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text(lawn("scenario", "as-printed", "--set", "num_uavs=8", "--yaml").out)
    assert load_scenario(str(tmp_path / "mine.yaml")) == PRESETS["as-printed"].changed(num_uavs=8)
