"""Each UAV's own quantiles of the return after o_i and an action; their mean is the Q that its greedy play follows.

It ablates what a UAV learns of its return: the whole distribution, by quantile regression, instead of the mean alone
that ``local_q`` learns.
"""

from typing import Any

from gymnasium import spaces
from sb3_contrib.qrdqn.policies import QRDQNPolicy
from stable_baselines3.common.type_aliases import Schedule


class QuantileQPolicy(QRDQNPolicy):
    """Two hidden layers of 256 ReLU units, as the paper's networks have.

    :param observation_space: what a learner sees
    :param action_space: the actions
    :param lr_schedule: learning rate by the progress remaining
    :param n_quantiles: quantiles of each action's return, our choice for speed; sb3-contrib's own default is 200
    :param net_arch: widths of the hidden layers
    :param kwargs: as in sb3-contrib's ``QRDQNPolicy``
    :raises ValueError: if there is no quantile
    """

    def __init__(
        self,
        observation_space: spaces.Box,
        action_space: spaces.Discrete,
        lr_schedule: Schedule,
        n_quantiles: int = 16,
        net_arch: list[int] | None = None,
        **kwargs: Any,
    ) -> None:
        if n_quantiles < 1:
            raise ValueError(f"n_quantiles = {n_quantiles}: a whole number from 1 up")
        net_arch = [256, 256] if net_arch is None else net_arch
        super().__init__(observation_space, action_space, lr_schedule, n_quantiles, net_arch, **kwargs)
