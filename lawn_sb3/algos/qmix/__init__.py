"""QMIX."""

from lawn_sb3.algos.qmix.joint_replay import JointReplayBuffer, JointSamples
from lawn_sb3.algos.qmix.policies import InTimeQMIXPolicy, QMIXPolicy
from lawn_sb3.algos.qmix.qmix import QMIX

__all__ = ["QMIX", "InTimeQMIXPolicy", "JointReplayBuffer", "JointSamples", "QMIXPolicy"]
