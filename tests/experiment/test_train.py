"""A cell's run: complete, repeatable to the byte, and resumed after an interruption as if nothing had happened."""

import json
import pickle
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
import yaml
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from lawn_sb3.errors import Notice, UserError
from lawn_sb3.experiment import checkpoint
from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.cell import Cell, cells
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.recipe import Method, load_recipe
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.experiment.run_directory.configuration import is_finished, load_run
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.scenario import Scenario
from tests.experiment.payload import Payload
from tests.experiment.training import assert_equal_runs, ignore, interrupt, mappo_cell, qmix_cell, resumed


def test_a_run_holds_configuration_provenance_curve_log_model_and_rows(small_cell: Cell) -> None:
    run_cell(small_cell, ignore)
    assert is_finished(small_cell)
    names = {path.name for path in small_cell.directory.iterdir()}
    assert names == {
        "config.yaml", "provenance.json", "progress.csv", "tensorboard", "model.zip", "finished", "evaluation.csv",
        "evaluation_sampled.csv", "slots.csv", "paths.csv", "manifest.json", "weights.safetensors", "README.md",
    }  # fmt: skip
    provenance = json.loads((small_cell.directory / "provenance.json").read_text())
    assert provenance["versions"]["stable-baselines3"]
    assert provenance["train_seconds"] > 0
    curve = pd.read_csv(small_cell.directory / "progress.csv")
    assert curve["time/env_steps"].tolist() == [64, 128, 192, 256]  # 2 games x 32 slots a rollout
    assert {"missions/success_percent", "greedy/success_percent", "train/value_loss"} <= set(curve)
    rows = pd.read_csv(small_cell.directory / "evaluation.csv")
    assert len(rows) == small_cell.evaluation.episodes * small_cell.scenario.num_uavs


def test_a_policy_is_probed_again_once_it_is_trained(small_cell: Cell, monkeypatch: pytest.MonkeyPatch) -> None:
    probed: list[int] = []
    probe = "lawn_sb3.experiment.train.check_policy"
    monkeypatch.setattr(probe, lambda model, name: probed.append(model.num_timesteps))
    run_cell(small_cell, ignore)
    assert probed == [256 * small_cell.scenario.num_uavs]


def test_regrets_are_watched_where_they_are_asked_for(small_cell: Cell) -> None:
    run_cell(replace(small_cell, regret=True), ignore)
    watched = pd.read_csv(small_cell.directory / "progress.csv").dropna(subset=["greedy/utility_mbps"])
    assert (watched["greedy/regret_mbps"] >= 0.0).all()
    assert (watched["greedy/nash_gap_mbps"] >= watched["greedy/regret_mbps"]).all()  # the largest of each episode


def test_equal_cells_leave_equal_bytes(small_cell: Cell, tmp_path: Path) -> None:
    twin = replace(small_cell, directory=tmp_path / "twin")
    for cell in (small_cell, twin):
        run_cell(cell, ignore)
    assert_equal_runs(small_cell, twin)


@pytest.mark.usefixtures("often")
def test_tensorboard_shows_the_curve_once_against_env_steps(small_cell: Cell) -> None:
    resumed(small_cell, 192)
    events = EventAccumulator(str(small_cell.directory / "tensorboard")).Reload()
    curve = pd.read_csv(small_cell.directory / "progress.csv")
    for name in ("greedy/success_percent", "train/value_loss"):
        rows = curve[["time/env_steps", name]].dropna()
        points = [(event.step, event.value) for event in events.Scalars(name)]
        assert [step for step, _ in points] == rows["time/env_steps"].tolist()
        assert [value for _, value in points] == pytest.approx(rows[name].tolist(), rel=1e-6)


@pytest.mark.usefixtures("often")
def test_the_seconds_before_an_interruption_count(small_cell: Cell) -> None:
    interrupt(small_cell, 192)
    assert not is_finished(small_cell)
    before = checkpoint.read_checkpoint(small_cell)["watch"].seconds  # type: ignore[index]
    run_cell(small_cell, ignore)
    record = json.loads((small_cell.directory / "provenance.json").read_text())
    assert record["train_seconds"] >= round(before, 1)


@pytest.mark.usefixtures("often")
def test_a_damaged_checkpoint_is_named_and_the_training_starts_anew(small_cell: Cell) -> None:
    interrupt(small_cell, 128)
    path = small_cell.directory / "checkpoint.bin"
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.warns(Notice, match=r"checkpoint\.bin'; the training starts anew"):
        run_cell(small_cell, ignore)
    assert is_finished(small_cell)


@pytest.mark.usefixtures("often")
def test_a_checkpoint_of_an_earlier_version_is_named_and_not_read(small_cell: Cell) -> None:
    small_cell.directory.mkdir(parents=True)
    (small_cell.directory / "checkpoint.pt").write_bytes(pickle.dumps(Payload(small_cell.directory.parent / "ran")))
    with pytest.warns(Notice, match=r"checkpoint\.pt' is of an earlier version and not read; the training starts anew"):
        run_cell(small_cell, ignore)
    assert {path.name for path in small_cell.directory.parent.iterdir()} == {small_cell.directory.name}
    assert not (small_cell.directory / "checkpoint.pt").exists()


@pytest.mark.usefixtures("often")
def test_a_checkpoint_of_other_settings_is_not_used(small_cell: Cell) -> None:
    interrupt(small_cell, 128)
    other = replace(small_cell, seed=4)
    reports: list[int] = []
    run_cell(other, reports.append)
    assert reports[0] == 0


def test_nothing_of_another_configuration_stays_in_an_interrupted_run(small_cell: Cell) -> None:
    run_cell(small_cell, ignore)
    other = replace(small_cell, seed=4)
    interrupt(other, 128)
    for name in ("model.zip", "weights.safetensors", "README.md"):
        assert not (small_cell.directory / name).exists()
    assert not (small_cell.directory / "evaluation.csv").exists()
    assert not is_finished(other)


def test_an_edited_policy_is_another_configuration(
    small_cell: Cell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = (REPOSITORY / "policies" / "state_critic.py").read_text(encoding="utf-8")
    (tmp_path / "policies").mkdir()
    path = tmp_path / "policies" / "edited.py"
    path.write_text(source, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    cell = replace(small_cell, method=small_cell.method.model_copy(update={"policy": "edited"}))
    before = cell.fingerprint()
    path.write_text(source + "\n# another line\n", encoding="utf-8")
    assert cell.fingerprint() == before  # this process goes on with what it has imported
    monkeypatch.setattr("lawn_sb3.experiment.policy_digest._DIGESTS", {})  # as in another process
    assert cell.fingerprint() != before
    assert "policies.edited" not in sys.modules  # nothing is imported to tell


@pytest.mark.parametrize(
    "method", ["paper/iql", "paper/random", "ablation/iql", "ablation/mappo", "ladder/clock", "ladder/taught"]
)
def test_a_kept_run_of_an_earlier_version_counts_for_as_long_as_no_result_has_changed(method: str) -> None:
    recipe, key = method.split("/")
    kept = cells(load_recipe(REPOSITORY / "runs" / f"{recipe}.yaml"), REPOSITORY / "runs" / "reference" / recipe)
    assert all(is_finished(cell) for cell in kept if cell.key == key)


def test_a_field_that_is_new_leaves_finished_runs_finished_and_a_changed_value_does_not(small_cell: Cell) -> None:
    run_cell(small_cell, ignore)
    path = small_cell.directory / "config.yaml"
    kept = yaml.safe_load(path.read_text())
    del kept["evaluation"]["traced_episodes"]  # as if it had been made before there was such a field
    path.write_text(yaml.safe_dump(kept))
    assert is_finished(small_cell)
    kept["scenario"]["ema_beta"] = 0.2  # as if that had been the default when it was made
    path.write_text(yaml.safe_dump(kept))
    assert not is_finished(small_cell)


def test_a_default_that_is_spelt_out_does_not_count_in_the_fingerprint(small_cell: Cell) -> None:
    values = small_cell.method.model_dump(exclude_unset=True)
    assert "continuation" in values
    bare = Method.model_validate({key: value for key, value in values.items() if key not in ("continuation", "policy")})
    assert replace(small_cell, method=bare).fingerprint() == small_cell.fingerprint()


@pytest.mark.parametrize("keep", [0, 200, 5000])
def test_a_truncated_model_is_named_in_one_line(small_cell: Cell, keep: int) -> None:
    run_cell(small_cell, ignore)
    path = small_cell.directory / "model.zip"
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(UserError, match=r"model\.zip") as refusal:
        load_player(small_cell)
    assert "\n" not in str(refusal.value)


def test_a_model_of_another_method_is_refused(small_cell: Cell) -> None:
    run_cell(small_cell, ignore)
    other = small_cell.method.model_copy(update={"policy": "state_critic"})
    with pytest.raises(UserError, match="not a whole model of this method"):
        load_player(replace(small_cell, method=other))


def test_a_folder_without_a_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="holds no run"):
        load_run(tmp_path)
    (tmp_path / "config.yaml").write_text("seed: 1\n")
    with pytest.raises(UserError, match="not the configuration of a run"):
        load_run(tmp_path)


@pytest.mark.parametrize(
    ("make", "changes", "expected"),
    [
        (mappo_cell, {"settings": {"device": "gpu7"}}, "mappo refuses its settings"),
        (qmix_cell, {"continuation": "mission"}, "qmix refuses its settings: .*continuation='episode'"),
    ],
)
def test_settings_an_algorithm_refuses_are_named(
    tmp_path: Path, make: Callable[[Path], Cell], changes: dict[str, object], expected: str
) -> None:
    cell = make(tmp_path)
    with pytest.raises(UserError, match=expected):
        build_model(replace(cell, method=cell.method.model_copy(update=changes)))


def test_a_player_without_training_leaves_rows_too(small_cell: Cell, tmp_path: Path) -> None:
    player = Method(label="Random", player="random")
    random = Cell("random", player, 0, Scenario(), small_cell.evaluation, tmp_path / "r")
    run_cell(random, ignore)
    assert is_finished(random)
    for name in ("model.zip", "weights.safetensors", "README.md"):
        assert not (tmp_path / "r" / name).exists()
