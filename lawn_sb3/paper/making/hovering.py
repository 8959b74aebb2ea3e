"""UAVs of which some fly straight and all others hover near their start, as the paper explains IQL's rate."""

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning import ShortestPathPlayer


class HoveringPlayer:
    """Some UAVs fly straight to their destinations, the others stay where they start, or in the best voxel nearby.

    The best voxel is, of those within one slot, the one that promises the highest rate by the cell loads at the start,
    as if nobody else moved.

    :param share_flying: share of the UAVs that fly, drawn one by one
    :param seeks: whether those that hover move to the best voxel first
    """

    name = "hover"

    def __init__(self, share_flying: float, *, seeks: bool) -> None:
        self.share_flying, self.seeks = share_flying, seeks
        self._straight = ShortestPathPlayer()

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Draw who flies, and find where the others hover."""
        rules, state = simulator.rules, simulator.state
        ends = np.clip(state.position[:, :, None] + rules.actions, 0, np.array(rules.grid) - 1)  # [G, N, A, 3]
        x, y, z = np.moveaxis(ends, -1, 0)
        cell = rules.cell[x, y, z]  # [G, N, A]
        # Action 0 hovers, so that its cell is the own one, whose load counts this UAV already.
        load = state.cell_load[np.arange(len(cell))[:, None, None], cell] + (cell != cell[..., :1])
        # Of several moves to the best voxel the first is the shortest, which stays inside.
        best = (rules.num_rbs[cell] // load * rules.rb_rate_mbps[x, y, z]).argmax(axis=-1)  # [G, N]
        self._next = best if self.seeks else np.zeros_like(best)
        self._flies = rng.random(state.flying.shape) < self.share_flying
        self._straight.start(simulator, rng)

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Move once to hover, or on to the destination: indices into the action table [G, N]."""
        move = np.where(self._flies, self._straight.act(simulator), self._next)
        self._next = np.zeros_like(self._next)  # action 0 hovers
        return move
