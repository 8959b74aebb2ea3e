"""The running means of ended missions that SB3 logs under ``rollout/``, from when they say something."""

from typing import Any, ClassVar

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.type_aliases import GymEnv
from stable_baselines3.common.vec_env import VecEnv


def deadline_passed(env: GymEnv | None, agent_steps: int) -> bool:
    """Whether failed missions can have ended too; up to the first deadline only successful ones can.

    :param env: the environment; others than those of :func:`lawn_sb3.envs.make_vec_env` have no deadline
    :param agent_steps: agent steps played in it so far
    :return: whether its ended missions say how missions end
    """
    if not isinstance(env, VecEnv) or not env.has_attr("simulator"):
        return True
    max_slots: int = env.get_attr("scenario", [0])[0].max_slots
    return agent_steps // env.num_envs > max_slots


class MissionStatistics(BaseAlgorithm):
    """Mixin for an algorithm of SB3: leaves out of ``rollout/`` the missions that ended before the first deadline."""

    whole_batches: ClassVar[bool] = False
    """Whether every mission that began is counted when it is, so that none has to be left out."""

    def _update_info_buffer(self, infos: list[dict[str, Any]], dones: np.ndarray | None = None) -> None:
        if self.whole_batches or deadline_passed(self.env, self.num_timesteps):
            super()._update_info_buffer(infos, dones)
