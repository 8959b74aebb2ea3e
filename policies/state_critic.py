"""The paper's critic V(x), eq:global_state: it reads x alone, so all UAVs of a game get the same value."""

import torch as th

from lawn_sb3.algos.mappo import CTDEPolicy


class StateCriticPolicy(CTDEPolicy):
    """Actor over o_i, critic V(x)."""

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return state
