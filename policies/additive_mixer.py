"""Value decomposition (VDN): the game's value is the sum of the UAVs' Qs. What it lacks: the mixer never reads x."""

import torch as th
from torch import nn

from lawn_sb3.algos.qmix import QMIXPolicy


class AdditiveMixer(nn.Module):
    """The sum of the Qs."""

    def forward(self, q: th.Tensor, state: th.Tensor) -> th.Tensor:
        """Mix.

        :param q: Qs of the UAVs, 0 for those that do not fly [B, N]
        :param state: global states x [B, state_dim], not read
        :return: values of the games [B]
        """
        return q.sum(dim=1)


class AdditiveMixerPolicy(QMIXPolicy):
    """Q-network over o_i; sum of the Qs."""

    def make_mixer(self) -> nn.Module:
        return AdditiveMixer()
