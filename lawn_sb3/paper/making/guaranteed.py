"""What no UAV has less than in an equilibrium: its best flight if all others share its cell all the time."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluation_games
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.planning.guarantee import guaranteed_utilities_mbps


def guaranteed(recipe: Recipe, finished: Sequence[Cell]) -> pd.DataFrame:
    """Plan every UAV's best flight among so many, for the price of anarchy: one row per test episode and UAV."""
    game, chosen = recipe.game(), recipe.evaluation
    simulator = evaluation_games(game, chosen.episodes, chosen.seed)
    utilities_mbps = guaranteed_utilities_mbps(simulator.rules, simulator.state, game.max_slots)  # [E, N]
    episode, uav = np.indices(utilities_mbps.shape)
    return pd.DataFrame({"episode": episode.ravel(), "uav": uav.ravel(), "guaranteed_mbps": utilities_mbps.ravel()})
