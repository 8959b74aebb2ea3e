"""IQL in time: each UAV's own Q(o_i, clock, .) in the symmetric frame, over the moves that are in time.

What it adds to ``local_q``: the mask, in the argmax and in the targets, and the frame.
"""

from lawn_sb3.algos.iql import InTimeQPolicy


class InTimeLocalQPolicy(InTimeQPolicy):
    """Two hidden layers of 256 ReLU units behind the encoder."""
