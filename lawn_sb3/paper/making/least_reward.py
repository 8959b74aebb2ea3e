"""The least reward of a method with CTDE-MAPPO's printed rate, time and success, if rewards are paid in Mbps."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.paper.identification.bounds import draw_legs, rate_terms_mbps
from lawn_sb3.paper.printed_values import LATEST_SLOTS, TABLE_II
from lawn_sb3.scenario import PRESETS


def least_reward(recipe: Recipe, finished: Sequence[Cell]) -> pd.DataFrame:
    """One row per length of a mission: how many UAVs have it, and the rate and terminal terms of each at least.

    Progress is worth something above 0, and collisions are forbidden by Eq. (4), eq:collision, so that these are a
    lower bound of J.
    """
    game, rate_mbps = PRESETS["paper"], TABLE_II["CTDE-MAPPO"].rate_mbps
    legs = draw_legs(game, recipe.evaluation.episodes, recipe.evaluation.seed)
    try:
        least = rate_terms_mbps(game, legs.min_slots, rate_mbps, LATEST_SLOTS, largest=False)  # [E, N]
    except ValueError as error:
        raise UserError(f"needs test missions on which the printed figures are possible: {error}") from None
    lengths, first, counts = np.unique(legs.min_slots, return_index=True, return_counts=True)
    return pd.DataFrame({"min_slots": lengths, "uavs": counts, "least_mbps": least.ravel()[first]})
