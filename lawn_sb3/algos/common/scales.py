"""The way to the destination at several scales: what a network needs in a large airspace to find the last voxel too.

A single number for each axis is either too large far away or too small close by. Nothing is added or taken away: d_i is
still q_i plus the way.
"""

import torch as th
from torch import nn

from lawn_sb3.envs.observation import POSITION_UNIT_VOXELS, VOXEL, ObservationLayout

SCALES_VOXELS = (1.0, 3.0, 10.0, 30.0, 100.0)
"""Up to so many voxels the way grows on each scale; what is farther looks the same there."""
MORE = VOXEL * (len(SCALES_VOXELS) - 1)
"""By how many numbers the observation grows."""


class AtScales(nn.Module):
    """Puts d_i - q_i at several scales in place of d_i; it has no weights."""

    def forward(self, local: th.Tensor) -> th.Tensor:
        """Encode.

        :param local: local observations o_i and what else is seen [B, anything]
        :return: the same with more numbers for the way [B, anything + MORE]
        """
        place, goal = local[..., ObservationLayout.position], local[..., ObservationLayout.destination]
        way = (goal - place) * POSITION_UNIT_VOXELS
        scaled = [(way / scale).clamp(min=-1.0, max=1.0) for scale in SCALES_VOXELS]
        return th.cat([place / POSITION_UNIT_VOXELS, *scaled, local[..., 2 * VOXEL :]], dim=-1)
