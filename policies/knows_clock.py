"""A rung of the ladder: the cell loads and the own clock. Nothing has to be broadcast for it."""

from lawn_sb3.algos.mappo import FramedPolicy


class KnowsClockPolicy(FramedPolicy):
    """Actor over o_i and the clock."""

    sees = ("clock",)
