"""An actor that remembers: an LSTM over the o_i of its mission so far.

What it changes against ``centralized_critic``: the algorithm becomes sb3-contrib's RecurrentPPO.
"""

import torch as th

from lawn_sb3.algos.mappo import RecurrentCTDEPolicy


class RecurrentPolicy(RecurrentCTDEPolicy):
    """Actor with an LSTM over o_i, critic V([o_i, x]) without memory."""

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return th.cat([local, state], dim=1)
