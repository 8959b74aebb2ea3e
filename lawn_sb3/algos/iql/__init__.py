"""Independent Q-learning."""

from lawn_sb3.algos.iql.double_dqn import DoubleDQN
from lawn_sb3.algos.iql.in_time_policy import InTimeQPolicy
from lawn_sb3.algos.iql.iql import IQL
from lawn_sb3.algos.iql.learners import LEARNERS
from lawn_sb3.algos.iql.policies import IndependentPolicy

__all__ = ["IQL", "LEARNERS", "DoubleDQN", "InTimeQPolicy", "IndependentPolicy"]
