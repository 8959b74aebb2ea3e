"""Many games in one environment, for training: nobody ever leaves, and a whole vector step is one compiled call."""

from collections.abc import Collection
from typing import Any, ClassVar, Literal, get_args

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from lawn_sb3.choices import REWARD_TERMS, Continuation, Credit, RewardTerm, is_whole
from lawn_sb3.envs.observation import EXTRAS, Extra, Observer, space_of
from lawn_sb3.envs.rendering import draw_picture
from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.game.externality import losses_to_others
from lawn_sb3.game.simulator import Simulator, Snapshot
from lawn_sb3.game.state import Outcome
from lawn_sb3.scenario import Scenario

Timeout = Literal["terminal", "truncated"]


def check_timeout(timeout: Timeout) -> Timeout:
    """Refuse a reading of the deadline that does not exist."""
    if timeout not in get_args(Timeout):
        raise unknown_name("timeout", timeout, get_args(Timeout))
    return timeout


def check_scenario(scenario: Scenario) -> Scenario:
    """Refuse what is no scenario, such as the name of one."""
    if not isinstance(scenario, Scenario):
        raise UserError(
            f"scenario {scenario!r} is no Scenario; load_scenario(NAME) makes one, and lawn_v0.parallel_env(NAME) "
            "takes a name"
        )
    return scenario


def not_started() -> UserError:
    """The error of whoever steps an environment before its first reset."""
    return UserError("no game was started: reset() starts one")


class TrainingEnv(ParallelEnv):  # type: ignore[misc]
    """G games of N UAVs as one parallel environment of G x N agents; agent g * N + i is UAV i of game g.

    Every agent observes the flat vector [o_i | x]. No agent ever terminates in PettingZoo's sense: a UAV whose mission
    has ended goes on with its next one (``mission``), or waits for its game to restart (``episode``). A mission's end
    shows in the agent's info, which is empty otherwise: ``episode`` (``r`` accumulated reward, ``l`` slots),
    ``is_success``, ``utility_mbps``, ``terminal_observation`` and, with ``timeout="truncated"``,
    ``TimeLimit.truncated``.

    The arguments are those of :func:`lawn_sb3.envs.make_vec_env`. A timeout is a terminal state, as in
    Eq. (18), eq:terminal, or a truncation; ``episode`` in an info counts also those terms that are left out of the
    reward, and a ``team``'s reward is also given to those that wait for their game to restart.
    """

    metadata: ClassVar[dict[str, Any]] = {"name": "lawn_training_v0", "render_modes": ["rgb_array"]}
    render_mode = "rgb_array"
    row_per_agent: ClassVar[frozenset[str]] = frozenset({"action_masks", "flying"})
    """Methods that answer with one row per agent."""

    def __init__(
        self,
        scenario: Scenario,
        num_games: int,
        continuation: Continuation = "mission",
        timeout: Timeout = "terminal",
        seed: int | None = None,
        without_reward: Collection[RewardTerm] = (),
        extras: Collection[Extra] = (),
        slack: int | None = None,
        credit: Credit = "own",
        fewest_uavs: int | None = None,
    ) -> None:
        self.scenario = check_scenario(scenario)
        self.timeout = check_timeout(timeout)
        if slack is not None and not (is_whole(slack) and slack >= 0):
            raise UserError(f"slack = {slack!r}: a whole number from 0 up")
        self.slack = slack
        for extra in extras:
            if extra not in EXTRAS:
                raise unknown_name("extra", extra, EXTRAS)
        if credit not in get_args(Credit):
            raise unknown_name("credit", credit, get_args(Credit))
        self.credit = credit
        self.simulator = Simulator(scenario, num_games, seed, continuation, fewest_uavs)
        self.observer = Observer(scenario, extras)
        self.layout = self.observer.layout
        self.possible_agents = [f"game_{g}_uav_{i}" for g in range(num_games) for i in range(scenario.num_uavs)]
        self.agents = list(self.possible_agents)
        self._observation_space = space_of(self.layout.flat_dim)
        self._action_space = spaces.Discrete(self.simulator.num_actions)
        self._never = dict.fromkeys(self.possible_agents, False)
        self.started = False
        """Whether the games were started, by a reset or by going back to others."""
        self._reward_sum = np.zeros((num_games, scenario.num_uavs))
        for term in without_reward:
            if term not in REWARD_TERMS:
                raise unknown_name("reward term", term, REWARD_TERMS)
        self._given = [k for k, term in enumerate(REWARD_TERMS) if term not in without_reward]

    def observation_space(self, agent: str) -> spaces.Box:
        """Space of the flat observation, the same for all agents."""
        return self._observation_space

    def action_space(self, agent: str) -> spaces.Discrete:
        """Space of the actions, the same for all agents."""
        return self._action_space

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.float32]], dict[str, dict[str, Any]]]:
        """Start all games anew.

        :param seed: seed of the missions; without one the stream goes on
        :param options: ignored
        :return: observations and empty infos
        """
        self.simulator.reset(seed=seed)
        self._reward_sum[:] = 0.0
        self.started = True
        return self._observe(), {agent: {} for agent in self.agents}

    def step(
        self, actions: dict[str, int]
    ) -> tuple[
        dict[str, NDArray[np.float32]], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
    ]:
        """Play one slot of all games.

        :param actions: one action per agent
        :return: observations, rewards, terminations and truncations (never), infos
        """
        chosen = np.fromiter((actions[agent] for agent in self.agents), dtype=np.int64, count=len(self.agents))
        outcome = self.simulator.step(chosen.reshape(self._reward_sum.shape))
        self._reward_sum += outcome.reward_terms.sum(axis=-1)
        rewards = self._credited(outcome.reward_terms[..., self._given].sum(axis=-1))
        infos: dict[str, dict[str, Any]] = {agent: {} for agent in self.agents}
        self._report_ends(outcome, infos)
        self.simulator.go_on()
        reward_of = dict(zip(self.agents, rewards.ravel().tolist(), strict=True))
        return self._observe(), reward_of, dict(self._never), dict(self._never), infos

    def _credited(self, own: NDArray[np.float64]) -> NDArray[np.float64]:
        """Rewards as learners are given them [G, N], from the UAVs' own ones."""
        if self.credit == "team":
            return np.broadcast_to(own.mean(axis=1, keepdims=True), own.shape)
        if self.credit == "difference":
            rules = self.simulator.rules
            return own - losses_to_others(rules, self.simulator.state, self.simulator.outcome) / rules.rate_unit_mbps
        return own

    def action_masks(self) -> NDArray[np.bool_]:
        """Which moves are allowed [G * N, A], under the name by which sb3-contrib's ``MaskablePPO`` asks."""
        return self.simulator.allowed_moves(self.slack).reshape(len(self.agents), -1)

    def flying(self) -> NDArray[np.bool_]:
        """Who is in the air [G * N]."""
        return self.simulator.state.flying.flatten()

    def _report_ends(self, outcome: Outcome, infos: dict[str, dict[str, Any]]) -> None:
        """Fill the infos of the missions that have just ended."""
        ends = np.argwhere(outcome.arrived | outcome.timed_out)
        if not len(ends):
            return
        last = self.observer.flat(self.simulator.state)
        for g, i in ends:
            info = infos[self.agents[g * self.scenario.num_uavs + i]]
            info["episode"] = {"r": float(self._reward_sum[g, i]), "l": int(self.simulator.state.slot[g, i])}
            info["is_success"] = bool(outcome.arrived[g, i])
            info["utility_mbps"] = float(outcome.utility_mbps[g, i])
            info["terminal_observation"] = last[g, i].copy()
            if self.timeout == "truncated" and outcome.timed_out[g, i]:
                info["TimeLimit.truncated"] = True
            self._reward_sum[g, i] = 0.0

    def _observe(self) -> dict[str, NDArray[np.float32]]:
        flat = self.observer.flat(self.simulator.state)
        return dict(zip(self.agents, flat.reshape(len(self.agents), -1), strict=True))

    def render(self, most: int = 1) -> list[NDArray[np.uint8]]:
        """Draw the games from above.

        :param most: games that are drawn at most, from the first on
        :return: one picture [480, 480, 3] for each
        """
        state = self.simulator.state
        return [draw_picture(self.scenario, state, game) for game in range(min(most, len(state.position)))]

    def snapshot(self) -> tuple[Snapshot, NDArray[np.float64]]:
        """Copy all that the future depends on: the simulator's snapshot and the rewards accumulated so far."""
        return self.simulator.snapshot(), self._reward_sum.copy()

    def restore(self, snapshot: tuple[Snapshot, NDArray[np.float64]]) -> None:
        """Go back to what :meth:`snapshot` returned."""
        self.simulator.restore(snapshot[0])
        self._reward_sum = snapshot[1].copy()
        self.started = True
