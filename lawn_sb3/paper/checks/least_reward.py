"""The least reward of a method with CTDE-MAPPO's printed rate, time and success, if rewards are paid in Mbps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.experiment.run_directory.csv_file import Columns, number, whole
from lawn_sb3.paper.checks.check import Check
from lawn_sb3.paper.identification.bounds import draw_legs, rate_terms_mbps
from lawn_sb3.paper.printed_values import ROUNDING, TABLE_II
from lawn_sb3.scenario import PRESETS, Scenario

PRINTED = TABLE_II["CTDE-MAPPO"]
LATEST_SLOTS = PRINTED.makespan_slots + ROUNDING.makespan_slots


class LeastReward(Check):
    """One row per length of a mission: how many UAVs have it, and the rate and terminal terms of each at least.

    Progress is worth something above 0, and collisions are forbidden by eq:collision, so that these are a lower bound
    of J.
    """

    name = "least_reward"
    key = ("min_slots",)

    def game(self, recipe: Recipe) -> Scenario:
        """The paper's game, whatever the recipe's."""
        return PRESETS["paper"]

    def depends_on(self, recipe: Recipe, finished: Sequence[Cell]) -> dict[str, Any]:
        """What the paper prints."""
        return {"rate_mbps": PRINTED.rate_mbps, "latest_slots": LATEST_SLOTS}

    def fly(self, recipe: Recipe, finished: Sequence[Cell]) -> pd.DataFrame:
        """Solve a linear program over the lengths of the missions."""
        game = self.game(recipe)
        legs = draw_legs(game, recipe.evaluation.episodes, recipe.evaluation.seed)
        try:
            least = rate_terms_mbps(game, legs.min_slots, PRINTED.rate_mbps, LATEST_SLOTS, largest=False)  # [E, N]
        except ValueError as error:
            raise UserError(f"needs test missions on which the printed figures are possible: {error}") from None
        lengths, first, counts = np.unique(legs.min_slots, return_index=True, return_counts=True)
        return pd.DataFrame({"min_slots": lengths, "uavs": counts, "least_mbps": least.ravel()[first]})

    def columns(self, recipe: Recipe, finished: Sequence[Cell]) -> Columns:
        """Lengths, counts and terms."""
        game = self.game(recipe)
        return {
            "min_slots": whole("length of the mission, T_i^min", "slots", 1, sum(game.grid)),
            "uavs": whole(
                "UAVs of all test missions that have it", "UAVs", 1, recipe.evaluation.episodes * game.num_uavs
            ),
            "least_mbps": number("rate and terminal terms of J, at least", "Mbps", 0),
        }
