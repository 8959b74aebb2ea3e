"""The default: the critic reads [o_i, x]. What it adds to ``state_critic``: the critic knows whose value is asked."""

import torch as th

from lawn_sb3.algos.mappo import CTDEPolicy


class CentralizedCriticPolicy(CTDEPolicy):
    """Actor over o_i, critic V([o_i, x])."""

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return th.cat([local, state], dim=1)
