"""A rung of the ladder: the cell loads, which o_i (eq:obs) holds, and nothing else; not even the own clock."""

from lawn_sb3.algos.mappo import FramedPolicy


class KnowsLoadsPolicy(FramedPolicy):
    """Actor over o_i."""

    sees = ()
