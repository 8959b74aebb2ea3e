"""An actor that never flies against the walls: moves out of the airspace are masked, in training and in play.

What it changes against ``centralized_critic``: the algorithm becomes sb3-contrib's MaskablePPO. The masks follow from
q_i alone.
"""

import torch as th

from lawn_sb3.algos.mappo import MaskableCTDEPolicy


class MaskedPolicy(MaskableCTDEPolicy):
    """Actor over o_i whose impossible moves are masked, critic V([o_i, x])."""

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return th.cat([local, state], dim=1)
