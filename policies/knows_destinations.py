"""A rung of the ladder: loads and clock, and how many others head for each cell, which every UAV has to broadcast."""

from lawn_sb3.algos.mappo import FramedPolicy


class KnowsDestinationsPolicy(FramedPolicy):
    """Actor over o_i, the clock and how many others head for each cell."""

    sees = ("clock", "destinations")
