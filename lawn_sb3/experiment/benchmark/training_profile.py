"""Where the time of a training goes: each part's own time, what it calls that is a part itself left out."""

import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from pkgutil import resolve_name
from typing import Any
from unittest.mock import patch

import pandas as pd
import torch as th

from lawn_sb3.experiment.benchmark.training_speed import first_methods
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.plan_episodes import Advance
from lawn_sb3.experiment.recipe import Evaluation, Method
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.scenario import PRESETS

PARTS: dict[str, tuple[str, ...]] = {
    "simulator": ("lawn_sb3.game.simulator.Simulator.step", "lawn_sb3.game.simulator.Simulator.go_on"),
    "observations": ("lawn_sb3.envs.observation.Observer.flat",),
    "SuperSuit and adapter": ("lawn_sb3.envs.flatten.FlatVecEnv.step",),
    "networks, forward": ("torch.nn.Module.__call__",),
    "networks, backward": ("torch.Tensor.backward",),
    "optimiser": ("torch.optim.Adam.step", "torch.nn.utils.clip_grad_norm_"),
    "replay": (
        "stable_baselines3.common.buffers.ReplayBuffer.sample",
        "lawn_sb3.algos.qmix.joint_replay.JointReplayBuffer.add",
        "lawn_sb3.algos.iql.replay.ReplayRouter.add",
    ),
    "greedy evaluations": ("lawn_sb3.experiment.watching.fly", "lawn_sb3.experiment.train.fly"),
    "checkpoints": ("lawn_sb3.experiment.checkpoint.save_checkpoint",),
}
"""What is timed; what is left is SB3's Python and the kit's."""
WHOLE = ("greedy evaluations", "checkpoints")
"""Parts that all they call is booked for."""
REST = "SB3's loop and the rest"


class OwnTime:
    """Own time of nested parts, by a stack of those that are running."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys([*PARTS, REST], 0.0)
        self._running = [REST]
        self._since = time.perf_counter()

    def switch(self) -> None:
        """Book the time since the last switch for what has been running."""
        now = time.perf_counter()
        self.seconds[self._running[-1]] += now - self._since
        self._since = now

    def timed(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The same function, with its own time booked for a part."""

        def call(*args: Any, **kwargs: Any) -> Any:
            self.switch()
            running = self._running[-1]
            self._running.append(running if running in WHOLE else part)
            try:
                return function(*args, **kwargs)
            finally:
                self.switch()
                self._running.pop()

        return call


@contextmanager
def own_times() -> Iterator[OwnTime]:
    """Time all parts inside a ``with`` block."""
    clock = OwnTime()
    with ExitStack() as patched:
        for part, names in PARTS.items():
            for name in names:
                owner, _, attribute = name.rpartition(".")
                function = getattr(resolve_name(owner), attribute)
                patched.enter_context(patch(name, clock.timed(part, function)))
        yield clock
        clock.switch()


def training_profile(methods: Mapping[str, Method], env_steps: int, advance: Advance) -> pd.DataFrame:
    """Share of the time of a training that each part takes, with evaluations and checkpoints as in a recipe.

    :param methods: methods of a recipe; the first of each algorithm is trained
    :param env_steps: for how long
    :param advance: told after each training
    :return: one row for each part, percent by algorithm; the last row has the seconds
    """
    th.set_num_threads(1)
    first = first_methods(methods)
    columns = {}
    for algo, method in first.items():
        _train(method, 1_000)  # compiles and imports
        with own_times() as clock:
            _train(method, env_steps)
        total = sum(clock.seconds.values())
        columns[algo] = {part: 100.0 * own / total for part, own in clock.seconds.items()} | {"seconds": total}
        advance("profiles", len(first))
    return pd.DataFrame(columns)


def _train(method: Method, env_steps: int) -> None:
    shorter = method.model_copy(update={"env_steps": env_steps})
    with tempfile.TemporaryDirectory() as folder:
        run_cell(Cell("profile", shorter, 0, PRESETS["paper"], Evaluation(), Path(folder)), lambda done: None)
