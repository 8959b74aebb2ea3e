"""The ladder's lowest rung: nothing of the others. The actor sees its own mission and clock, and no cell load."""

from lawn_sb3.algos.mappo import FramedPolicy


class KnowsNothingPolicy(FramedPolicy):
    """Actor over o_i without {n_b}, and the clock."""

    sees = ("clock",)
    looks_at_loads = False
