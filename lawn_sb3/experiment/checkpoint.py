"""Checkpoints: everything that an interrupted training needs to go on as if nothing had happened.

A checkpoint is a SHA-256 and an archive of arrays, one of which is JSON; nothing in it is code. The last two are kept.
"""

import hashlib
import io
import json
import random
import warnings
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
import torch as th
from sb3_contrib.common.recurrent.type_aliases import RNNStates
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback

from lawn_sb3.algos.common.plain import Arrays, Kinds, from_plain, to_plain
from lawn_sb3.envs import FlatVecEnv
from lawn_sb3.errors import Notice
from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.run_directory.files import CHECKPOINT_BEFORE_FILE, CHECKPOINT_FILE, PROGRESS_FILE
from lawn_sb3.experiment.watching import Watch, WatchState
from lawn_sb3.game.simulator import Snapshot
from lawn_sb3.game.state import State
from lawn_sb3.whole_files import whole_file

PENDING = ("name_to_value", "name_to_count", "name_to_excluded")
"""Where SB3's logger keeps what it has not written yet."""


def _made_in_order(kind: type) -> Callable[[Any], Any]:
    """What makes a tuple with names of its values."""
    return lambda of: kind(*of)


NAMED: Kinds = {kind.__name__: (kind, list, _made_in_order(kind)) for kind in (Snapshot, State, WatchState, RNNStates)}
"""Tuples with names that a checkpoint holds."""
TREE = "tree"
"""The array that holds the JSON."""
OF_OLD = "checkpoint.pt"
"""What earlier versions wrote, as a pickle; it is not read."""


@runtime_checkable
class HasMemory(Protocol):
    """An algorithm that keeps experience from one update to the next, which SB3 does not save with the model."""

    def memory(self) -> Any:
        """What it keeps.

        :return: arrays, tensors, numbers and texts, and what is made of them
        """

    def restore_memory(self, memory: Any) -> None:
        """Take back what was kept.

        :param memory: what :meth:`memory` returned
        """


class Checkpoints(BaseCallback):
    """Save a checkpoint now and then, always between an update and the next rollout.

    :param cell: what is being trained
    :param watch: the callback whose state belongs to it
    :param every: env steps between two checkpoints
    """

    def __init__(self, cell: Cell, watch: Watch, every: int = 10_000) -> None:
        super().__init__()
        self.cell = cell
        self.watch = watch
        self.every = every
        self._next = every

    def _on_training_start(self) -> None:
        self._next = self.watch.env_steps + self.every

    def _on_rollout_start(self) -> None:
        if self.watch.env_steps >= self._next:
            self._next = self.watch.env_steps + self.every
            save_checkpoint(self.cell, self.model, self.watch)

    def _on_step(self) -> bool:
        return True


def save_checkpoint(cell: Cell, model: BaseAlgorithm, watch: Watch) -> None:
    """Write the checkpoint of a training; the one before stays beside it.

    :param cell: what is being trained
    :param model: the model, between an update and the next rollout
    :param watch: the callback that watches it
    """
    assert isinstance(model.env, FlatVecEnv)
    state = {
        "fingerprint": cell.fingerprint(),
        "attributes": _attributes(model),
        "parameters": model.get_parameters(),
        "games": model.env.env_method("snapshot", indices=0),
        "random": {
            "python": random.getstate(),
            "numpy": np.random.get_state(),
            "torch": th.get_rng_state(),
            "cuda": th.cuda.get_rng_state_all(),
        },
        "watch": watch.state(),
        "memory": model.memory() if isinstance(model, HasMemory) else None,
        # What the last update recorded is written with the next rollout.
        "pending": [dict(getattr(model.logger, name)) for name in PENDING],
        "progress": (cell.directory / PROGRESS_FILE).read_text(encoding="utf-8"),
    }
    arrays: Arrays = {}
    tree = json.dumps(to_plain(state, arrays, NAMED)).encode()
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, **{TREE: np.frombuffer(tree, np.uint8)}, **arrays)
    path = cell.directory / CHECKPOINT_FILE
    with whole_file(path) as part:
        part.write_bytes(hashlib.sha256(content.getbuffer()).digest() + content.getbuffer())
        if path.exists():
            path.replace(cell.directory / CHECKPOINT_BEFORE_FILE)


def _attributes(model: BaseAlgorithm) -> dict[str, Any]:
    """The attributes of a model that change while it is trained: all that are numbers, arrays or made of them."""
    kept, left_out = {}, {*model._excluded_save_params(), "_last_lstm_states"}  # the states are its memory
    for name, value in vars(model).items():
        if name not in left_out:
            try:
                to_plain(value, {}, {})
            except TypeError:  # made of the cell's configuration
                continue
            kept[name] = value
    return kept


def read_checkpoint(cell: Cell) -> dict[str, Any] | None:
    """Read the newest whole checkpoint of a cell, if one is of the same configuration.

    :param cell: the cell
    :return: the checkpoint, or none; damaged ones are named in a notice
    """
    damaged, found = [], None
    for path in (cell.directory / CHECKPOINT_FILE, cell.directory / CHECKPOINT_BEFORE_FILE):
        if found is None and path.exists():
            try:
                state = _read(path)
            except ValueError:
                damaged.append(str(path))
                continue
            if state["fingerprint"] == cell.fingerprint():
                found = state
    if (cell.directory / OF_OLD).exists() and found is None:
        told = f"checkpoint {str(cell.directory / OF_OLD)!r} is of an earlier version and not read"
    elif damaged:
        told = f"damaged: checkpoint {' and '.join(map(repr, damaged))}"
    else:
        return found
    warnings.warn(f"{told}; {'the one before is used' if found else 'the training starts anew'}", Notice, stacklevel=2)
    return found


def _read(path: Path) -> dict[str, Any]:
    """Read a checkpoint.

    :raises ValueError: if it is damaged
    """
    content = path.read_bytes()
    digest, archive = content[:32], content[32:]
    if hashlib.sha256(archive).digest() != digest:
        raise ValueError("its content does not have its SHA-256")
    try:
        with np.load(io.BytesIO(archive), allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        state = from_plain(json.loads(arrays[TREE].tobytes()), arrays, NAMED)
    except (OSError, LookupError, TypeError, RecursionError, zipfile.BadZipFile) as error:  # written by somebody else
        raise ValueError(str(error)) from error
    if not isinstance(state, dict) or "fingerprint" not in state:
        raise ValueError("it holds no training")
    return state


def resume_model(cell: Cell, state: dict[str, Any]) -> BaseAlgorithm:
    """Rebuild a model, its games and all random states from a checkpoint.

    :param cell: what is being trained
    :param state: the checkpoint
    :return: the model, ready to learn on
    """
    model = build_model(cell, _init_setup_model=False)
    env = model.env
    assert isinstance(env, FlatVecEnv)
    vars(model).update(state["attributes"])
    model._setup_model()
    env.reset()  # after the model has seeded it, so that no later reset begins anew with the seed
    model.set_parameters(state["parameters"], exact_match=True, device=model.device)
    if isinstance(model, HasMemory):
        model.restore_memory(state["memory"])
    env.env_method("restore", state["games"][0], indices=0)
    random.setstate(state["random"]["python"])
    np.random.set_state(state["random"]["numpy"])
    th.set_rng_state(state["random"]["torch"])
    th.cuda.set_rng_state_all(state["random"]["cuda"])
    return model
