"""The game as a strict PettingZoo environment: one game, UAVs leave when they are done, infos hold raw quantities."""

import operator
import warnings
from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NoReturn, TypeVar, get_args

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from lawn_sb3.choices import REWARD_TERMS
from lawn_sb3.envs.observation import Observer, space_of
from lawn_sb3.envs.rendering import draw_picture, draw_text
from lawn_sb3.envs.training_env import Timeout, check_scenario, check_timeout, not_started
from lawn_sb3.envs.window import Window
from lawn_sb3.errors import UserError
from lawn_sb3.game.airspace import Missions
from lawn_sb3.game.radio import rb_share
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.game.state import Outcome
from lawn_sb3.scenario import PRESETS, Scenario

Observations = dict[str, NDArray[np.float32]]
Infos = dict[str, dict[str, Any]]
RenderMode = Literal["human", "ansi", "rgb_array", "rgb_array_list"]
V = TypeVar("V")


class HasLeftError(UserError, KeyError):
    """A UAV was asked for that did not fly."""

    __str__ = Exception.__str__  # a KeyError shows its text in quotes


class Flew(dict[str, V]):
    """What a slot gave, by the UAVs that flew in it; tells who asks for another how to keep all of them."""

    def __missing__(self, uav: str) -> NoReturn:
        raise HasLeftError(
            f"{uav!r} did not fly in this slot: a UAV that is done leaves `agents`; LawnEnv(leaving=False) keeps all "
            "until the game is over"
        )


class LawnEnv(ParallelEnv):  # type: ignore[misc]
    """One game of N UAVs; each observes o_i, Eq. (12), eq:obs, and ``state()`` is x, Eq. (11), eq:global_state.

    ``infos[uav]`` holds ``position, destination, cell, cell_load, num_rbs, rate_mbps, ema_rate_mbps,
    corrected_rate_mbps, slot, min_slots, collided, arrived, timed_out, utility_mbps, reward_rate, reward_nav,
    reward_col, reward_term, action_mask``, numbers and arrays alone; positions are in voxels, the four rewards add up
    to the reward, and ``action_mask`` [A] says which actions the UAV has in the next slot: all, or once it is done only
    to hover.

    :param scenario: the constants of the game; the preset ``paper`` by default
    :param timeout: whether missing the deadline terminates a UAV, as Eq. (18), eq:terminal, has it, or truncates it
    :param render_mode: ``ansi`` for text, ``rgb_array`` for a picture, ``rgb_array_list`` for a list of those of every
        slot since the last ``render()`` or ``reset()``, ``human`` for a window that follows the game by itself (text
        where there is no window), or none
    :param leaving: whether a UAV that is done leaves ``agents``, as PettingZoo has it. Otherwise all stay until the
        game is over and end together; who is done gets rewards of 0, its actions do nothing, and its mask allows only
        to hover. The game is the same either way
    :raises UserError: if the render mode is unknown, or the scenario is none
    """

    metadata: ClassVar[dict[str, Any]] = {
        "name": "lawn_v0",
        "render_modes": list(get_args(RenderMode)),
        "render_fps": 4,
        "is_parallelizable": True,
    }

    def __init__(
        self,
        scenario: Scenario = PRESETS["paper"],
        timeout: Timeout = "terminal",
        render_mode: RenderMode | None = None,
        leaving: bool = True,
    ) -> None:
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise UserError(f"render_mode {render_mode!r}: one of {', '.join(self.metadata['render_modes'])}, or none")
        self.scenario = check_scenario(scenario)
        self.timeout = check_timeout(timeout)
        self.render_mode = render_mode
        self.leaving = leaving
        self.simulator = Simulator(scenario)
        self.observer = Observer(scenario)
        self.layout = self.observer.layout
        self.action_table = self.simulator.rules.actions
        """Displacement in voxels of each action [A, 3]."""
        hovers = (~self.action_table.any(axis=1)).astype(np.int8)
        self._masks = {True: np.ones_like(hovers), False: hovers}
        """Actions that a UAV has: while it flies, and once it is done."""
        self.possible_agents = [f"uav_{i}" for i in range(scenario.num_uavs)]
        self.agents: list[str] = []
        self._trail: list[NDArray[np.int64]] = []
        self._late = np.zeros(scenario.num_uavs, dtype=bool)
        self._started = False
        self._warned = False
        self._frames: list[NDArray[np.uint8]] = []
        self._window = Window(self.metadata["render_fps"])
        self.state_space = space_of(self.layout.state_dim)
        self.observation_spaces = {agent: space_of(self.layout.local_dim) for agent in self.possible_agents}
        self.action_spaces = {agent: spaces.Discrete(len(self.action_table)) for agent in self.possible_agents}

    def __getstate__(self) -> dict[str, Any]:
        """What a copy is made of: all but the window, of which it opens one of its own."""
        return vars(self) | {"_window": Window(self.metadata["render_fps"])}

    def observation_space(self, agent: str) -> spaces.Box:
        """Space of o_i, the same for all UAVs."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Discrete:
        """Space of the actions, indices into ``action_table``, the same for all UAVs."""
        return self.action_spaces[agent]

    def reset(self, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observations, Infos]:
        """Start a game.

        :param seed: seed of the missions; without one the stream goes on
        :param options: ``{"missions": (origins, destinations)}`` sets them by hand, each [N, 3] in voxels
        :return: observations and infos
        :raises UserError: if a mission given by hand cannot be flown
        """
        if options is not None and not isinstance(options, Mapping):
            raise UserError(f"options = {options!r}: a dictionary, such as {{'missions': (origins, destinations)}}")
        options = dict(options or {})
        missions = options.pop("missions", None)
        for key in options:
            warnings.warn(f"reset option {key!r} is unknown and ignored; known: 'missions'", stacklevel=2)
        if missions is not None:
            missions = _read_missions(missions)
        if seed is not None and not isinstance(seed, int | np.integer):
            raise UserError(f"seed = {seed!r}: a whole number from 0 up")
        self.simulator.reset(seed=seed, missions=missions)
        self.agents = list(self.possible_agents)
        self._trail = []
        self._late = np.zeros(len(self.agents), dtype=bool)
        self._started = True
        self._frames = []
        self._show()
        return self._observe(self.agents), self._first_infos()

    def step(
        self, actions: dict[str, int]
    ) -> tuple[Observations, dict[str, float], dict[str, bool], dict[str, bool], Infos]:
        """Play one slot.

        :param actions: one action per UAV in ``agents``
        :return: observations, rewards, terminations, truncations and infos of the UAVs that flew this slot
        :raises UserError: if an action is missing or does not exist, a UAV does not, or no game was started
        """
        if not self._started:
            raise not_started()
        if not isinstance(actions, Mapping):
            raise UserError(f"actions = {actions!r}: one for each UAV in the air, by its name")
        flew = self.agents  # nobody after the end, where SuperSuit's ``black_death`` asks once more
        missing = [agent for agent in flew if agent not in actions]
        if missing:
            raise UserError(f"no action for {', '.join(missing)}: every UAV in the air needs one")
        index = {agent: i for i, agent in enumerate(self.possible_agents)}
        if unknown := [agent for agent in actions if agent not in index]:
            raise UserError(f"action of {unknown[0]!r}: there are {', '.join(self.possible_agents)}")
        joint = np.zeros((1, len(index)), dtype=np.int64)
        for agent in flew:
            try:
                action = operator.index(actions[agent])
            except TypeError:
                raise UserError(f"action of {agent} = {actions[agent]!r}: a whole number") from None
            if not 0 <= action < len(self.action_table):
                raise UserError(f"action of {agent} = {actions[agent]!r}: from 0 to {len(self.action_table) - 1}")
            joint[0, index[agent]] = action
        if not (self.leaving or self._warned):
            self._warn_of_masked(joint[0])
        self._trail.append(self.simulator.state.position[0].copy())
        outcome = self.simulator.step(joint)
        self._late |= outcome.timed_out[0]
        done = ~self.simulator.state.flying[0]
        if not self.leaving:
            done &= done.all()
        total = outcome.reward_terms[0].sum(axis=-1).tolist()
        rewards = {agent: total[index[agent]] for agent in flew}
        truncated = done & self._late & (self.timeout == "truncated")
        terminations = {agent: bool(done[i] and not truncated[i]) for agent, i in index.items()}
        truncations = {agent: bool(truncated[i]) for agent, i in index.items()}
        self.agents = [agent for agent in flew if not done[index[agent]]]
        self._show()
        return (
            Flew(self._observe(flew)),
            Flew(rewards),
            Flew((agent, terminations[agent]) for agent in flew),
            Flew((agent, truncations[agent]) for agent in flew),
            Flew(self._infos(flew, outcome)),
        )

    def state(self) -> NDArray[np.float32]:
        """The global state x [state_dim]."""
        x: NDArray[np.float32] = self.observer.state(self.simulator.state)[0]
        return x

    def render(self) -> str | NDArray[np.uint8] | list[NDArray[np.uint8]] | None:
        """Draw the game from above.

        :return: text for ``ansi``, a picture [480, 480, 3] for ``rgb_array``, those since the last call or reset for
            ``rgb_array_list``; nothing for ``human``, which shows each slot by itself, and without a render mode
        """
        if self.render_mode == "ansi":
            return draw_text(self.scenario, self.simulator.state)
        if self.render_mode == "rgb_array":
            return self._picture()
        if self.render_mode == "rgb_array_list":
            frames, self._frames = self._frames, []
            return frames
        return None

    def close(self) -> None:
        """Close the window of ``human``."""
        self._window.close()

    def _picture(self) -> NDArray[np.uint8]:
        return draw_picture(self.scenario, self.simulator.state, trail=self._trail)

    def _show(self) -> None:
        """Show or keep a picture of the slot, in the modes that do so by themselves."""
        if self.render_mode == "human":
            self._window.show(self._picture, lambda: draw_text(self.scenario, self.simulator.state))
        elif self.render_mode == "rgb_array_list":
            self._frames.append(self._picture())

    def _warn_of_masked(self, joint: NDArray[np.int64]) -> None:
        """Say once that the actions of UAVs that are done do nothing, of which only hovering is in their masks."""
        masked = np.flatnonzero(~self.simulator.state.flying[0] & (np.take(self._masks[False], joint) == 0))
        if not len(masked):
            return
        i = masked[0]
        warnings.warn(
            f"{self.possible_agents[i]} is done, so its action {joint[i]} does nothing: the action_mask in its info "
            f"allows only {int(self._masks[False].argmax())}, to hover (said once)",
            stacklevel=3,
        )
        self._warned = True

    def _observe(self, agents: list[str]) -> Observations:
        local = self.observer.local(self.simulator.state)[0]
        there = set(agents)
        return {agent: own for agent, own in zip(self.possible_agents, local, strict=True) if agent in there}

    def _first_infos(self) -> Infos:
        """Infos before the first slot: association is known, nothing has been rated yet."""
        nothing: Any = map(np.zeros_like, self.simulator.outcome)
        infos = self._infos(self.agents, Outcome(*nothing))
        for info in infos.values():
            cell = int(self.simulator.rules.cell[tuple(info["position"])])
            load = int(self.simulator.state.cell_load[0, cell])
            info |= {
                "cell": cell,
                "cell_load": load,
                "num_rbs": rb_share(int(self.simulator.rules.num_rbs[cell]), load),
            }
        return infos

    def _infos(self, agents: list[str], outcome: Outcome) -> Infos:
        state, outcomes = self.simulator.state, outcome._asdict()
        terms = outcomes.pop("reward_terms")
        numbers = {
            "slot": state.slot,
            "min_slots": state.min_slots,
            "ema_rate_mbps": state.ema_rate_mbps,
            **outcomes,
            **{f"reward_{term}": terms[..., k] for k, term in enumerate(REWARD_TERMS)},
        }
        columns = [values[0].tolist() for values in numbers.values()]
        voxels = zip(state.position[0].copy(), state.destination[0].copy(), strict=True)
        masks = [self._masks[flies].copy() for flies in state.flying[0].tolist()]
        there = set(agents)
        return {
            agent: {
                "position": position,
                "destination": destination,
                **dict(zip(numbers, own, strict=True)),
                "action_mask": mask,
            }
            for agent, (position, destination), mask, *own in zip(
                self.possible_agents, voxels, masks, *columns, strict=True
            )
            if agent in there
        }


def _read_missions(given: Any) -> Missions:
    """Missions given by hand as a pair of arrays; what they hold is checked by the simulator."""
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise UserError(f"option 'missions' = {given!r}: expected a pair (origins, destinations)")
    return Missions(*given)
