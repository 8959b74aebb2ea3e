"""Players that need no learning: they know the game's rules and plan with them, most of them seeing everything."""

from lawn_sb3.planning.best_route import BestRoutePlayer, BoundPlayer
from lawn_sb3.planning.equilibrium import EquilibriumPlayer, WelfarePlayer, WorstEquilibriumPlayer
from lawn_sb3.planning.forecast import ForecastPlayer
from lawn_sb3.planning.mean_field import (
    MeanFieldDestinationsPlayer,
    MeanFieldMemoryPlayer,
    MeanFieldPlayer,
)
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
]
