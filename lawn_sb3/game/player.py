"""Players choose the actions of all UAVs; all of them are scored by the same evaluation."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.simulator import Simulator


class Player(Protocol):
    """Chooses the actions of all UAVs of all games."""

    name: str

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Get ready for new games.

        :param simulator: the games, at their first slot
        :param rng: source of the player's own randomness
        """

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Choose the next actions.

        :param simulator: the games as they stand
        :return: indices into the action table [G, N]
        """


class RandomPlayer:
    """Every UAV picks an action uniformly at random in every slot: the paper's lower bound."""

    name = "random"

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Keep the source of randomness."""
        self._rng = rng

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Draw the next actions [G, N]."""
        return self._rng.integers(0, simulator.num_actions, simulator.state.flying.shape)
