"""What all peers share: the game, the settings, and how their learning is measured."""

import time
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import torch as th
from numpy.typing import ArrayLike

from lawn_sb3.envs import ActorPlayer
from lawn_sb3.envs.observation import Floats32
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.scenario import PRESETS

SCENARIO = PRESETS["paper"]
HIDDEN = [64, 64]
"""Hidden layers of every actor, critic and Q-network, with tanh."""
ROLLOUT = 512
"""Env steps between two updates."""
EPOCHS = 4
MINIBATCH = 512
"""Agent steps in a minibatch."""
LEARNING_RATE, GAMMA, GAE_LAMBDA, CLIP, ENTROPY, VALUE, GRADIENT = 4e-3, 0.3, 0.35, 0.2, 0.01, 0.5, 0.5
SEED = 0
LOOK_EVERY = 1_024
"""Env steps between two looks at the greedy player."""
LOOK, LOOK_SEED = 100, 10_000
"""Missions of a look, apart from those of the end."""
END, END_SEED = 200, 20_000
"""Missions of the paper's table, as all reports fly them."""

Actor = Callable[[Floats32], ArrayLike]


class Watch:
    """Looks at a training now and then, and counts the CPU seconds of this process besides.

    :param env_steps: the budget
    :param packages: whose versions are kept
    """

    def __init__(self, env_steps: int, *packages: str) -> None:
        th.set_num_threads(1)
        self.env_steps = env_steps
        self.versions = {name: version(name) for name in packages}
        self.looks: list[dict[str, float]] = []
        self.trained = 0
        self._spent = 0.0
        self._since: float | None = None

    def begin(self, actor: Actor) -> None:
        """Look at the untrained player, which compiles the game, and start the clock.

        :param actor: chooses actions for observations [G, N, 24]
        """
        self._look(actor)
        self._since = time.process_time()

    def step(self, trained: int, actor: Actor) -> None:
        """Stop the clock, look if it is time to, and go on.

        :param trained: env steps so far
        :param actor: chooses actions for observations [G, N, 24]
        """
        assert self._since is not None
        self._spent += time.process_time() - self._since
        self.trained = trained
        if trained >= self.looks[-1]["env_steps"] + LOOK_EVERY or trained >= self.env_steps:
            self._look(actor)
        self._since = time.process_time()

    def _look(self, actor: Actor) -> None:
        found = summarize(evaluate(ActorPlayer(actor), SCENARIO, LOOK, LOOK_SEED))
        kept = {name: found[name] for name in ("reward", "success_percent", "utility_mbps")}
        self.looks.append({"env_steps": self.trained, "cpu_seconds": round(self._spent, 2), **kept})

    def result(self, actor: Actor) -> dict[str, Any]:
        """What is kept of the training.

        :param actor: chooses actions for observations [G, N, 24], trained
        :return: versions, speed, when it had learnt what, the row of the table, and all looks
        """
        utility = 0.99 * self.looks[-1]["utility_mbps"]
        return {
            "versions": self.versions,
            "env_steps": self.trained,
            "cpu_seconds": round(self._spent, 2),
            "env_steps_a_cpu_second": round(self.trained / self._spent, 1),
            "to_95_percent_success": self._first("success_percent", 95.0),
            "to_99_percent_of_final_utility": self._first("utility_mbps", utility),
            "table_two": summarize(evaluate(ActorPlayer(actor), SCENARIO, END, END_SEED)),
            "looks": self.looks,
        }

    def _first(self, figure: str, least: float) -> dict[str, float] | None:
        """The first look at which a figure is high enough; none if there is none."""
        reached = (look for look in self.looks if look[figure] >= least)
        return next(({key: look[key] for key in ("env_steps", "cpu_seconds")} for look in reached), None)
