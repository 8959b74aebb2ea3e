"""A rung of the ladder: position and destination of every other UAV, as shared flight plans give them."""

from lawn_sb3.algos.mappo import FramedPolicy


class KnowsIntentsPolicy(FramedPolicy):
    """Actor over o_i, the clock and the others' positions and destinations."""

    sees = ("clock", "destinations", "intents")
