"""Any single bit of a checkpoint may flip, and any part of it be cut off: it is named, and the one before is used."""

import hashlib
import io
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lawn_sb3.errors import Notice
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.checkpoint import read_checkpoint
from tests.experiment.payload import Payload
from tests.experiment.training import interrupt, iql_cell, mappo_cell, qmix_cell, resumed

LEARNERS = {"mappo": (mappo_cell, 256), "iql": (iql_cell, 26), "qmix": (qmix_cell, 60)}
"""How a cell is made, and after how many env steps it has two checkpoints."""


def damaged(content: bytes, chance: np.random.Generator) -> bytes:
    """With one bit flipped, or cut off."""
    at = int(chance.integers(len(content)))
    if chance.random() < 0.2:
        return content[:at]
    return content[:at] + bytes([content[at] ^ 1 << int(chance.integers(8))]) + content[at + 1 :]


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("learner", LEARNERS)
def test_no_damage_goes_unnoticed_and_the_checkpoint_before_is_used(learner: str, tmp_path: Path) -> None:
    make, limit = LEARNERS[learner]
    cell = make(tmp_path / "run")
    interrupt(cell, limit)
    newest, before = (cell.directory / name for name in ("checkpoint.bin", "checkpoint_before.bin"))
    content, chance = newest.read_bytes(), np.random.default_rng(0)
    whole, earlier = steps(cell), steps(cell, without=newest)
    assert earlier < whole
    for _ in range(200):
        newest.write_bytes(damaged(content, chance))
        with pytest.warns(Notice, match=r"checkpoint\.bin'; the one before is used"):
            assert steps(cell) == earlier
    before.write_bytes(damaged(before.read_bytes(), chance))
    with pytest.warns(Notice, match="starts anew"):
        assert read_checkpoint(cell) is None


def steps(cell: Cell, without: Path | None = None) -> int:
    """Agent steps trained when the checkpoint was written that is read."""
    if without is not None:
        aside = without.rename(without.with_suffix(".aside"))
    state = read_checkpoint(cell)
    assert state is not None
    if without is not None:
        aside.rename(without)
    return int(state["attributes"]["num_timesteps"])


@pytest.mark.usefixtures("often")
@pytest.mark.filterwarnings("ignore::lawn_sb3.errors.Notice")
@pytest.mark.parametrize(("make", "limit"), [(mappo_cell, 192), (iql_cell, 26)])
def test_a_training_resumed_from_the_checkpoint_before_leaves_the_same_bytes(
    make: Callable[[Path], Cell], limit: int, tmp_path: Path
) -> None:
    def damage(cell: Cell) -> None:
        path = cell.directory / "checkpoint.bin"
        path.write_bytes(damaged(path.read_bytes(), np.random.default_rng(1)))

    assert 0 < resumed(make(tmp_path / "run"), limit, damage)[0] < limit - 1


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("member", ["tree", "0"])
def test_a_pickled_array_is_refused_though_its_digest_is_right(member: str, tmp_path: Path) -> None:
    cell, trace = mappo_cell(tmp_path / "run"), tmp_path / "ran"
    interrupt(cell, 192)
    newest = cell.directory / "checkpoint.bin"
    earlier = steps(cell, without=newest)
    with np.load(io.BytesIO(newest.read_bytes()[32:])) as stored:
        members = dict(stored)
    assert member in members
    planted = io.BytesIO()
    np.savez(planted, allow_pickle=True, **{**members, member: np.array([Payload(trace)], dtype=object)})
    newest.write_bytes(hashlib.sha256(planted.getvalue()).digest() + planted.getvalue())
    with pytest.warns(Notice, match=r"checkpoint\.bin'; the one before is used"):
        assert steps(cell) == earlier
    assert not trace.exists()
    pickle.loads(pickle.dumps(Payload(trace)))
    assert trace.exists()  # so that it would have been seen


FORGED = {
    "no archive": b"nothing",
    "no tree": {"0": np.zeros(1)},
    "no JSON": {"tree": np.frombuffer(b"{", np.uint8)},
    "no state": {"tree": np.frombuffer(b"[1]", np.uint8)},
    "no fingerprint": {"tree": np.frombuffer(b'{"mapping": []}', np.uint8)},
    "no array": {"tree": np.frombuffer(b'{"mapping": [["fingerprint", {"array": "1"}]]}', np.uint8)},
    "no end": {"tree": np.frombuffer(b"[" * 100_000, np.uint8)},
}
"""What somebody may write below a right digest."""


@pytest.mark.parametrize("content", FORGED.values(), ids=FORGED)
def test_what_is_no_checkpoint_is_refused_though_its_digest_is_right(
    content: bytes | dict[str, np.ndarray], tmp_path: Path
) -> None:
    cell, archive = mappo_cell(tmp_path / "run"), io.BytesIO()
    if isinstance(content, bytes):
        archive.write(content)
    else:
        np.savez(archive, allow_pickle=False, **content)
    cell.directory.mkdir()
    (cell.directory / "checkpoint.bin").write_bytes(hashlib.sha256(archive.getvalue()).digest() + archive.getvalue())
    with pytest.warns(Notice, match=r"checkpoint\.bin'; the training starts anew"):
        assert read_checkpoint(cell) is None
