"""Any single bit of a checkpoint may flip, and any part of it be cut off: it is named, and the one before is used."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lawn_sb3.errors import Notice
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.checkpoint import read_checkpoint
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
