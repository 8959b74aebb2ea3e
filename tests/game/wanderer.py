"""A player that always arrives: at random for some slots, then straight to its destination."""

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.simulator import Simulator


class Wanderer:
    """Picks actions at random for ``slots`` slots, then the move that ends nearest to the destination."""

    name = "wanderer"

    def __init__(self, slots: int = 0) -> None:
        self._slots = slots

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        self._rng = rng

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        state = simulator.state
        ends = state.position[:, :, None] + simulator.rules.actions
        straight = np.abs(ends - state.destination[:, :, None]).sum(axis=-1).argmin(axis=-1)
        aimless = self._rng.integers(0, simulator.num_actions, straight.shape)
        return np.asarray(np.where(state.slot < self._slots, aimless, straight))
