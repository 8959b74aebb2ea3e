"""Checkpoints: everything that an interrupted training needs to go on as if nothing had happened."""

import io
import pickle
import random
import warnings
from typing import Any, Protocol, runtime_checkable

import numpy as np
import torch as th
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback

from lawn_sb3.envs import FlatVecEnv
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.find_policy import find_policy
from lawn_sb3.experiment.registry import find_algorithm
from lawn_sb3.experiment.run_directory.files import CHECKPOINT_FILE, PROGRESS_FILE
from lawn_sb3.experiment.watching import Watch
from lawn_sb3.whole_files import whole_file

PENDING = ("name_to_value", "name_to_count", "name_to_excluded")
"""Where SB3's logger keeps what it has not written yet."""


UNREADABLE = (EOFError, ImportError, pickle.UnpicklingError)
"""What reading a damaged pickle can raise besides the ordinary errors."""


@runtime_checkable
class HasMemory(Protocol):
    """An algorithm that keeps experience from one update to the next, which SB3 does not save with the model."""

    def memory(self) -> Any:
        """What it keeps.

        :return: something that can be pickled
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
    """Write the checkpoint of a training, replacing the one before in one go.

    :param cell: what is being trained
    :param model: the model, between an update and the next rollout
    :param watch: the callback that watches it
    """
    assert isinstance(model.env, FlatVecEnv)
    saved = io.BytesIO()
    model.save(saved)
    state = {
        "fingerprint": cell.fingerprint(),
        "model": saved.getvalue(),
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
    content = io.BytesIO()
    th.save(state, content)
    with whole_file(cell.directory / CHECKPOINT_FILE) as part:
        part.write_bytes(content.getbuffer())


def read_checkpoint(cell: Cell) -> dict[str, Any] | None:
    """Read a cell's checkpoint, if it has a whole one of the same configuration.

    :param cell: the cell
    :return: the checkpoint, or none; a damaged one is named in a warning
    """
    path = cell.directory / CHECKPOINT_FILE
    if not path.exists():
        return None
    try:
        state: dict[str, Any] = th.load(path, weights_only=False)
        same = state["fingerprint"] == cell.fingerprint()
    except (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError, *UNREADABLE) as error:
        warnings.warn(f"checkpoint {str(path)!r} is damaged ({error}); the training starts anew", stacklevel=2)
        return None
    return state if same else None


def resume_model(cell: Cell, state: dict[str, Any], env: FlatVecEnv) -> BaseAlgorithm:
    """Rebuild a model, its games and all random states from a checkpoint.

    :param cell: what is being trained
    :param state: the checkpoint
    :param env: a training environment of the cell
    :return: the model, ready to learn on
    """
    assert cell.method.algo is not None
    assert cell.method.policy is not None
    policy = find_policy(cell.method.policy)  # the saved model names its module, which must be known by then
    env.reset()
    model = find_algorithm(cell.method.algo, policy).load(
        io.BytesIO(state["model"]), env=env, device=cell.method.settings.get("device", "cpu"), force_reset=False
    )
    if isinstance(model, HasMemory):
        model.restore_memory(state["memory"])
    env.env_method("restore", state["games"][0], indices=0)
    random.setstate(state["random"]["python"])
    np.random.set_state(state["random"]["numpy"])
    th.set_rng_state(state["random"]["torch"])
    th.cuda.set_rng_state_all(state["random"]["cuda"])
    return model
