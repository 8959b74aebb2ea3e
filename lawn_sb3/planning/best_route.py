"""The best route as if alone: what planning for oneself is worth, and what each UAV would have without the others."""

from collections.abc import Callable

from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning.flight import ANY_SLACK
from lawn_sb3.planning.plan import Plan
from lawn_sb3.planning.plan_player import PlanPlayer
from lawn_sb3.planning.routes import routes_alone


class BestRoutePlayer(PlanPlayer):
    """Every UAV flies the route with the highest utility as if it were alone; it looks at nobody."""

    name = "best-route"

    def plan(self, simulator: Simulator, game: int) -> Plan:
        """Plan every UAV as if it were alone."""
        return routes_alone(simulator.rules, simulator.state, game, self.slack)


class BoundPlayer(BestRoutePlayer):
    """The same over all flight times, each UAV alone in the network: an upper bound on every joint trajectory.

    A rate never rises with the load, so no UAV can have more among others than its best alone, and no joint trajectory
    has a higher welfare than the sum. Nobody can fly this bound; the evaluation gives every UAV a game of its own.

    :param on_game: called after each game that has been planned
    """

    name = "bound"
    flies_alone = True

    def __init__(self, on_game: Callable[[], None] | None = None) -> None:
        super().__init__(ANY_SLACK, on_game)
