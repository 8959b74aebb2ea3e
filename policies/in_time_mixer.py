"""QMIX in time: a Q-network over o_i and the clock in the symmetric frame, over the moves that are in time.

What it adds to ``monotonic_mixer``, whose mixer it has: the mask, in the argmax and in the targets, and the frame.
"""

from lawn_sb3.algos.qmix import InTimeQMIXPolicy
from policies.monotonic_mixer import MonotonicMixer


class InTimeMixerPolicy(InTimeQMIXPolicy):
    """Monotonic mixer conditioned on x."""

    def make_mixer(self) -> MonotonicMixer:
        return MonotonicMixer(self.layout.num_uavs, self.layout.state_dim)
