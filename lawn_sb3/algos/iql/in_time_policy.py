"""A learner's policy whose moves are in time, in the symmetric frame."""

from typing import Any

from stable_baselines3.dqn.policies import DQNPolicy, QNetwork

from lawn_sb3.algos.common.in_time import InTimeValues
from lawn_sb3.envs.observation import ObservationLayout


class InTimeQPolicy(InTimeValues, DQNPolicy):
    """SB3's DQN policy over o_i and the clock: a Q-network in the symmetric frame, whose moves are in time.

    :param args: what SB3's ``DQNPolicy`` takes, as ``kwargs`` and what :class:`InTimeValues` and its base take
    :param layout: where o_i and the clock lie in what a learner sees
    :param net_arch: widths of the hidden layers; two of 256, as the paper's networks have
    """

    def __init__(self, *args: Any, layout: ObservationLayout, net_arch: list[int] | None = None, **kwargs: Any) -> None:
        self.layout = layout
        super().__init__(*args, net_arch=[256, 256] if net_arch is None else net_arch, **kwargs)

    def make_q_net(self) -> QNetwork:
        """SB3's Q-network, or its target, with layers that answer in the symmetric frame."""
        made = super().make_q_net()
        made.q_net = self.make_layers(int(self.action_space.n))  # type: ignore[assignment, attr-defined]
        return made.to(self.device)

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return {**super()._get_constructor_parameters(), "layout": self.layout}
