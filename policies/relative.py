"""An encoder that spares the networks a subtraction: d_i - q_i in place of d_i, for the actor and for the critic.

Nothing is added or taken away: d_i is still q_i plus what is seen.
"""

import torch as th

from lawn_sb3.algos.mappo import CTDEPolicy


class RelativePolicy(CTDEPolicy):
    """Actor over o_i with d_i - q_i in place of d_i, critic V([o_i, x]) with the same o_i."""

    def actor_input(self, local: th.Tensor) -> th.Tensor:
        relative = local.clone()
        relative[:, self.layout.destination] -= local[:, self.layout.position]
        return relative

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return th.cat([self.actor_input(local), state], dim=1)
