"""The shortest path: every UAV flies straight to its destination, whatever the cells are like."""

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.airspace import moves_inside
from lawn_sb3.game.simulator import Simulator


class ShortestPathPlayer:
    """Every UAV picks uniformly at random from the moves after which it can still arrive after T_i^min slots.

    It reads q_i and d_i alone: no rate, no cell load, nothing of the other UAVs.
    """

    name = "shortest-path"

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Keep the source of randomness."""
        self._rng = rng

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Draw the next actions [G, N]."""
        state, rules = simulator.state, simulator.rules
        ends = state.position[:, :, None] + rules.actions  # [G, N, A, 3]
        steps = np.abs(state.destination - state.position).sum(axis=-1)  # [G, N]
        steps_after = np.abs(state.destination[:, :, None] - ends).sum(axis=-1)  # [G, N, A]
        # Eq. (8), eq:tmin, from the end of the move on: one slot less than from here.
        on_time = -(-steps_after // rules.max_voxel_steps) < -(-steps // rules.max_voxel_steps)[..., None]
        inside = moves_inside(state.position, rules.actions, rules.grid)
        draw = self._rng.random(on_time.shape)
        return np.asarray(np.where(on_time & inside, draw, -1.0).argmax(axis=-1), dtype=np.int64)
