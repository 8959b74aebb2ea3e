"""For swarms: what o_i says of the places around a UAV. No network depends on how many UAVs or cells there are."""

from collections.abc import Collection
from typing import Any

import torch as th

from lawn_sb3.algos.common.around import Around
from lawn_sb3.algos.mappo import FramedPolicy
from lawn_sb3.envs.observation import Sight


class KnowsCellsPolicy(FramedPolicy):
    """Actor and critic over the way ahead, the clock, and the rates that the UAV would have in the places around it."""

    sees = ("clock",)
    fits_all_games = True

    def make_encoder(self, sees: Collection[Sight], loads: bool = True) -> Any:
        return Around(self.scenario, self.layout)

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        around: th.Tensor = self.critic_encoder(local)[0]
        return around
