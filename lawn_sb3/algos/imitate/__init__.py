"""Imitation of a planner, then MAPPO."""

from lawn_sb3.algos.imitate.imitate import TEACHERS, Imitate

__all__ = ["TEACHERS", "Imitate"]
