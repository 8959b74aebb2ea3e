"""The ceiling: the most that two UAVs of a tiny game can have in time, by what each knows when it decides.

In an airspace where every mission takes one or two slots, a UAV that flies no longer than T_i^min decides once: through
which voxel it flies. This is a team decision of two who see different things. Joint probabilities of the two decisions
in which each UAV's choice depends on what it sees alone solve a set of linear conditions. All decentralised policies in
time satisfy them, random and correlated ones too, so none has more than the largest welfare under them; a policy that
lets a UAV arrive later can. Policies found by best responses from there show how tight the ceiling is.
"""

from collections.abc import Callable
from itertools import permutations, product
from math import perm
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.errors import UserError
from lawn_sb3.game.airspace import Missions
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.scenario import Scenario

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

MOST_FLIGHTS = 1_000_000
"""The most joint flights that are worked out."""
BATCH = 50_000
MOST_ROUNDS = 200


class TinyGames(NamedTuple):
    """All missions of two UAVs, and all of their joint flights in time.

    :param origin: voxel of each UAV's origin [K, 2]
    :param destination: voxel of each UAV's destination [K, 2]
    :param cell: the cell of each voxel [V]
    :param voxels: their coordinates [V, 3]
    :param mission: of each joint flight, its mission [R]
    :param through: of each joint flight, the voxel at the end of each UAV's first slot [R, 2]
    :param utility_mbps: of each joint flight, the mean utility of its two UAVs [R]
    """

    origin: Ints
    destination: Ints
    cell: Ints
    voxels: Ints
    mission: Ints
    through: Ints
    utility_mbps: Floats

    def missions(self) -> Missions:
        """Origins and destinations of all missions, each once, in voxels [K, 2, 3]."""
        return Missions(self.voxels[self.origin], self.voxels[self.destination])


class Ceiling(NamedTuple):
    """What UAVs with some knowledge can have: the mean utility of a UAV over all missions.

    :param at_most_mbps: no decentralised policy in time has more
    :param found_mbps: what one that was found has
    """

    at_most_mbps: float
    found_mbps: float


KNOWN: dict[str, Callable[[TinyGames], list[Ints]]] = {
    "nothing of the other": lambda games: [],
    "loads": lambda games: [games.cell[games.origin]],
    "the cell it heads for": lambda games: [games.cell[games.origin], games.cell[games.destination]],
    "its intents": lambda games: [games.origin, games.destination],
}
"""What a UAV knows of the other when it decides, besides its own mission, by the other [K, 2] each. With two UAVs, the
loads without oneself say the cell of the other; a clock or a memory adds nothing in the first slot."""


def tiny_games(scenario: Scenario) -> TinyGames:
    """All missions of a tiny game, and the welfare of all joint flights in time, played by the simulator.

    :param scenario: the game
    :return: the missions and the flights
    :raises UserError: if there are not two UAVs, if a mission takes more than two slots, or if flights are too many
    """
    if scenario.num_uavs != 2:
        raise UserError(f"num_uavs = {scenario.num_uavs}: the ceiling is worked out for 2 UAVs")
    farthest, steps = sum(size - 1 for size in scenario.grid), scenario.max_voxel_steps
    if farthest > 2 * steps or scenario.max_slots < 2:
        allowed = min(2, scenario.max_slots) * steps
        raise UserError(f"the grid {scenario.grid} has missions of {farthest} voxel steps: at most {allowed}")
    if (least := perm(scenario.num_voxels, 4)) > MOST_FLIGHTS:  # a mission has one joint flight or more
        raise _too_many(least)
    voxels = np.array(list(product(*(range(size) for size in scenario.grid))))
    apart = np.abs(voxels[:, None] - voxels).sum(axis=-1)
    through = [[_through(apart, start, end, steps) for end in range(len(voxels))] for start in range(len(voxels))]
    missions, mission, via = _missions_and_flights(len(voxels), through)
    simulator = Simulator(scenario)
    x, y, z = voxels.T
    games = TinyGames(
        missions[:, :2], missions[:, 2:], simulator.rules.cell[x, y, z], voxels, mission, via, np.zeros(len(mission))
    )
    for start in range(0, len(mission), BATCH):
        chosen = slice(start, start + BATCH)
        games.utility_mbps[chosen] = _fly(scenario, games, chosen)
    return games


def _too_many(flights: int) -> UserError:
    return UserError(f"the game has {flights:,} joint flights or more: at most {MOST_FLIGHTS:,} can be worked out")


def _through(apart: Ints, start: int, end: int, steps: int) -> Ints:
    """Voxels at which a flight in time may end its first slot: its end, if one slot is enough."""
    if apart[start, end] <= steps:
        return np.array([end])
    return np.flatnonzero((apart[start] <= steps) & (apart[end] <= steps))


def _missions_and_flights(num_voxels: int, through: list[list[Ints]]) -> tuple[Ints, Ints, Ints]:
    """Missions [K, 4], and the mission [R] and the voxels [R, 2] of each joint flight."""
    ways = np.array([[len(way) for way in row] for row in through])
    missions = np.array(list(permutations(range(num_voxels), 4)), dtype=np.int64).reshape(-1, 4)
    flights = int((ways[missions[:, 0], missions[:, 2]] * ways[missions[:, 1], missions[:, 3]]).sum())
    if flights > MOST_FLIGHTS:
        raise _too_many(flights)
    mission, via = [], []
    for k, (one, other, end, other_end) in enumerate(missions):
        pairs = list(product(through[one][end], through[other][other_end]))
        mission += [k] * len(pairs)
        via += pairs
    return missions, np.array(mission, dtype=np.int64), np.array(via, dtype=np.int64).reshape(-1, 2)


def _fly(scenario: Scenario, games: TinyGames, chosen: slice) -> Floats:
    """Mean utilities of some joint flights [R]."""
    mission, via = games.mission[chosen], games.through[chosen]
    start, end = games.origin[mission], games.destination[mission]
    simulator = Simulator(scenario, len(mission), seed=0)
    simulator.reset(missions=Missions(games.voxels[start], games.voxels[end]))
    actions, reach = simulator.rules.actions, scenario.max_voxel_steps
    index = np.zeros((2 * reach + 1,) * 3, dtype=np.int64)
    index[tuple((actions + reach).T)] = np.arange(len(actions))
    utility = np.zeros(len(mission))
    for here, there in ((start, via), (via, end)):
        moves = games.voxels[there] - games.voxels[here] + reach
        utility += simulator.step(index[tuple(np.moveaxis(moves, -1, 0))]).utility_mbps.mean(axis=1)
    return utility


def joint_optimum_mbps(games: TinyGames) -> float:
    """Mean utility over the missions in Mbps if each is flown by the joint flight with the highest welfare."""
    best = np.full(len(games.origin), -np.inf)
    np.maximum.at(best, games.mission, games.utility_mbps)
    return float(best.mean())


def ceiling(games: TinyGames, known: Callable[[TinyGames], list[Ints]]) -> Ceiling:
    """The most that UAVs can have with some knowledge of each other.

    :param games: all missions and flights
    :param known: what a UAV knows, one of :data:`KNOWN`
    :return: what nobody exceeds, and what was found
    """
    of_other = [values[:, ::-1] for values in known(games)]
    seen = np.stack([games.origin, games.destination, *of_other], axis=-1)  # [K, 2, anything]
    _, observation = np.unique(seen.reshape(-1, seen.shape[-1]), axis=0, return_inverse=True)
    observed = observation.reshape(-1, 2)[games.mission]  # [R, 2]
    # A choice is a voxel to fly through after an observation; each UAV has policies of its own.
    keys = np.stack([np.arange(2) + np.zeros_like(observed), observed, games.through], axis=-1).reshape(-1, 3)
    choices, choice = np.unique(keys, axis=0, return_inverse=True)
    choice = choice.reshape(-1, 2)
    _, decision = np.unique(choices[:, :2], axis=0, return_inverse=True)
    bound, likely = _largest(games, choice, decision)
    return Ceiling(bound, _respond(games, choice, decision, likely))


def _largest(games: TinyGames, choice: Ints, decision: Ints) -> tuple[float, Floats]:
    """The largest welfare under conditions that all decentralised policies satisfy, and how likely choices are there.

    What is returned is not the solver's optimum but the value of its dual solution, which bounds it whatever the
    solver's tolerance: all unknowns are probabilities, so a positive reduced profit adds no more than itself.

    :param choice: the two UAVs' choices in each joint flight [R, 2]
    :param decision: the decision that each choice belongs to [C]
    :return: mean utility, and probabilities [C]
    """
    from scipy.optimize import linprog  # here, as a game that is not tiny is refused before
    from scipy.sparse import csr_array, vstack

    flights, count = len(choice), len(decision)
    joint = np.arange(flights)
    profit = np.concatenate([np.zeros(count), games.utility_mbps / len(games.origin)])
    shape = int(decision.max()) + 1, count + flights
    conditions = [csr_array((np.ones(count), (decision, np.arange(count))), shape=shape)]
    for uav in range(2):  # of a mission, joint flights with this choice are as likely as the choice
        pairs = np.stack([games.mission, choice[:, uav]], axis=-1)
        unique, row = np.unique(pairs, axis=0, return_inverse=True)
        shape = len(unique), count + flights
        sums = csr_array((np.ones(flights), (row.ravel(), count + joint)), shape=shape)
        conditions.append(sums - csr_array((np.ones(len(unique)), (np.arange(len(unique)), unique[:, 1])), shape=shape))
    equal: Any = vstack(conditions).tocsr()  # the stubs of linprog know no sparse matrices
    to = np.zeros(equal.shape[0])
    to[: conditions[0].shape[0]] = 1.0
    solution: Any = linprog(-profit, A_eq=equal, b_eq=to, bounds=(0, None), method="highs-ipm")
    if solution.status != 0:
        raise RuntimeError(f"the linear program of the ceiling was not solved: {solution.message}")
    price = -solution.eqlin.marginals
    bound = float(to @ price + np.maximum(profit - equal.T @ price, 0.0).sum())
    return bound, solution.x[:count]


def _respond(games: TinyGames, choice: Ints, decision: Ints, likely: Floats) -> float:
    """Best responses in turn, starting from the likeliest choices, until nobody gains: the mean utility found."""
    chosen = _best_choices(likely, decision)
    found = -np.inf
    for _ in range(MOST_ROUNDS):
        before = found
        for uav in range(2):
            profit = games.utility_mbps * chosen[choice[:, 1 - uav]]
            worth: Floats = np.bincount(choice[:, uav], profit, minlength=len(decision)).astype(np.float64)
            mine = np.isin(np.arange(len(decision)), choice[:, uav])
            chosen = np.where(mine, _best_choices(worth, decision), chosen)
        found = float((games.utility_mbps * chosen[choice].all(axis=1)).sum() / len(games.origin))
        if found <= before:
            break
    return found


def _best_choices(worth: Floats, decision: Ints) -> NDArray[np.bool_]:
    """True for one choice of each decision [C]: one with the highest worth."""
    order = np.lexsort((-worth, decision))
    first = np.diff(decision[order], prepend=-1) > 0
    best = np.zeros(len(worth), dtype=bool)
    best[order[first]] = True
    return best
