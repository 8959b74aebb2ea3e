"""The paper's critic V(x), eq:global_state, behind an actor for large airspaces."""

import torch as th

from policies.scales import ScalesPolicy


class ScalesStatePolicy(ScalesPolicy):
    """Actor as in ``scales``, critic V(x)."""

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return state
