"""The mean-field planners: every UAV plans anew in every slot, by what experience says of the cells it may come to.

They estimate the best that UAVs can do with some knowledge; they do not prove it. Each UAV's flight is exact against
the means that it expects. That everybody flies so and the means come true is one fixed point among others, and a UAV
does not plan for what it will see on its way.
"""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning.mean_field.fit import Fit, OnRound, first_moves, fit_tables
from lawn_sb3.planning.mean_field.sight import Senses
from lawn_sb3.planning.mean_field.tables import Tables
from lawn_sb3.planning.plan import check_in_time
from lawn_sb3.scenario import Scenario

DEFAULT_ROUNDS = 14
"""Rounds of flying by the tables and fitting them anew."""


class MeanFieldPlayer:
    """Every UAV flies the first move of its best flight against the RB shares that it expects of each cell.

    It is decentralised: a UAV knows its own o_i, Eq. (12), eq:obs, and how many slots it has flown, nothing else. What
    it may expect some slots ahead was learned by flying the planner itself, on missions of its own; so was what its
    presence in a cell will cost the others, which counts as much as its own utility. It cannot avoid collisions.

    :param slack: slots beyond T_i^min that a flight may take
    :param seed: seed of the missions on which the tables are fitted
    :param rounds: rounds of flying by the tables and fitting them anew
    :param episodes: joint episodes per round; by default as many as a scenario allows in reasonable time
    :param on_round: called after each round with the rounds done and all rounds
    """

    name = "mean-field"
    senses: ClassVar[Senses] = Senses(destinations=False, memory=False)
    tables: Tables
    """What to expect, once started."""

    def __init__(
        self,
        slack: int = 0,
        seed: int = 0,
        rounds: int = DEFAULT_ROUNDS,
        episodes: int | None = None,
        on_round: OnRound | None = None,
    ) -> None:
        self.slack = slack
        self._fit = Fit(self.senses, slack, seed, rounds, episodes)
        self._on_round = on_round
        self._fitted_to: Scenario | None = None

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Check that all missions can be flown in time, and fit the tables if they belong to another scenario.

        :param simulator: the games
        :param rng: not needed: the tables depend on the player's own seed alone
        :raises UserError: naming the UAV that cannot be at its destination in time
        """
        check_in_time(simulator.rules, simulator.state)
        if self._fitted_to != simulator.scenario:
            self.tables = fit_tables(simulator.scenario, self._fit, self._on_round)
            self._fitted_to = simulator.scenario

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Plan anew, and take the first moves [G, N]; works for any games of the scenario of the tables."""
        return first_moves(simulator.rules, simulator.state, self.tables, self.senses, self.slack)


class MeanFieldDestinationsPlayer(MeanFieldPlayer):
    """The same if every UAV also knows how many others in the air head for each cell: more than o_i holds."""

    name = "mean-field-destinations"
    senses = Senses(destinations=True, memory=False)


class MeanFieldMemoryPlayer(MeanFieldPlayer):
    """The same if every UAV also remembers the cell loads that it saw one slot before."""

    name = "mean-field-memory"
    senses = Senses(destinations=False, memory=True)
