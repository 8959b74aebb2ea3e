"""For swarms: an actor that starts from the forecast's flights and learns where to depart from them."""

from collections.abc import Collection
from typing import Any

import torch as th
from torch import nn

from lawn_sb3.algos.common.around import Around
from lawn_sb3.algos.common.outlook import Outlook
from lawn_sb3.algos.mappo import FramedLayers
from lawn_sb3.envs.observation import Sight
from policies.knows_cells import KnowsCellsPolicy


class ForesightLayers(FramedLayers):
    """Layers whose logits are those of the actor less what the moves lose by the forecast, as far as it trusts that."""

    def __init__(self, policy: "ForeseesCellsPolicy", *args: Any) -> None:
        super().__init__(policy, *args)
        self.trust = nn.Parameter(th.tensor(float(policy.trust)))

    def turned_logits(self, features: th.Tensor) -> th.Tensor:
        logits: th.Tensor = super().turned_logits(features) - self.trust * self.encoder.losses_of(features)
        return logits


class ForeseesCellsPolicy(KnowsCellsPolicy):
    """What the actor of ``knows_cells`` sees, and what each move loses if the loads that it sees never change.

    The losses are worked out from what is seen, by planning. An untrained actor's odds of a move are e^(-trust * loss).

    :param trust: how much a loss, in the unit of the rewards, takes off a move's logit at first; trained like a weight
    """

    layers_class = ForesightLayers

    def __init__(self, *args: Any, trust: float = 10.0, **kwargs: Any) -> None:
        self.trust = trust
        super().__init__(*args, **kwargs)

    def make_encoder(self, sees: Collection[Sight], loads: bool = True) -> Any:
        return Outlook(self.scenario, self.layout)

    def make_critic_encoder(self) -> Around:
        return Around(self.scenario, self.layout)

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return {**super()._get_constructor_parameters(), "trust": self.trust}
