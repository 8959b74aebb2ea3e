"""The ceilings of a tiny game, and what players make of all of its missions."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from lawn_sb3.game.player import Player
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning.ceiling import KNOWN, Ceiling, TinyGames, ceiling, joint_optimum_mbps
from lawn_sb3.scenario import Scenario


class Ceilings(NamedTuple):
    """Mean utilities of a UAV over all missions, in Mbps."""

    ceilings: dict[str, Ceiling]
    """By what a UAV knows of the other."""
    joint_optimum_mbps: float
    """Of the best joint flight of every mission."""


def ceilings(games: TinyGames, on_rung: Callable[[str], None]) -> Ceilings:
    """Work out the ceiling of everything that a UAV may know.

    :param games: all missions and flights
    :param on_rung: told what is worked out next
    :return: the ceilings
    """
    found: dict[str, Ceiling] = {}
    for name, known in KNOWN.items():
        on_rung(name)
        found[name] = ceiling(games, known)
    return Ceilings(found, joint_optimum_mbps(games))


class Earned(NamedTuple):
    """What a player earns on all missions, each flown once."""

    utility_mbps: float
    """Mean utility of a UAV."""
    late_percent: float
    """UAVs that took longer than T_i^min: only where there are none do the ceilings hold."""


def earned(player: Player, scenario: Scenario, games: TinyGames, seed: int = 0) -> Earned:
    """Let a player fly all missions, each once.

    :param player: the player
    :param scenario: the game
    :param games: its missions
    :param seed: seed of the player's own randomness
    :return: its mean utility, and how many of its UAVs were late
    """
    missions = games.missions()
    simulator = Simulator(scenario, len(missions.origins), seed=0, continuation="episode")
    simulator.reset(missions=missions)
    player.start(simulator, np.random.default_rng(seed))
    gained = 0.0
    while simulator.state.flying.any():
        gained += float(simulator.step(player.act(simulator)).utility_mbps.sum())
    state = simulator.state
    return Earned(gained / state.flying.size, float(100.0 * (state.slot > state.min_slots).mean()))
