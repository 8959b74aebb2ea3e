"""CTDE-MAPPO."""

from lawn_sb3.algos.mappo.mappo import MAPPO
from lawn_sb3.algos.mappo.policies import CTDEPolicy

__all__ = ["MAPPO", "CTDEPolicy"]
