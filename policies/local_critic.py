"""A critic that sees what the actor sees: V(o_i), which makes the algorithm independent PPO (IPPO)."""

import torch as th

from lawn_sb3.algos.mappo import CTDEPolicy


class LocalCriticPolicy(CTDEPolicy):
    """Actor pi(a | o_i), critic V(o_i)."""

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return local
