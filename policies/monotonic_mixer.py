"""QMIX's mixer: the game's value never falls when a UAV's Q rises, so each UAV's greedy action is the game's.

What it adds to ``additive_mixer``: how much each Q counts, and the value besides, depend on the global state x.
"""

import torch as th
from torch import nn
from torch.nn import functional

from lawn_sb3.algos.qmix import QMIXPolicy


class MonotonicMixer(nn.Module):
    """Two layers over the Qs with absolute weights that hypernetworks make of x, ELU between, bias V(x) at the end.

    :param num_uavs: N
    :param state_dim: length of x
    :param hidden_dim: units of the layer between
    :param hyper_dim: hidden units of the hypernetworks
    """

    def __init__(self, num_uavs: int, state_dim: int, hidden_dim: int = 32, hyper_dim: int = 64) -> None:
        super().__init__()
        self.hidden_dim = hidden_dim
        self.weights_in = _hypernetwork(state_dim, hyper_dim, num_uavs * hidden_dim)
        self.bias_in = nn.Linear(state_dim, hidden_dim)
        self.weights_out = _hypernetwork(state_dim, hyper_dim, hidden_dim)
        self.bias_out = _hypernetwork(state_dim, hidden_dim, 1)

    def forward(self, q: th.Tensor, state: th.Tensor) -> th.Tensor:
        """Mix.

        :param q: Qs of the UAVs, 0 for those that do not fly [B, N]
        :param state: global states x [B, state_dim]
        :return: values of the games [B]
        """
        weights_in = self.weights_in(state).abs().reshape(*q.shape, self.hidden_dim)  # [B, N, H]
        hidden = functional.elu((q[:, :, None] * weights_in).sum(dim=1) + self.bias_in(state))  # [B, H]
        mixed: th.Tensor = (hidden * self.weights_out(state).abs()).sum(dim=1) + self.bias_out(state)[:, 0]
        return mixed


def _hypernetwork(state_dim: int, hidden_dim: int, out_dim: int) -> nn.Module:
    return nn.Sequential(nn.Linear(state_dim, hidden_dim), nn.ReLU(), nn.Linear(hidden_dim, out_dim))


class MonotonicMixerPolicy(QMIXPolicy):
    """Q-network over o_i; monotonic mixer conditioned on x."""

    def make_mixer(self) -> nn.Module:
        return MonotonicMixer(self.layout.num_uavs, self.layout.state_dim)
