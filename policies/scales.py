"""For large airspaces: the way to the destination at several scales in place of d_i, for the actor and for the critic.

What it adds to ``relative``, where a way of 100 voxels is one number of up to 10: the last voxel counts as much as the
first ten.
"""

import torch as th

from lawn_sb3.algos.common.scales import AtScales
from lawn_sb3.algos.mappo import CTDEPolicy


class ScalesPolicy(CTDEPolicy):
    """Actor over o_i with d_i - q_i at several scales in place of d_i, critic V([o_i, x]) with the same o_i."""

    def _build_mlp_extractor(self) -> None:
        self.at_scales = AtScales()
        super()._build_mlp_extractor()

    def actor_input(self, local: th.Tensor) -> th.Tensor:
        seen: th.Tensor = self.at_scales(local)
        return seen

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return th.cat([self.actor_input(local), state], dim=1)
