"""Players that plan all trajectories of a game at its first slot, seeing everything, and then fly them."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.simulator import Simulator
from lawn_sb3.game.state import State
from lawn_sb3.planning.flight import DEFAULT_SLACK
from lawn_sb3.planning.plan import Plan, check_in_time


class _Course(NamedTuple):
    """A plan that is being flown."""

    plan: Plan
    destinations: NDArray[np.int64]  # [N, 3]
    began: NDArray[np.int64]  # [N] slots flown when the plan was made


class PlanPlayer(ABC):
    """Plans each game as a whole, and plans a game anew if it is not as planned, as after a new mission.

    :param slack: slots beyond T_i^min that a flight may take
    :param on_game: called after each game that has been planned
    """

    name: str

    def __init__(self, slack: int = DEFAULT_SLACK, on_game: Callable[[], None] | None = None) -> None:
        self.slack = slack
        self._on_game = on_game

    @abstractmethod
    def plan(self, simulator: Simulator, game: int) -> Plan:
        """Plan the trajectories of one game.

        :param simulator: the games
        :param game: index of the game
        :return: the joint plan
        :raises UserError: naming the UAV that cannot be at its destination in time
        """

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Plan all games.

        :param simulator: the games
        :param rng: source of what is drawn in planning
        :raises UserError: naming the UAV that cannot be at its destination in time
        """
        self._rng = rng
        state, rules = simulator.state, simulator.rules
        check_in_time(rules, state)
        span = 2 * rules.max_voxel_steps + 1
        self._index = np.zeros((span, span, span), dtype=np.int64)
        self._index[tuple((rules.actions + rules.max_voxel_steps).T)] = np.arange(len(rules.actions))
        self._courses = [self._set_course(simulator, game) for game in range(len(state.flying))]

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Fly on as planned, and plan anew where a game is not as planned [G, N]."""
        actions = np.zeros(simulator.state.flying.shape, dtype=np.int64)
        for game in range(len(actions)):
            if _is_off(self._courses[game], simulator.state, game):
                self._courses[game] = self._set_course(simulator, game)
            plan, _, began = self._courses[game]
            flying = np.flatnonzero(simulator.state.flying[game])
            following = simulator.state.slot[game, flying] - began[flying] + 1
            moves = plan.voxels[flying, following] - simulator.state.position[game, flying]
            actions[game, flying] = self._index[tuple((moves + simulator.rules.max_voxel_steps).T)]
        return actions

    def _set_course(self, simulator: Simulator, game: int) -> _Course:
        state = simulator.state
        course = _Course(self.plan(simulator, game), state.destination[game].copy(), state.slot[game].copy())
        if self._on_game is not None:
            self._on_game()
        return course


def _is_off(course: _Course, state: State, game: int) -> bool:
    """Whether any UAV that flies is not where the plan has it, or on another mission."""
    flying = np.flatnonzero(state.flying[game])
    flown = state.slot[game, flying] - course.began[flying]
    if ((flown < 0) | (flown >= course.plan.slots[flying])).any():
        return True
    planned = course.plan.voxels[flying, flown]
    elsewhere = planned != state.position[game, flying]
    return bool(elsewhere.any() or (course.destinations[flying] != state.destination[game, flying]).any())
