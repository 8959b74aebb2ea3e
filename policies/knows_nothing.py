"""The ladder's lowest rung: nothing of the others. The actor sees its mission and clock, no cell load and no rate."""

from lawn_sb3.algos.mappo import FramedPolicy


class KnowsNothingPolicy(FramedPolicy):
    """Actor over o_i without {n_b} and its own EMA rate, in which past loads show, and the clock."""

    sees = ("clock",)
    looks_at_loads = False
