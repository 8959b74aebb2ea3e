"""IQL for large airspaces: each UAV's own Q has the way to the destination at several scales in place of d_i.

What it adds to ``local_q``: those scales.
"""

from stable_baselines3.common.torch_layers import create_mlp
from stable_baselines3.dqn.policies import QNetwork
from torch import nn

from lawn_sb3.algos.common.scales import MORE, AtScales
from policies.local_q import LocalQPolicy


class ScalesQPolicy(LocalQPolicy):
    """Two hidden layers of 256 ReLU units over o_i with d_i - q_i at several scales in place of d_i."""

    def make_q_net(self) -> QNetwork:
        made = super().make_q_net()
        width = made.features_dim + MORE
        num_actions = int(self.action_space.n)  # type: ignore[attr-defined]
        layers = create_mlp(width, num_actions, self.net_arch, self.activation_fn)
        made.q_net = nn.Sequential(AtScales(), *layers)
        return made.to(self.device)
