"""What no UAV has less than in an equilibrium: its best flight if all others share its cell all the time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluation_games
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.experiment.run_directory.csv_file import Columns, number
from lawn_sb3.experiment.run_directory.files import episode_and_uav
from lawn_sb3.paper.checks.check import Check
from lawn_sb3.planning.guarantee import guaranteed_utilities_mbps
from lawn_sb3.results.results import BOUND, EQUILIBRIA


class Guaranteed(Check):
    """One row per test episode and UAV, for the price of anarchy."""

    name = "guaranteed"

    def is_needed(self, recipe: Recipe, finished: Sequence[Cell]) -> bool:
        """Whether there may be certified equilibria, and a bound to hold them against."""
        players = {cell.method.player for cell in finished}
        return recipe.regret and BOUND in players and not players.isdisjoint(EQUILIBRIA)

    def fly(self, recipe: Recipe, finished: Sequence[Cell]) -> pd.DataFrame:
        """Plan every UAV's best flight among so many."""
        game, chosen = recipe.game(), recipe.evaluation
        simulator = evaluation_games(game, chosen.episodes, chosen.seed)
        utilities_mbps = guaranteed_utilities_mbps(simulator.rules, simulator.state, game.max_slots)  # [E, N]
        columns = (*np.indices(utilities_mbps.shape), utilities_mbps)
        names = (*self.key, "guaranteed_mbps")
        return pd.DataFrame({name: values.ravel() for name, values in zip(names, columns, strict=True)})

    def columns(self, recipe: Recipe, finished: Sequence[Cell]) -> Columns:
        """The utility."""
        least = number("utility that no equilibrium gives less than", "Mbps", 0)
        return {**episode_and_uav(recipe.game(), recipe.evaluation.episodes), "guaranteed_mbps": least}
