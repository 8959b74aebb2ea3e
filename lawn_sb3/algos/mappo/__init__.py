"""CTDE-MAPPO."""

from lawn_sb3.algos.mappo.episodes import EpisodeMAPPO
from lawn_sb3.algos.mappo.framed_policy import FramedLayers, FramedPolicy
from lawn_sb3.algos.mappo.mappo import MAPPO
from lawn_sb3.algos.mappo.policies import CTDEPolicy, MaskableCTDEPolicy
from lawn_sb3.algos.mappo.recurrent_policy import RecurrentCTDEPolicy
from lawn_sb3.algos.mappo.variants import MaskableMAPPO, RecurrentMAPPO

__all__ = [
    "MAPPO",
    "CTDEPolicy",
    "EpisodeMAPPO",
    "FramedLayers",
    "FramedPolicy",
    "MaskableCTDEPolicy",
    "MaskableMAPPO",
    "RecurrentCTDEPolicy",
    "RecurrentMAPPO",
]
