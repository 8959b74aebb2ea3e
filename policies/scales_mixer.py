"""QMIX for large airspaces: the Q-network has the way to the destination at several scales in place of d_i.

What it adds to ``monotonic_mixer``, whose mixer it has: those scales.
"""

from stable_baselines3.common.torch_layers import create_mlp
from torch import nn

from lawn_sb3.algos.common.scales import MORE, AtScales
from policies.monotonic_mixer import MonotonicMixerPolicy


class ScalesMixerPolicy(MonotonicMixerPolicy):
    """Q-network over o_i with d_i - q_i at several scales in place of d_i; monotonic mixer conditioned on x."""

    def make_q_net(self, num_actions: int) -> nn.Module:
        width = self.layout.seen(self.sees).stop + MORE
        return nn.Sequential(AtScales(), *create_mlp(width, num_actions, self.net_arch, self.activation_fn))
