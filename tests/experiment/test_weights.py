"""Weights without code: they play as the model did, and a damaged file is named in one line."""

import zipfile
from pathlib import Path

import numpy as np
import pytest
import torch as th
from safetensors.torch import load_file

from lawn_sb3.errors import UserError
from lawn_sb3.experiment import weights
from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.players import ModelPlayer, load_player
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.experiment.weights import load_weights, save_tensors, save_weights
from tests.experiment import training


@pytest.fixture
def iql_cell(tmp_path: Path) -> Cell:
    """Four small Q-networks and their targets."""
    return training.iql_cell(tmp_path / "iql")


def test_weights_come_back_and_targets_equal_what_they_follow(iql_cell: Cell, tmp_path: Path) -> None:
    model, other = build_model(iql_cell), build_model(iql_cell)
    for value in model.policy.state_dict().values():
        value.uniform_(-1.0, 1.0)
    save_weights(model, tmp_path / "w.npz")
    load_weights(other, tmp_path / "w.npz")
    for name, value in other.policy.state_dict().items():
        assert th.equal(value, model.policy.state_dict()[name.replace("_target", "")]), name


def test_the_file_holds_arrays_alone_and_no_target(iql_cell: Cell, tmp_path: Path) -> None:
    save_weights(build_model(iql_cell), tmp_path / "w.npz")
    with np.load(tmp_path / "w.npz", allow_pickle=False) as stored:
        assert stored.files
        assert all(stored[name].dtype == np.float32 for name in stored.files)
        assert not any("target" in name for name in stored.files)


def test_equal_models_give_equal_bytes(iql_cell: Cell, tmp_path: Path) -> None:
    for name in ("one.npz", "two.npz"):
        save_weights(build_model(iql_cell), tmp_path / name)
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()


def test_networks_too_large_are_stored_in_half_precision(
    iql_cell: Cell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(weights, "MOST_BYTES", 1_000)
    model, other = build_model(iql_cell), build_model(iql_cell)
    save_weights(model, tmp_path / "w.npz")
    load_weights(other, tmp_path / "w.npz")
    own, loaded = model.policy.state_dict(), other.policy.state_dict()
    for name in own:
        # float16 has 11 significant bits, so rounding moves a number by at most 2^-11 of itself.
        if "target" not in name:
            assert th.allclose(own[name], loaded[name], rtol=2**-11, atol=1e-7)


@pytest.mark.parametrize("keep", [0, 100, 3_000])
def test_a_truncated_file_is_named_in_one_line(iql_cell: Cell, tmp_path: Path, keep: int) -> None:
    path = tmp_path / "w.npz"
    save_weights(build_model(iql_cell), path)
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(UserError, match=r"w\.npz' is not a whole model") as refusal:
        load_weights(build_model(iql_cell), path)
    assert "\n" not in str(refusal.value)


def test_a_pickle_inside_is_refused(iql_cell: Cell, tmp_path: Path) -> None:
    path = tmp_path / "w.npz"
    np.savez(path, **{"policy": np.array([{"code": 1}], dtype=object)}, allow_pickle=True)
    assert zipfile.is_zipfile(path)
    with pytest.raises(UserError, match="not a whole model"):
        load_weights(build_model(iql_cell), path)


def test_another_methods_weights_are_refused(iql_cell: Cell, small_cell: Cell, tmp_path: Path) -> None:
    save_weights(build_model(small_cell), tmp_path / "w.npz")
    with pytest.raises(UserError, match="it lacks"):
        load_weights(build_model(iql_cell), tmp_path / "w.npz")


LEARNERS = {
    "mappo": (training.mappo_cell, {"mlp_extractor", "action_net", "value_net"}),
    "iql": (training.iql_cell, {"learners.0", "learners.1", "learners.2", "learners.3"}),
    "qmix": (training.qmix_cell, {"q_net", "mixer"}),
}
"""How a cell is made, and what the names of its tensors begin with."""


@pytest.mark.parametrize("learner", LEARNERS)
def test_the_safetensors_of_a_run_are_the_networks_of_its_model(learner: str, tmp_path: Path) -> None:
    make, parts = LEARNERS[learner]
    cell = make(tmp_path / "run")
    run_cell(cell, training.ignore)
    player = load_player(cell)
    assert isinstance(player, ModelPlayer)
    networks = {name: value for name, value in player.model.policy.state_dict().items() if "_target" not in name}
    tensors = load_file(cell.directory / "weights.safetensors")
    assert tensors.keys() == networks.keys()
    assert all(th.equal(value, tensors[name]) for name, value in networks.items())
    assert {name: value.dtype for name, value in networks.items()} == {name: own.dtype for name, own in tensors.items()}
    words = 2 if learner == "iql" else 1
    assert {".".join(name.split(".")[:words]) for name in tensors} == parts


def test_tensors_that_share_memory_are_all_kept(iql_cell: Cell, tmp_path: Path) -> None:
    model = build_model(iql_cell)
    model.policy.again = model.policy.get_submodule("learners.0")
    save_tensors(model, tmp_path / "w.safetensors")
    tensors = load_file(tmp_path / "w.safetensors")
    first = [name for name in tensors if name.startswith("learners.0.")]
    assert first
    assert all(th.equal(tensors[name], tensors[name.replace("learners.0.", "again.")]) for name in first)
