"""A critic that takes the UAVs for a set: the order of the others changes nothing, and their number may change.

A shared network reads each UAV's entry of x; the mean of what it makes of them joins o_i. No weight depends on N, so a
model trained with N UAVs loads where there are more or fewer.
"""

from typing import Any

import torch as th
from torch import nn

from lawn_sb3.algos.mappo import CTDEPolicy
from lawn_sb3.envs.observation import OWN


class SetCriticPolicy(CTDEPolicy):
    """Actor over o_i, critic V(o_i, {x_j}).

    :param args: as for ``CTDEPolicy``
    :param encoder_dim: units of the network that reads one UAV, two layers
    :param kwargs: as for ``CTDEPolicy``
    """

    def __init__(self, *args: Any, encoder_dim: int = 64, **kwargs: Any) -> None:
        self.encoder_dim = encoder_dim
        super().__init__(*args, **kwargs)

    def _build_mlp_extractor(self) -> None:
        width = self.encoder_dim
        self.encoder = nn.Sequential(nn.Linear(OWN, width), nn.ReLU(), nn.Linear(width, width), nn.ReLU())
        super()._build_mlp_extractor()

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        uavs = state[:, self.layout.state_uavs].reshape(len(state), -1, OWN)
        swarm = self.encoder(uavs).mean(dim=1)
        return th.cat([local, swarm], dim=1)
