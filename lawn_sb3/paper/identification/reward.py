"""What the constants of the reward do to J: the terms of one set of flights, weighed anew.

Rate and navigation rewards telescope, so the rewards of Eq. (14), eq:reward, add up over a mission to

    J_i = nav_weight * progress_i - collision_penalty * collisions_i - fail_penalty * failed_i
          + (R-bar_i(T_i) + U_i) / rate unit

with progress in voxels of Euclidean distance. J alone can identify these constants only jointly: they form a plane.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.game.player import Player
from lawn_sb3.game.radio import rate_unit_mbps
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.paper.identification.candidates import PAPER, Candidate
from lawn_sb3.paper.printed_values import ROUNDING, TABLE_II
from lawn_sb3.paper.standard_error import DISFAVOURED_Z, standard_error
from lawn_sb3.scenario import Scenario

TERMS = ("progress_voxels", "collisions", "failed", "rate_sum_mbps")
"""What the constants weigh; the last is R-bar_i(T_i) + U_i."""

OTHER_COLUMNS = (
    *("constant", "candidate", "is_preset", "method"),
    *("reward", "reward_paper", "reward_difference"),
    *("rate_mbps", "rate_mbps_paper", "rate_mbps_difference"),
)


def reward_terms(player: Player, scenario: Scenario, episodes: int, seed: int) -> pd.DataFrame:
    """Fly, and take the reward apart.

    :param player: the player
    :param scenario: the game; its weights are ignored
    :param episodes: number of joint episodes
    :param seed: picks the missions
    :return: one row per episode and UAV, with the columns ``episode, uav`` and ``TERMS``
    """
    weightless = scenario.changed(nav_weight=1.0, collision_penalty=0.0, fail_penalty=0.0)
    rows = evaluate(player, weightless, episodes, seed)
    horizon = rows["slots"] if scenario.bias_horizon == "completion" else scenario.max_slots
    ema_mbps = rows["rate_mbps"] * (1.0 - (1.0 - scenario.ema_beta) ** horizon)
    rate_sum_mbps = ema_mbps + rows["utility_mbps"]
    return rows[["episode", "uav"]].assign(
        progress_voxels=rows["reward"] - rate_sum_mbps / rate_unit_mbps(weightless),
        collisions=rows["collisions"].astype(float),
        failed=1.0 - rows["arrived"],
        rate_sum_mbps=rate_sum_mbps,
    )


def weights(scenario: Scenario) -> dict[str, float]:
    """The reward that a scenario pays for one unit of each of ``TERMS``."""
    penalties = (-scenario.collision_penalty, -scenario.fail_penalty)
    return dict(zip(TERMS, (scenario.nav_weight, *penalties, 1.0 / rate_unit_mbps(scenario)), strict=True))


def accumulated_reward(terms: pd.DataFrame, scenario: Scenario) -> pd.Series:
    """The reward J_i of every UAV under a scenario's weights, whose other constants must be those of the flights."""
    return terms[list(TERMS)] @ pd.Series(weights(scenario))


def linear_table(terms: pd.DataFrame, scenario: Scenario) -> pd.DataFrame:
    """J of Random as a linear function of the constants, and what each must be if the others are right.

    :param terms: what :func:`reward_terms` returned for the Random player
    :param scenario: the scenario that was flown
    :return: one row per term: ``constant``, the mean of its term over UAVs (``coefficient``, signed) and that mean's
        ``standard_error``, the constant's ``value``, its ``contribution`` to J, and the values ``needed`` for the
        paper's J, from ``needed_low`` to ``needed_high`` within ``DISFAVOURED_Z`` standard errors; a weight below 0
        cannot be meant
    """
    by_episode = terms.groupby("episode")[list(TERMS)].mean()
    weight, signs = pd.Series(weights(scenario)), pd.Series([1.0, -1.0, -1.0, 1.0], index=list(TERMS))
    coefficient = by_episode.mean() * signs
    value = weight * signs
    reward = accumulated_reward(terms, scenario).groupby(terms["episode"]).mean()
    error = standard_error(reward, ROUNDING.reward)
    short = TABLE_II["Random"].reward - float(reward.mean())
    slack = DISFAVOURED_Z * error / coefficient.abs()
    return pd.DataFrame(
        {
            "constant": ["nav_weight", "collision_penalty", "fail_penalty", "1 / rate unit (1/Mbps)"],
            "term": list(TERMS),
            "coefficient": coefficient.to_numpy(),
            "standard_error": (by_episode.std() / np.sqrt(len(by_episode))).to_numpy(),
            "value": value.to_numpy(),
            "contribution": (coefficient * value).to_numpy(),
            "needed": (value + short / coefficient).to_numpy(),
            "needed_low": (value + short / coefficient - slack).to_numpy(),
            "needed_high": (value + short / coefficient + slack).to_numpy(),
        }
    )


class Repeater:
    """Flies once as another player does, and from then on repeats the actions of that flight.

    :param player: who flies first
    """

    def __init__(self, player: Player) -> None:
        self.name = player.name
        self._player: Player | None = player
        self._taken: list[NDArray[np.int64]] = []

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Get the player ready, or go back to the first action."""
        if self._taken:
            self._player, self._left = None, iter(self._taken)
        if self._player is not None:
            self._player.start(simulator, rng)

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Ask the player, or repeat its next actions [G, N]."""
        if self._player is None:
            return next(self._left)
        self._taken.append(self._player.act(simulator).copy())
        return self._taken[-1]


def other_rows(
    name: str, player: Player, tried: Sequence[Candidate], episodes: int, seed: int
) -> list[dict[str, object]]:
    """What the flights of a trained player are worth under each candidate.

    It flies once, in the scenario it was trained in: with another rate unit or EMA rate it would see other
    observations than it knows. Its actions are then repeated under the candidates, which must leave the dynamics alone.

    :param name: the player's row in the paper's Table II
    :param player: the player, greedy as in the paper
    :param tried: candidates for constants of the reward
    :param episodes: number of joint episodes
    :param seed: picks the missions
    :return: one row per candidate: its J and R-hat, the paper's and the differences
    """
    repeater = Repeater(player)
    evaluate(repeater, PAPER, episodes, seed)
    printed = TABLE_II[name]
    rows: list[dict[str, object]] = []
    for candidate in tried:
        flown = evaluate(repeater, candidate.scenario, episodes, seed)
        reward, rate_mbps = float(flown["reward"].mean()), float(flown["rate_mbps"].mean())
        values = (
            *(candidate.constant, candidate.label, candidate.is_preset, name),
            *(reward, printed.reward, reward - printed.reward),
            *(rate_mbps, printed.rate_mbps, rate_mbps - printed.rate_mbps),
        )
        rows.append(dict(zip(OTHER_COLUMNS, values, strict=True)))
    return rows
