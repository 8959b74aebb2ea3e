"""Which slots of the flattened games belong to which learner, and what it sees of them."""

from dataclasses import dataclass

import torch as th
from gymnasium import spaces

from lawn_sb3.envs.observation import ObservationLayout, Sight, space_of


@dataclass(frozen=True)
class LearnerViews:
    """The view of every learner: one per UAV, or a single one that all UAVs share.

    Learner i has slots i, N + i, 2N + i, ... and sees o_i alone. A shared learner has all slots and sees o_i with the
    UAV's index, one-hot, appended.

    :param layout: where o_i lies in the flat observation
    :param shared: whether there is a single learner
    :param sees: what the learners see besides o_i
    """

    layout: ObservationLayout
    shared: bool
    sees: tuple[Sight, ...] = ()

    @property
    def num_learners(self) -> int:
        """Number of learners: N, or 1."""
        return 1 if self.shared else self.layout.num_uavs

    @property
    def uavs_each(self) -> int:
        """Number of UAVs a learner learns from: 1, or N."""
        return self.layout.num_uavs if self.shared else 1

    def space(self) -> spaces.Box:
        """Gymnasium space of what a learner sees of one slot."""
        extra = self.layout.num_uavs if self.shared else 0
        return space_of(self.layout.seen(self.sees).stop + extra)

    def slots(self, learner: int) -> slice:
        """Where the slots of a learner lie in the vector."""
        return slice(None) if self.shared else slice(learner, None, self.layout.num_uavs)

    def observe(self, learner: int, flat: th.Tensor) -> th.Tensor:
        """What a learner sees of a vector of whole games.

        :param learner: its index
        :param flat: flat observations of all slots [G * N, flat_dim]
        :return: one row per slot of the learner
        """
        local = flat[self.slots(learner), self.layout.seen(self.sees)]
        if not self.shared:
            return local
        num_uavs = self.layout.num_uavs
        index = th.eye(num_uavs, dtype=flat.dtype, device=flat.device).repeat(len(flat) // num_uavs, 1)
        return th.cat([local, index], dim=1)
