"""The plain game as a PettingZoo environment, for :mod:`lawn_sb3.experiment.benchmark` to be held against."""

from typing import Any

import numpy as np
from pettingzoo import ParallelEnv

from tests.game.reference import ReferenceGame

STEPS = range(-3, 4)


class PlainLawnEnv(ParallelEnv):  # type: ignore[misc]
    """One game of N UAVs; each observes o_i of Eq. (12), and its reward is Eq. (14)."""

    def __init__(self, scenario: Any) -> None:
        self.scenario = scenario
        self.possible_agents = [f"uav_{i}" for i in range(scenario.num_uavs)]
        self.agents: list[str] = []
        reach = scenario.max_voxel_steps
        self.moves = [(x, y, z) for x in STEPS for y in STEPS for z in STEPS if abs(x) + abs(y) + abs(z) <= reach]

    def reset(self, seed: int | None = None, options: Any = None) -> Any:
        """Start a game with random missions."""
        rng, n = np.random.default_rng(seed), self.scenario.num_uavs
        grid = self.scenario.grid
        places = [tuple(np.unravel_index(k, grid)) for k in rng.choice(np.prod(grid), 2 * n, replace=False)]
        voxels = [(int(x), int(y), int(z)) for x, y, z in places]
        self.game = ReferenceGame(self.scenario, list(zip(voxels[:n], voxels[n:], strict=True)))
        self.agents = list(self.possible_agents)
        return self.observe(), {agent: {} for agent in self.agents}

    def observe(self) -> dict[str, list[float]]:
        """o_i of all UAVs in the air."""
        loads = self.game.loads()
        cells = [number for load, site in zip(loads, self.game.sites, strict=True) for number in (load, *site)]
        uavs = zip(self.possible_agents, self.game.uavs, strict=True)
        return {
            agent: [*uav.position, *uav.destination, uav.min_slots, uav.ema_rate_mbps, *cells]
            for agent, uav in uavs
            if agent in self.agents
        }

    def step(self, actions: dict[str, int]) -> Any:
        """Play one slot."""
        flew = self.agents
        slots = self.game.play([self.moves[actions.get(agent, 0)] for agent in self.possible_agents])
        gave = dict(zip(self.possible_agents, slots, strict=True))
        observations = self.observe()
        self.agents = [agent for agent in flew if not gave[agent].arrived and not gave[agent].timed_out]
        over = {agent: agent not in self.agents for agent in flew}
        rewards = {agent: sum(gave[agent].reward_terms) for agent in flew}
        return observations, rewards, over, dict.fromkeys(flew, False), {agent: gave[agent]._asdict() for agent in flew}
