"""The learners' replays as one: a vector of flat transitions goes in, each learner's own replay gets its slots."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch as th
from numpy.typing import NDArray
from stable_baselines3.common.buffers import ReplayBuffer

from lawn_sb3.algos.iql.views import LearnerViews


class ReplayRouter:
    """What SB3's outer loop stores its transitions in.

    :param replays: the learners' own replays
    :param views: which slots and columns are whose
    """

    def __init__(self, replays: Sequence[ReplayBuffer], views: LearnerViews) -> None:
        self.replays = list(replays)
        self.views = views

    def add(
        self,
        obs: NDArray[np.float32],
        next_obs: NDArray[np.float32],
        action: NDArray[np.int64],
        reward: NDArray[np.float32],
        done: NDArray[np.bool_],
        infos: list[dict[str, Any]],
    ) -> None:
        """Hand every learner its slots of one vector step.

        :param obs: flat observations [G * N, flat_dim]; the others are [G * N] or as long
        :param next_obs: those that followed, the last of a mission where it ended
        """
        before, after = th.as_tensor(obs), th.as_tensor(next_obs)
        for learner, replay in enumerate(self.replays):
            slots = self.views.slots(learner)
            replay.add(
                self.views.observe(learner, before).numpy(),
                self.views.observe(learner, after).numpy(),
                action[slots],
                reward[slots],
                done[slots],
                infos[slots],
            )


def replay_content(replay: ReplayBuffer) -> dict[str, Any]:
    """Copy what a replay holds: its arrays without the part that is still empty, and its position."""
    fill = replay.size()
    arrays = {name: array[:fill].copy() for name, array in _arrays(replay).items()}
    return {"arrays": arrays, "pos": replay.pos, "full": replay.full}


def restore_content(replay: ReplayBuffer, content: dict[str, Any]) -> None:
    """Fill a replay of the same size with what :func:`replay_content` returned."""
    for name, array in _arrays(replay).items():
        kept = content["arrays"][name]
        array[: len(kept)] = kept
    replay.pos, replay.full = content["pos"], content["full"]


def _arrays(replay: ReplayBuffer) -> dict[str, NDArray[Any]]:
    """The arrays with one row per vector step."""
    return {
        name: value
        for name, value in vars(replay).items()
        if isinstance(value, np.ndarray) and value.shape[:2] == (replay.buffer_size, replay.n_envs)
    }
