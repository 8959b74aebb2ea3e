"""UAVs of which some fly straight and all others hover near their start, as the paper explains IQL's rate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.game.player import Player
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.paper.checks.check import EvaluationCheck
from lawn_sb3.paper.printed_values import TABLE_II
from lawn_sb3.planning import ShortestPathPlayer

SHARE_FLYING = TABLE_II["IQL"].success_percent / 100.0
"""As many as the paper's IQL brings to their destinations."""


class HoveringPlayer:
    """Some UAVs fly straight to their destinations, the others to the best voxel within one slot, where they stay.

    The best voxel is the one that promises the highest rate by the cell loads at the start, as if nobody else moved.

    :param share_flying: share of the UAVs that fly, drawn one by one
    """

    name = "hover"

    def __init__(self, share_flying: float) -> None:
        self.share_flying = share_flying
        self._straight = ShortestPathPlayer()

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Draw who flies, and find where the others hover.

        :param simulator: the games
        :param rng: source of the draw
        """
        rules, state = simulator.rules, simulator.state
        ends = np.clip(state.position[:, :, None] + rules.actions, 0, np.array(rules.grid) - 1)  # [G, N, A, 3]
        x, y, z = np.moveaxis(ends, -1, 0)
        cell = rules.cell[x, y, z]  # [G, N, A]
        # Action 0 hovers, so that its cell is the own one, whose load counts this UAV already.
        load = state.cell_load[np.arange(len(cell))[:, None, None], cell] + (cell != cell[..., :1])
        # Of several moves to the best voxel the first is the shortest, which stays inside.
        self._next = (rules.num_rbs[cell] // load * rules.rb_rate_mbps[x, y, z]).argmax(axis=-1)  # [G, N]
        self._flies = rng.random(state.flying.shape) < self.share_flying
        self._straight.start(simulator, rng)

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Move once to hover, or on to the destination.

        :param simulator: the games
        :return: indices into the action table [G, N]
        """
        move = np.where(self._flies, self._straight.act(simulator), self._next)
        self._next = np.zeros_like(self._next)  # action 0 hovers
        return move


class Hovering(EvaluationCheck):
    """Raw rows of the player that hovers, in the recipe's game."""

    name = "hovering"

    def depends_on(self, recipe: Recipe, finished: Sequence[Cell]) -> dict[str, Any]:
        """Who flies."""
        return {"share_flying": SHARE_FLYING}

    def player(self) -> Player:
        """The player that hovers."""
        return HoveringPlayer(SHARE_FLYING)
