"""No centralised critic (IPPO), for large airspaces: it sees what the actor sees."""

import torch as th

from policies.scales import ScalesPolicy


class ScalesLocalPolicy(ScalesPolicy):
    """Actor as in ``scales``, critic V(o_i)."""

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return self.actor_input(local)
