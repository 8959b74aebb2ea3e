"""Gains around closed cycles of deviations: all zero where the association of UAVs to cells has an exact potential."""

from collections.abc import Sequence
from itertools import combinations, product

import numpy as np
import pandas as pd

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluation_games
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.paper.checks.checks import CYCLE_MISSIONS
from lawn_sb3.planning.association import association_rates_mbps, cycle_gain, deviation_cycle, one_slot_game

COLUMNS = ("episode", "uav", "to_gbs", "other_uav", "other_to_gbs", "rate_gain_mbps", "log_rate_gain")


def deviation_cycles(recipe: Recipe, finished: Sequence[Cell]) -> pd.DataFrame:
    """One row per cycle of two UAVs in the first slot of a test mission: both go to another cell and back, by turns.

    The gains around it are those of who deviates, added up: of its rate, and of the logarithm of its rate. All rates
    on the way are above 0.

    :param recipe: the recipe
    :param finished: the cells whose runs are finished
    :return: the columns ``COLUMNS``
    :raises UserError: if nobody can change its cell
    """
    chosen, found = recipe.evaluation, []
    simulator = evaluation_games(recipe.game(), min(CYCLE_MISSIONS, chosen.episodes), chosen.seed)
    x, y, z = np.moveaxis(simulator.state.position, -1, 0)
    cells, num_rbs = simulator.rules.cell[x, y, z], simulator.rules.num_rbs
    for game, start in enumerate(cells):
        rb_rate_mbps, _ = one_slot_game(simulator, game)
        others = [[int(b) for b in np.flatnonzero(own) if b != start[i]] for i, own in enumerate(rb_rate_mbps)]
        for uavs in combinations(range(len(start)), 2):
            for targets in product(others[uavs[0]], others[uavs[1]]):
                around = deviation_cycle(start, uavs, targets)
                rates_mbps = association_rates_mbps(rb_rate_mbps, num_rbs, around)
                if (rates_mbps > 0.0).all():
                    gains = (float(cycle_gain(values, uavs)) for values in (rates_mbps, np.log(rates_mbps)))
                    found.append((game, uavs[0], targets[0], uavs[1], targets[1], *gains))
    if not found:
        raise UserError("needs UAVs that can change their cells within a slot")
    return pd.DataFrame(found, columns=COLUMNS)
