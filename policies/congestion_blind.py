"""An actor that cannot see the cell loads n_b; the critic is that of ``centralized_critic``, V([o_i, x])."""

import torch as th

from lawn_sb3.algos.mappo import CTDEPolicy


class CongestionBlindPolicy(CTDEPolicy):
    """Actor over o_i without {n_b}, critic V([o_i, x])."""

    def actor_input(self, local: th.Tensor) -> th.Tensor:
        blind = local.clone()
        blind[:, self.layout.cell_loads] = 0.0
        return blind

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return th.cat([local, state], dim=1)
