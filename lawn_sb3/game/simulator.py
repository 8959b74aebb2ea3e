"""The simulator: G games of N UAVs, advanced together."""

import copy
from typing import Any, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.choices import Continuation, check_fewest, is_whole
from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.game.airspace import Missions, check_missions, draw_missions, moves_in_time, moves_inside
from lawn_sb3.game.kernel import renew_missions, start_games, step_games, thin_games
from lawn_sb3.game.state import Outcome, State, build_rules, empty_outcome, empty_state
from lawn_sb3.scenario import Scenario

Seed = int | np.random.SeedSequence | None


class Snapshot(NamedTuple):
    """What :meth:`Simulator.restore` needs to go on as if nothing had happened."""

    state: State
    random_state: dict[str, Any]


class Simulator:
    """G games of N UAVs that share one airspace each.

    ``step`` plays one slot; UAVs that are done stop flying and stay down until ``go_on`` gives them something to do:
    with ``mission`` a new mission at once (Algorithm 1), with ``episode`` a new game once all of theirs are done.

    :param scenario: the constants of the game
    :param num_games: number of games G
    :param seed: seed of the missions
    :param continuation: how UAVs that are done go on
    :param fewest_uavs: with ``episode``, each new game has ``fewest_uavs`` to N UAVs, all numbers equally likely;
        by default all N
    :raises UserError: if ``num_games``, ``continuation`` or ``fewest_uavs`` is not allowed
    """

    state: State
    """The state of all games; read it, do not write it."""

    def __init__(
        self,
        scenario: Scenario,
        num_games: int = 1,
        seed: Seed = None,
        continuation: Continuation = "mission",
        fewest_uavs: int | None = None,
    ) -> None:
        if not is_whole(num_games) or num_games < 1:
            raise UserError(f"num_games = {num_games!r}: at least 1 game")
        if continuation not in get_args(Continuation):
            raise unknown_name("continuation", continuation, get_args(Continuation))
        if fewest_uavs is not None:
            check_fewest(fewest_uavs, scenario, continuation)
        self.scenario = scenario
        self.num_games = num_games
        self.continuation = continuation
        self.fewest_uavs = fewest_uavs
        self.rules = build_rules(scenario)
        self.outcome = empty_outcome(num_games, scenario.num_uavs)
        self._crowd = np.zeros(scenario.grid, dtype=np.int64)
        self.reset(seed=seed)

    @property
    def num_actions(self) -> int:
        """Size of the action set A_i."""
        return len(self.rules.actions)

    def reset(self, seed: Seed = None, missions: Missions | None = None) -> None:
        """Start all games anew.

        :param seed: seed of the missions; without one the stream goes on, at first from fresh entropy
        :param missions: origins and destinations to fly, in voxels; drawn at random if left out
        :raises UserError: if a mission cannot be flown
        """
        if seed is not None or not hasattr(self, "_rng"):
            try:
                self._rng = np.random.default_rng(seed)
            except (TypeError, ValueError):
                raise UserError(f"seed = {seed!r}: a whole number from 0 up") from None
        drawn = missions is None
        if missions is None:
            missions = draw_missions(self.scenario, self.num_games, self._rng)
        else:
            missions = check_missions(self.scenario, missions, self.num_games)
        self.state = empty_state(self.num_games, self.scenario.num_uavs, self.scenario.num_gbs)
        self.state.position[:] = missions.origins
        self.state.destination[:] = missions.destinations
        start_games(self.rules, self.state)
        if drawn and self.fewest_uavs is not None:
            thin_games(self.rules, self.state, self._rng, self.fewest_uavs, np.ones(self.num_games, dtype=bool))

    def step(self, actions: NDArray[np.integer[Any]]) -> Outcome:
        """Play one slot of every game.

        :param actions: indices into ``rules.actions`` [G, N]; those of UAVs that are not flying are ignored
        :return: what the slot gave; the arrays are overwritten by the next step
        :raises UserError: if the actions have another shape or name an action that does not exist
        """
        actions = np.asarray(actions)
        if actions.shape != self.state.flying.shape:
            raise UserError(f"actions have shape {actions.shape}, expected {self.state.flying.shape} (games, UAVs)")
        if not np.issubdtype(actions.dtype, np.integer):
            raise UserError(f"actions must be whole numbers, not {actions.dtype}")
        if actions.min() < 0 or actions.max() >= self.num_actions:
            raise UserError(f"actions must be whole numbers from 0 to {self.num_actions - 1}")
        chosen = np.ascontiguousarray(actions, dtype=np.int64)
        step_games(self.rules, self.state, self.outcome, chosen, self._crowd)
        return self.outcome

    def go_on(self) -> None:
        """Give UAVs that are done their next mission, or games that are done their next episode."""
        over = np.logical_not(self.state.flying.any(axis=1))
        renew_missions(self.rules, self.state, self._rng, self.continuation == "episode")
        if self.fewest_uavs is not None:
            thin_games(self.rules, self.state, self._rng, self.fewest_uavs, over)

    def allowed_moves(self, slack: int | None = None) -> NDArray[np.bool_]:
        """The moves that a masked player may take.

        :param slack: allow only moves that keep arrival within T_i^min + ``slack`` slots possible; by default, all
            moves inside the airspace
        :return: true for a move that is allowed [G, N, A]
        """
        state, rules = self.state, self.rules
        if slack is None:
            return moves_inside(state.position, rules.actions, rules.grid)
        left = np.minimum(state.min_slots + slack, rules.max_slots) - state.slot
        return moves_in_time(state.position, state.destination, left, rules.actions, rules.grid, rules.max_voxel_steps)

    def snapshot(self) -> Snapshot:
        """Copy all that the future depends on, random state included."""
        return Snapshot(copy.deepcopy(self.state), copy.deepcopy(dict(self._rng.bit_generator.state)))

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to a snapshot of this simulator or of one of the same shape.

        :param snapshot: what :meth:`snapshot` returned
        :raises UserError: if it was taken from games of another shape
        """
        for mine, theirs in zip(self.state, snapshot.state, strict=True):
            if mine.shape != theirs.shape:
                raise UserError(f"the snapshot holds arrays of shape {theirs.shape}, this simulator {mine.shape}")
        self.state = copy.deepcopy(snapshot.state)
        self._rng = np.random.default_rng()
        self._rng.bit_generator.state = copy.deepcopy(snapshot.random_state)
