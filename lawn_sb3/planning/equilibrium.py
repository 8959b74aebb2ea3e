"""Iterated best response: joint trajectories from which no UAV gains by deviating alone, and the welfare found so."""

from collections.abc import Callable, Iterator
from typing import ClassVar

import numpy as np

from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning.best_response import Aim, settle
from lawn_sb3.planning.flight import DEFAULT_SLACK
from lawn_sb3.planning.plan import Plan, planned_collisions, planned_utilities_mbps
from lawn_sb3.planning.plan_player import PlanPlayer
from lawn_sb3.planning.routes import routes_alone, straight_routes


class SearchPlayer(PlanPlayer):
    """Lets the UAVs of a game respond in turn from several starts, and keeps one of the joint plans found.

    The first start is everybody's best route as if alone, the others are random shortest paths.

    :param slack: slots beyond T_i^min that a flight may take
    :param on_game: called after each game that has been planned
    :param starts: number of starts per game
    """

    aim: ClassVar[Aim]
    keeps_worst: ClassVar[bool] = False

    def __init__(self, slack: int = DEFAULT_SLACK, on_game: Callable[[], None] | None = None, starts: int = 16) -> None:
        super().__init__(slack, on_game)
        self.starts = starts

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Plan all games, and count how the searches end."""
        self.searches = 0
        """Searches made in all games."""
        self.longest_rounds = 0
        """Rounds that the longest search took."""
        self.cycles = 0
        """Searches that came back to an earlier joint plan instead of a fixed point."""
        self.cut = 0
        """Searches that did neither within ``MOST_ROUNDS`` rounds."""
        self.unsettled = 0
        """Games without any fixed point found; they fly the last joint plan of the best search."""
        super().start(simulator, rng)

    def plan(self, simulator: Simulator, game: int) -> Plan:
        """Search from all starts.

        :return: fixed points come before others, and fewer collisions before more; then the joint plan with the highest
            welfare, or the lowest if the worst is kept
        """
        rules, state = simulator.rules, simulator.state
        found: list[tuple[bool, int, float, Plan]] = []
        for plan in self._first_plans(simulator, game):
            settled = settle(rules, state, game, plan, self.aim, self.slack)
            collisions = int(planned_collisions(rules, plan).sum())
            welfare_mbps = float(planned_utilities_mbps(rules, state, game, plan).sum())
            wanted = -welfare_mbps if self.keeps_worst else welfare_mbps
            found.append((settled.is_fixed, -collisions, wanted, plan))
            self.searches += 1
            self.longest_rounds = max(self.longest_rounds, settled.rounds)
            self.cycles += settled.period > 0
            self.cut += not settled.is_fixed and settled.period == 0
        self.unsettled += not any(one[0] for one in found)
        return max(found, key=lambda one: one[:3])[3]

    def _first_plans(self, simulator: Simulator, game: int) -> Iterator[Plan]:
        rules, state = simulator.rules, simulator.state
        yield routes_alone(rules, state, game, self.slack)
        for _ in range(self.starts - 1):
            yield straight_routes(rules, state, game, self.slack, self._rng)


class EquilibriumPlayer(SearchPlayer):
    """A Nash equilibrium of trajectories: of those that iterated best response finds, the one with the highest welfare.

    Nothing guarantees that there is one, nor that it is found; how the searches ended is counted. Deviations are tried
    up to the slack: regrets, which try all flight times, tell whether longer ones would gain.
    """

    name = "equilibrium"
    aim = "utility"


class WorstEquilibriumPlayer(EquilibriumPlayer):
    """The equilibrium with the lowest welfare of those found: where selfish UAVs may end up."""

    name = "worst-equilibrium"
    keeps_worst = True


class WelfarePlayer(SearchPlayer):
    """Coordinate ascent on the welfare, Eq. (10), eq:welfare: every UAV responds for the sum of all utilities.

    It climbs from each start, and from where selfish responses lead from there, so that it never ends below an
    equilibrium that :class:`EquilibriumPlayer` finds from the same starts. It ends where no single trajectory can be
    changed for the better; the best of all ends is a lower bound on the largest welfare. Every UAV arrives, even where
    the others would have more if it never did.
    """

    name = "welfare"
    aim = "welfare"

    def _first_plans(self, simulator: Simulator, game: int) -> Iterator[Plan]:
        for plan in super()._first_plans(simulator, game):
            selfish = Plan(plan.voxels.copy(), plan.slots.copy())
            settle(simulator.rules, simulator.state, game, selfish, "utility", self.slack)
            yield plan
            yield selfish
