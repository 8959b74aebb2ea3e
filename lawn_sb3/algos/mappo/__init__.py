"""CTDE-MAPPO."""

from lawn_sb3.algos.mappo.mappo import MAPPO
from lawn_sb3.algos.mappo.policies import CTDEPolicy, MaskableCTDEPolicy
from lawn_sb3.algos.mappo.recurrent_policy import RecurrentCTDEPolicy
from lawn_sb3.algos.mappo.variants import MaskableMAPPO, RecurrentMAPPO

__all__ = ["MAPPO", "CTDEPolicy", "MaskableCTDEPolicy", "MaskableMAPPO", "RecurrentCTDEPolicy", "RecurrentMAPPO"]
