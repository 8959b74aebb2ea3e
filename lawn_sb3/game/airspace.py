"""The airspace: voxels, the action set, moves, missions and the least time they take (Section II-B)."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.errors import UserError
from lawn_sb3.game.compiled import njit
from lawn_sb3.scenario import Scenario

Ints = NDArray[np.int64]
Voxel = tuple[int, int, int]


class Missions(NamedTuple):
    """Origins and destinations of all UAVs of some games, each in voxels [G, N, 3]."""

    origins: Ints
    destinations: Ints


def action_table(max_voxel_steps: int) -> Ints:
    """The action set, Eq. (13), eq:action_space: every displacement of L1 norm up to v_max.

    A_i = {a in Z^3 : ||a||_1 <= v_max}

    :param max_voxel_steps: v_max in voxels per slot
    :return: displacements in voxels [A, 3], sorted by L1 norm, so that action 0 hovers

    >>> len(action_table(3)), action_table(1).tolist()
    (63, [[0, 0, 0], [-1, 0, 0], [0, -1, 0], [0, 0, -1], [0, 0, 1], [0, 1, 0], [1, 0, 0]])
    """
    span = range(-max_voxel_steps, max_voxel_steps + 1)
    moves = [(x, y, z) for x in span for y in span for z in span if abs(x) + abs(y) + abs(z) <= max_voxel_steps]
    moves.sort(key=lambda a: (sum(map(abs, a)), a))
    return np.array(moves, dtype=np.int64)


@njit
def is_inside(voxel: Voxel, grid: Voxel) -> bool:
    """Whether a voxel belongs to the airspace V of ``grid`` = (W, L, H) voxels."""
    x, y, z = voxel
    return 0 <= x < grid[0] and 0 <= y < grid[1] and 0 <= z < grid[2]


@njit
def move(voxel: Voxel, displacement: Voxel, grid: Voxel, clip: bool) -> Voxel:
    """One move, Eq. (3), eq:mobility, under its constraint q_i(t+1) in V.

    q_i(t+1) = q_i(t) + a_i(t)

    :param voxel: q_i(t)
    :param displacement: a_i(t) in voxels
    :param grid: size of the airspace (W, L, H) in voxels
    :param clip: a move out of the airspace is clipped by coordinate; otherwise the UAV hovers
    :return: q_i(t+1)

    >>> move((1, 2, 0), (1, -1, 1), (10, 10, 3), True), move((9, 2, 0), (2, 1, 0), (10, 10, 3), True)
    ((2, 1, 1), (9, 3, 0))
    """
    x, y, z = voxel[0] + displacement[0], voxel[1] + displacement[1], voxel[2] + displacement[2]
    if clip:
        return min(max(x, 0), grid[0] - 1), min(max(y, 0), grid[1] - 1), min(max(z, 0), grid[2] - 1)
    if is_inside((x, y, z), grid):
        return x, y, z
    return voxel


def moves_inside(positions: Ints, actions: Ints, grid: Voxel) -> NDArray[np.bool_]:
    """Which moves keep the constraint q_i(t+1) in V by themselves, neither clipped nor refused.

    :param positions: q_i(t) in voxels [..., 3]
    :param actions: the action set in voxels [A, 3]
    :param grid: size of the airspace (W, L, H) in voxels
    :return: true for a move that ends inside [..., A]; hovering always does
    """
    ends = positions[..., None, :] + actions
    return np.asarray(((ends >= 0) & (ends < np.array(grid))).all(axis=-1))


def moves_in_time(
    positions: Ints, destinations: Ints, slots_left: Ints, actions: Ints, grid: Voxel, max_voxel_steps: int
) -> NDArray[np.bool_]:
    """In-time moves: those inside the airspace after which the destination can still be reached in the slots left.

    If there are none, as after a late start, all moves inside that come as near as possible are allowed. A UAV that
    keeps to them from its origin therefore arrives in time, whatever the others do: success is 100 % by construction.

    :param positions: q_i(t) in voxels [..., 3]
    :param destinations: d_i in voxels [..., 3]
    :param slots_left: slots until the UAV has to be there, that of this move included [...]
    :param actions: the action set in voxels [A, 3]
    :param grid: size of the airspace (W, L, H) in voxels
    :param max_voxel_steps: v_max
    :return: true for such a move [..., A]; at least one always is
    """
    shape = positions.shape[:-1]
    here, goal = (np.ascontiguousarray(voxels, dtype=np.int64).reshape(-1, 3) for voxels in (positions, destinations))
    left = np.ascontiguousarray(np.broadcast_to(slots_left, shape), dtype=np.int64).ravel()
    return _moves_in_time(here, goal, left, actions, grid, max_voxel_steps).reshape(*shape, len(actions))


@njit
def _moves_in_time(
    positions: Ints, destinations: Ints, slots_left: Ints, actions: Ints, grid: Voxel, max_voxel_steps: int
) -> NDArray[np.bool_]:
    allowed = np.zeros((len(positions), len(actions)), dtype=np.bool_)
    needed = np.empty(len(actions), dtype=np.int64)
    for k in range(len(positions)):
        goal = destinations[k, 0], destinations[k, 1], destinations[k, 2]
        enough = slots_left[k] - 1
        least = -1
        for a in range(len(actions)):
            end = positions[k, 0] + actions[a, 0], positions[k, 1] + actions[a, 1], positions[k, 2] + actions[a, 2]
            needed[a] = min_slots(end, goal, max_voxel_steps) if is_inside(end, grid) else -1
            if needed[a] >= 0 and (least < 0 or needed[a] < least):
                least = needed[a]
        for a in range(len(actions)):
            allowed[k, a] = 0 <= needed[a] <= max(enough, least)
    return allowed


@njit
def stop_at(voxel: Voxel, target: Voxel, destination: Voxel) -> Voxel:
    """Where a UAV ends a slot that may end early at its destination (reading ``arrival: fly-through``).

    The way from voxel to voxel is flown along x, then y, then z.

    :param voxel: q_i(t)
    :param target: where the move leads
    :param destination: d_i
    :return: the destination if it lies on the way, else the target
    """
    x, y, z = destination
    on_x = y == voxel[1] and z == voxel[2] and min(voxel[0], target[0]) <= x <= max(voxel[0], target[0])
    on_y = x == target[0] and z == voxel[2] and min(voxel[1], target[1]) <= y <= max(voxel[1], target[1])
    on_z = x == target[0] and y == target[1] and min(voxel[2], target[2]) <= z <= max(voxel[2], target[2])
    return destination if on_x or on_y or on_z else target


@njit
def min_slots(origin: Voxel, destination: Voxel, max_voxel_steps: int) -> int:
    """Least flight time, Eq. (8), eq:tmin.

    T_i^min = ceil(||q_i^0 - d_i||_1 / v_max)

    :param origin: q_i^0
    :param destination: d_i
    :param max_voxel_steps: v_max in voxels per slot
    :return: T_i^min in slots

    >>> min_slots((0, 0, 0), (3, 3, 1), 3)  # ceil(7 / 3)
    3
    """
    steps = abs(origin[0] - destination[0]) + abs(origin[1] - destination[1]) + abs(origin[2] - destination[2])
    return (steps + max_voxel_steps - 1) // max_voxel_steps


@njit
def distance(voxel: Voxel, other: Voxel) -> float:
    """Euclidean distance of two voxels, as in Eq. (16), eq:reward_nav; in voxels."""
    x, y, z = voxel[0] - other[0], voxel[1] - other[1], voxel[2] - other[2]
    return float(np.sqrt(x * x + y * y + z * z))


@njit
def _draw_voxel(
    rng: np.random.Generator, grid: Voxel, positions: Ints, destinations: Ints, flying: NDArray[np.bool_]
) -> Voxel:
    """A voxel drawn uniformly from those that no flying UAV of the game is in or heads for."""
    while True:
        x, y, z = int(rng.integers(0, grid[0])), int(rng.integers(0, grid[1])), int(rng.integers(0, grid[2]))
        free = True
        for j in range(len(flying)):
            if flying[j]:
                here = positions[j, 0] == x and positions[j, 1] == y and positions[j, 2] == z
                there = destinations[j, 0] == x and destinations[j, 1] == y and destinations[j, 2] == z
                free = free and not here and not there
        if free:
            return x, y, z


@njit
def draw_mission(
    rng: np.random.Generator, grid: Voxel, positions: Ints, destinations: Ints, flying: NDArray[np.bool_], uav: int
) -> None:
    """Give one UAV an origin and a destination that overlap with nobody's, and let it fly.

    :param rng: source of randomness
    :param grid: size of the airspace (W, L, H) in voxels
    :param positions: where the UAVs of this game are [N, 3]; written for this UAV
    :param destinations: where they are going [N, 3]; written for this UAV
    :param flying: who is in the air [N]; written for this UAV
    :param uav: its index
    """
    flying[uav] = False
    origin = _draw_voxel(rng, grid, positions, destinations, flying)
    for k in range(3):
        positions[uav, k] = destinations[uav, k] = origin[k]
    flying[uav] = True
    destination = _draw_voxel(rng, grid, positions, destinations, flying)
    for k in range(3):
        destinations[uav, k] = destination[k]


@njit
def _draw_games(rng: np.random.Generator, grid: Voxel, origins: Ints, destinations: Ints) -> None:
    for g in range(origins.shape[0]):
        flying = np.zeros(origins.shape[1], dtype=np.bool_)
        for i in range(origins.shape[1]):
            draw_mission(rng, grid, origins[g], destinations[g], flying, i)


def draw_missions(scenario: Scenario, num_games: int, rng: np.random.Generator) -> Missions:
    """Random missions: all origins and destinations of a game are distinct voxels.

    :param scenario: the scenario
    :param num_games: number of games G
    :param rng: source of randomness
    :return: origins and destinations
    """
    shape = (num_games, scenario.num_uavs, 3)
    missions = Missions(np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=np.int64))
    _draw_games(rng, scenario.grid, *missions)
    return missions


def check_missions(scenario: Scenario, missions: Missions, num_games: int) -> Missions:
    """Validate missions given by hand.

    :param scenario: the scenario
    :param missions: origins and destinations in voxels, each [G, N, 3] or, for all games alike, [N, 3]
    :param num_games: number of games G
    :return: the missions as arrays [G, N, 3]
    :raises UserError: naming the UAV whose mission cannot be flown
    """
    shape = (num_games, scenario.num_uavs, 3)
    arrays = []
    if len(missions) != len(Missions._fields):
        raise UserError(f"missions hold {len(missions)} items, expected a pair (origins, destinations)")
    for what, given in zip(Missions._fields, missions, strict=True):
        try:
            array = np.asarray(given)
        except ValueError:
            raise UserError(f"{what} have rows of unequal length, expected voxels {shape} or {shape[1:]}") from None
        if array.ndim not in (2, 3) or array.shape[-2:] != shape[-2:] or array.shape[:-2] not in ((), shape[:1]):
            raise UserError(f"{what} have shape {array.shape}, expected {shape} (games, UAVs, 3) or {shape[1:]}")
        if not np.issubdtype(array.dtype, np.integer):
            raise UserError(f"{what} must be whole voxel coordinates, not {array.dtype}")
        array = np.broadcast_to(array, shape).astype(np.int64)
        outside = np.argwhere(((array < 0) | (array >= np.array(scenario.grid))).any(axis=-1))
        if len(outside):
            g, i = outside[0]
            raise UserError(
                f"{what} of UAV {i} in game {g} {array[g, i].tolist()} lies outside the grid {scenario.grid}"
            )
        arrays.append(array)
    origins, destinations = arrays
    still = np.argwhere((origins == destinations).all(axis=-1))
    if len(still):
        raise UserError(f"UAV {still[0][1]} in game {still[0][0]} has the same origin and destination: no mission")
    for g in range(num_games):
        if len(np.unique(origins[g], axis=0)) < scenario.num_uavs:
            raise UserError(f"two UAVs of game {g} share an origin, which Eq. (4), eq:collision, forbids")
    return Missions(origins, destinations)
