"""Players that need no learning: they plan by the game's rules, and most of them see everything.

The compiled functions here share their arguments: ``rules`` are the game's constants, ``state`` is the state of all
games, ``game`` and ``uav`` are indices, ``plan`` holds the trajectories of one game, and ``slack`` is how many slots
beyond T_i^min a flight may take. Slots ``s`` are counted from now: s = 1 is the next one.
"""

from lawn_sb3.planning.best_route import BestRoutePlayer, BoundPlayer
from lawn_sb3.planning.equilibrium import EquilibriumPlayer, WelfarePlayer, WorstEquilibriumPlayer
from lawn_sb3.planning.first_moves import first_move_losses
from lawn_sb3.planning.forecast import ForecastPlayer
from lawn_sb3.planning.mean_field import MeanFieldDestinationsPlayer, MeanFieldMemoryPlayer, MeanFieldPlayer
from lawn_sb3.planning.plan_player import PlanPlayer
from lawn_sb3.planning.shortest_path import ShortestPathPlayer

__all__ = [
    "BestRoutePlayer",
    "BoundPlayer",
    "EquilibriumPlayer",
    "ForecastPlayer",
    "MeanFieldDestinationsPlayer",
    "MeanFieldMemoryPlayer",
    "MeanFieldPlayer",
    "PlanPlayer",
    "ShortestPathPlayer",
    "WelfarePlayer",
    "WorstEquilibriumPlayer",
    "first_move_losses",
]
