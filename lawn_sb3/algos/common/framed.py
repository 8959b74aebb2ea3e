"""What policies in the symmetric frame share, whatever they learn."""

from collections.abc import Collection
from typing import Any, ClassVar

from stable_baselines3.common.policies import BasePolicy

from lawn_sb3.algos.common.encoder import Encoder, Inputs
from lawn_sb3.envs.observation import ObservationLayout, Sight
from lawn_sb3.scenario import Scenario


class Framed(BasePolicy):
    """Mixin for a policy with a ``layout`` whose networks see the airspace turned into one octant.

    :param scenario: the game, for its airspace, cells and RBs
    :param symmetric: turn the airspace so that the own position lies in one octant; refused where the scenario has not
        the symmetries of a square
    :param inputs: places ``one-hot``, or as numbers ``relative`` to the own position
    """

    sees: ClassVar[tuple[Sight, ...]] = ("clock",)
    """What it sees besides o_i."""
    needs_scenario: ClassVar[bool] = True
    """Whether it takes the environment's ``scenario`` too, and with it what else it needs of the game."""
    fits_all_games: ClassVar[bool] = False
    """Whether its networks are the same for all numbers of UAVs and GBSs, in any airspace."""
    layout: ObservationLayout

    def __init__(
        self, *args: Any, scenario: Scenario, symmetric: bool = True, inputs: Inputs = "one-hot", **kwargs: Any
    ) -> None:
        self.scenario, self.symmetric, self.inputs = scenario, symmetric, inputs
        super().__init__(*args, **kwargs)

    def make_encoder(self, sees: Collection[Sight], loads: bool = True) -> Encoder:
        """How what is seen is put to a network; the arguments are those of :class:`Encoder`."""
        return Encoder(self.scenario, self.layout, sees, loads, symmetric=self.symmetric, inputs=self.inputs)

    def _get_constructor_parameters(self) -> dict[str, Any]:
        own = {"scenario": self.scenario, "symmetric": self.symmetric, "inputs": self.inputs}
        return {**super()._get_constructor_parameters(), **own}
