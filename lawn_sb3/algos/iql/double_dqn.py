"""Double Q-learning for SB3's DQN: the online network picks the next action, the target network judges it."""

from collections.abc import Callable

import torch as th
from stable_baselines3 import DQN


class DoubleDQN(DQN):
    """SB3's ``DQN`` with the target of van Hasselt, Guez and Silver (2016), "Deep Reinforcement Learning with Double
    Q-learning". Takes what SB3's ``DQN`` takes.
    """

    def train(self, gradient_steps: int, batch_size: int = 100) -> None:
        """Update the network by ``gradient_steps`` minibatches of ``batch_size`` transitions."""
        target_net = self.q_net_target
        # SB3's train takes the largest value the target network answers: it gets an answer with one value alone.
        self.q_net_target = double_q(self.q_net, target_net)  # type: ignore[assignment]
        try:
            super().train(gradient_steps, batch_size)
        finally:
            self.q_net_target = target_net


def double_q(
    online_net: Callable[[th.Tensor], th.Tensor], target_net: Callable[[th.Tensor], th.Tensor]
) -> Callable[[th.Tensor], th.Tensor]:
    """Let one network pick the action and another judge it.

    :param online_net: picks: action values [B, A] of observations
    :param target_net: judges: the same of its own
    :return: the target network's value [B, 1] of the online network's greedy action
    """

    def value(observations: th.Tensor) -> th.Tensor:
        chosen = online_net(observations).argmax(dim=1, keepdim=True)
        return target_net(observations).gather(1, chosen)

    return value
