"""The ladder's highest rung: the actor sees all of x (eq:global_state), in play too."""

from lawn_sb3.algos.mappo import FramedPolicy


class KnowsStatePolicy(FramedPolicy):
    """Actor over all of x."""

    sees = ("clock", "destinations", "intents", "state")
