"""The best route as if alone: what planning for oneself is worth, and what everybody would have without the others."""

from __future__ import annotations

from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning.plan import Plan
from lawn_sb3.planning.plan_player import PlanPlayer
from lawn_sb3.planning.routes import routes_alone


class BestRoutePlayer(PlanPlayer):
    """Every UAV flies the route with the highest utility as if it were alone; it looks at nobody."""

    name = "best-route"

    def plan(self, simulator: Simulator, game: int) -> Plan:
        """Plan every UAV as if it were alone.

        :param simulator: the games
        :param game: index of the game
        :return: the joint plan
        :raises UserError: naming the UAV that cannot be at its destination in time
        """
        return routes_alone(simulator.rules, simulator.state, game, self.slack)


class BoundPlayer(BestRoutePlayer):
    """The same routes, each UAV really alone in the network: an upper bound on the welfare of every joint trajectory.

    A rate never rises with the load, so no UAV can have more among others than the best it can have alone. Nobody can
    fly this bound; the evaluation gives every UAV a game of its own.
    """

    name = "bound"
    flies_alone = True
