"""Games so small that every flight of a UAV can be tried, and the trial itself: all of them, in the real simulator."""

from typing import Any, NamedTuple

import numpy as np
from hypothesis import strategies as st

from lawn_sb3.game import Missions, Simulator
from lawn_sb3.game.simulator import Snapshot
from lawn_sb3.game.state import Rules, State
from lawn_sb3.planning.plan import Plan
from lawn_sb3.planning.routes import straight_routes
from lawn_sb3.scenario import Scenario
from tests.game.random_play import SEEDS, random_actions, scenarios

GRIDS = [(4, 1, 1), (2, 2, 1), (3, 2, 1), (2, 2, 2), (3, 2, 2)]
HORIZONS = [(1, 2), (1, 3), (1, 4), (1, 5), (2, 2), (2, 3)]
"""v_max and T_max: at most 7^5 = 16,807 or 25^3 = 15,625 sequences of actions."""
ANY_SLACK = 1_000
"""More than any T_max of a tiny game: every flight that meets the deadline is allowed."""


class Situation(NamedTuple):
    """One game at some slot, how all UAVs go on from there, and one of them that may do otherwise."""

    simulator: Simulator
    plan: Plan
    uav: int
    slack: int

    @property
    def rules(self) -> Rules:
        return self.simulator.rules

    @property
    def state(self) -> State:
        return self.simulator.state


class Flown(NamedTuple):
    """What the simulator makes of some flights, slots counted from where they began."""

    voxels: np.ndarray  # [S + 1, G, N, 3]
    in_air: np.ndarray  # [S, G, N] who was flying in each slot
    utilities_mbps: np.ndarray  # [G, N] as paid
    collisions: np.ndarray  # [G, N] by slot and pair
    marked: np.ndarray  # [G, N] slots in which the simulator itself says that the UAV has collided
    arrived: np.ndarray  # [G, N]

    @property
    def slots(self) -> np.ndarray:  # [G, N] until the UAV was done
        return np.asarray(self.in_air.sum(axis=0))

    @property
    def welfare_mbps(self) -> np.ndarray:  # [G]
        return np.asarray(self.utilities_mbps.sum(axis=1))


@st.composite
def tiny_scenarios(draw: st.DrawFn, /, **fixed: Any) -> Scenario:
    """Scenarios of two or three UAVs and two or three GBSs in up to 3 x 2 x 2 voxels, with all readings."""
    width, length, layers = draw(st.sampled_from(GRIDS))
    max_voxel_steps, max_slots = draw(st.sampled_from(HORIZONS))
    across, heights = st.integers(-1, 9).map(lambda k: 5.0 * k), st.integers(0, 2).map(lambda k: 10.0 * k)
    sites = draw(st.lists(st.tuples(across, across, heights), min_size=2, max_size=3))
    values = {
        "num_uavs": draw(st.integers(2, min(3, width * length * layers // 2))),
        "width_voxels": width,
        "length_voxels": length,
        "voxel_size_m": 10.0,
        "min_altitude_m": 0.0,
        "max_altitude_m": 10.0 * layers,
        "max_voxel_steps": max_voxel_steps,
        "max_slots": max_slots,
        "gbs_positions_m": sites,
        "rbs_per_gbs": draw(st.lists(st.integers(1, 12), min_size=len(sites), max_size=len(sites))),
    }
    return draw(scenarios(**{**values, **fixed}))


@st.composite
def begun_games(draw: st.DrawFn, /, of: st.SearchStrategy[Scenario]) -> Simulator:
    """One game at its start, or after some slots of random play: clocks differ then, and UAVs may be done."""
    scenario, seed = draw(of), draw(SEEDS)
    rng = np.random.default_rng(seed)
    simulator = Simulator(scenario, 1, seed, draw(st.sampled_from(["mission", "episode"])))
    if draw(st.booleans()):  # drawn missions never share a destination
        simulator.reset(missions=_crossing_missions(scenario, rng))
    for _ in range(draw(st.integers(0, 3))):
        simulator.step(random_actions(simulator, rng))
        simulator.go_on()
    return simulator


def _crossing_missions(scenario: Scenario, rng: np.random.Generator) -> Missions:
    """Distinct origins, and destinations anywhere else."""
    cells = np.array(list(np.ndindex(*scenario.grid)))
    origins = rng.permutation(len(cells))[: scenario.num_uavs]
    away = rng.integers(1, len(cells), scenario.num_uavs)
    return Missions(cells[origins], cells[(origins + away) % len(cells)])


@st.composite
def situations(draw: st.DrawFn, /, **fixed: Any) -> Situation:
    """A tiny game, its UAVs flying at random or, where that is possible, straight; and one of those that fly."""
    simulator, slack = draw(begun_games(tiny_scenarios(**fixed))), draw(st.sampled_from([0, 1, ANY_SLACK]))
    rng = np.random.default_rng(draw(SEEDS))
    if draw(st.booleans()) and all_can_arrive(simulator):
        plan = straight_routes(simulator.rules, simulator.state, 0, slack, rng)
    else:
        plan = random_flights(simulator, rng)
    uav = draw(st.sampled_from(np.flatnonzero(simulator.state.flying[0]).tolist()))
    return Situation(simulator, plan, uav, slack)


def all_can_arrive(simulator: Simulator) -> bool:
    state, rules = simulator.state, simulator.rules
    steps = np.abs(state.destination - state.position).sum(axis=-1)
    return bool((steps <= rules.max_voxel_steps * (rules.max_slots - state.slot))[state.flying].all())


def among(simulator: Simulator, plan: Plan, uavs: list[int]) -> tuple[Simulator, Plan]:
    fewer = Simulator(simulator.scenario.changed(num_uavs=len(uavs)), 1, seed=0)
    state, random_state = simulator.snapshot()
    kept = State._make([*(array[:, uavs] for array in state[:-2]), state.cell_load, state.past_load])
    fewer.restore(Snapshot(kept, random_state))
    return fewer, Plan(plan.voxels[uavs], plan.slots[uavs])


def random_flights(simulator: Simulator, rng: np.random.Generator) -> Plan:
    """Where uniformly random actions take all UAVs until all are done, some of them at their destinations."""
    slots = int((simulator.rules.max_slots - simulator.state.slot)[simulator.state.flying].max())
    flown = fly(simulator, rng.integers(simulator.num_actions, size=(slots, 1, simulator.scenario.num_uavs)))
    return Plan(np.ascontiguousarray(flown.voxels[:, 0].swapaxes(0, 1)), flown.slots[0])


def actions_of(rules: Rules, plan: Plan) -> np.ndarray:
    """Indices of the moves that a plan consists of, as anybody may read them off the action table [S, N]."""
    index = {tuple(move): a for a, move in enumerate(rules.actions.tolist())}
    moves = np.diff(plan.voxels, axis=1).swapaxes(0, 1)  # [S, N, 3]
    return np.array([[index[tuple(move)] for move in slot] for slot in moves.tolist()], dtype=np.int64)


def fly(simulator: Simulator, actions: np.ndarray) -> Flown:
    """Play actions [S, G, N] from where one game stands, in G copies of it side by side."""
    num_games, num_uavs = actions.shape[1:]
    games = Simulator(simulator.scenario, num_games, seed=0)
    state, random_state = simulator.snapshot()
    games.restore(Snapshot(State._make(np.repeat(array, num_games, axis=0) for array in state), random_state))
    voxels, in_air = [games.state.position.copy()], []
    utilities_mbps, collisions = np.zeros((num_games, num_uavs)), np.zeros((num_games, num_uavs), dtype=np.int64)
    marked, arrived = np.zeros_like(collisions), np.zeros(collisions.shape, dtype=np.bool_)
    for slot in actions:
        in_air.append(games.state.flying.copy())
        outcome = games.step(slot)
        voxels.append(games.state.position.copy())
        utilities_mbps += outcome.utility_mbps
        collisions += count_collisions(voxels[-1], in_air[-1], games.rules.arrived_stays)
        marked += outcome.collided
        arrived |= outcome.arrived
    return Flown(np.array(voxels), np.array(in_air), utilities_mbps, collisions, marked, arrived)


def fly_plan(simulator: Simulator, plan: Plan) -> Flown:
    return fly(simulator, actions_of(simulator.rules, plan)[:, None])


def count_collisions(voxels: np.ndarray, in_air: np.ndarray, arrived_stays: bool) -> np.ndarray:
    """How many others each UAV shares its voxel with in one slot [G, N], of each pair at least one in the air."""
    shared = (voxels[:, :, None] == voxels[:, None]).all(axis=-1)  # [G, N, N]
    both, either = in_air[:, :, None] & in_air[:, None], in_air[:, :, None] | in_air[:, None]
    pairs = shared & (either if arrived_stays else both)
    return np.asarray(pairs.sum(axis=-1) - np.diagonal(pairs, axis1=1, axis2=2))


def every_flight(simulator: Simulator, plan: Plan, uav: int) -> Flown:
    """Fly every sequence of actions that one UAV has until its deadline, all others flying as planned."""
    left = int(simulator.rules.max_slots - simulator.state.slot[0, uav])
    sequences = np.indices((simulator.num_actions,) * left).reshape(left, -1)  # [left, G]
    planned = actions_of(simulator.rules, plan)
    actions = np.zeros((max(left, len(planned)), sequences.shape[1], planned.shape[1]), dtype=np.int64)
    actions[: len(planned)] = planned[:, None]
    actions[:, :, uav] = 0
    actions[:left, :, uav] = sequences
    return fly(simulator, actions)


def best_of_all(situation: Situation, for_welfare: bool) -> tuple[int, float] | None:
    """Fewest collisions and, with those, the highest utility or welfare in Mbps of any flight that arrives in time."""
    simulator, plan, uav, slack = situation
    flown = every_flight(simulator, plan, uav)
    arrived, slots, collisions = flown.arrived[:, uav], flown.slots[:, uav], flown.collisions[:, uav]
    if not arrived.any():
        return None
    wanted = simulator.state.min_slots[0, uav] + slack - simulator.state.slot[0, uav]
    allowed = arrived & (slots <= max(wanted, slots[arrived].min()))
    fewest = collisions[allowed].min()
    worths_mbps = flown.welfare_mbps if for_welfare else flown.utilities_mbps[:, uav]
    return int(fewest), float(worths_mbps[allowed & (collisions == fewest)].max())
