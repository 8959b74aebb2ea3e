"""A rung of the ladder: loads and clock, and the loads of the slots before. Nothing has to be broadcast for it."""

from lawn_sb3.algos.mappo import FramedPolicy


class KnowsMemoryPolicy(FramedPolicy):
    """Actor over o_i, the clock and the loads of the slots before."""

    sees = ("clock", "memory")
