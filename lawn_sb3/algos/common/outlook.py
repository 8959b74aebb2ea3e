"""The map around a UAV, and with it what each move would lose by the forecast: as if the loads now never changed."""

import numpy as np
import torch as th

from lawn_sb3.algos.common.around import Around
from lawn_sb3.envs.observation import LOAD_UNIT_UAVS, SLOT_UNIT, ObservationLayout
from lawn_sb3.game.radio import rate_unit_mbps
from lawn_sb3.game.state import build_rules
from lawn_sb3.planning import first_move_losses
from lawn_sb3.scenario import Scenario

MOST_LOST = 1.0
"""Losses above so many units of the rewards, such as those of moves that are too late, are told as this."""


class Outlook(Around):
    """What :class:`Around` gives, followed by what each turned move loses, in the unit of the rewards.

    Nothing is seen that o_i and the clock do not hold: the losses are worked out from them.

    :param scenario: the game
    :param layout: where everything lies in the flat observation, which holds the clock
    """

    def __init__(self, scenario: Scenario, layout: ObservationLayout) -> None:
        self._rules, self._unit_mbps = build_rules(scenario), rate_unit_mbps(scenario)
        super().__init__(scenario, layout)

    def forward(self, seen: th.Tensor) -> tuple[th.Tensor, th.Tensor]:
        """Encode.

        :param seen: local observations o_i and what else is seen [B, anything]
        :return: features [B, width], of which the last are the losses of the turned moves, and the turn [B]
        """
        features, turn = super().forward(seen)
        losses = self._losses(seen).to(features.device)
        turned = th.empty_like(losses).scatter_(1, self.action[turn], losses)
        return th.cat([features, turned], dim=1), turn

    def losses_of(self, features: th.Tensor) -> th.Tensor:
        """The losses of the turned moves [B, A], out of features [B, width]."""
        return features[:, -self.action.shape[1] :]

    def _losses(self, seen: th.Tensor) -> th.Tensor:
        """What each move loses, in the unit of the rewards and at most :data:`MOST_LOST` [B, A]; in main memory."""
        layout, own = self.layout, seen.detach().cpu()
        places = (seen[:, columns].detach() for columns in (layout.position, layout.destination))
        here, goal = (self._voxels(place).cpu().numpy() for place in places)
        least, flown = (
            (own[:, columns] * SLOT_UNIT).round().long().flatten().numpy()
            for columns in (layout.min_slots, layout.extra("clock"))
        )
        others = (own[:, layout.cell_loads] * LOAD_UNIT_UAVS).round().long().numpy()
        others[np.arange(len(own)), self._rules.cell[tuple(here.T)]] -= 1
        least = least.clip(min=1)  # rows of zeros, which are no missions, are encoded too
        mbps = first_move_losses(self._rules, here, goal, least, flown, others.clip(min=0))
        return th.as_tensor((mbps / self._unit_mbps).clip(max=MOST_LOST).astype(np.float32))
