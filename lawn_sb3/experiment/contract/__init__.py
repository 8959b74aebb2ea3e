"""The contract that every policy keeps: an actor that never reads x, answers of the right width, one slot at a time."""

from lawn_sb3.experiment.contract.check import check_policy
from lawn_sb3.experiment.contract.messages import line_in_own_file, policy_error, where

__all__ = ["check_policy", "line_in_own_file", "policy_error", "where"]
