"""The data of the compiled game: a scenario's rules, the state of all games, and what a slot gave."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.choices import REWARD_TERMS
from lawn_sb3.game.airspace import Voxel, action_table
from lawn_sb3.game.compiled import njit
from lawn_sb3.game.radio import radio_map, rate_unit_mbps
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

RATE, NAV, COL, TERM = range(len(REWARD_TERMS))
"""Where each term stands in ``Outcome.reward_terms``."""

MEMORY_SLOTS = 4
"""Slots whose cell loads a game remembers."""


class Rules(NamedTuple):
    """A scenario in the form that the compiled step reads."""

    grid: tuple[int, int, int]
    actions: Ints  # [A, 3]
    max_voxel_steps: int
    max_slots: int
    cell: Ints  # [W, L, H]
    rb_rate_mbps: Floats  # [W, L, H]
    num_rbs: Ints  # [M]
    ema_beta: float
    nav_weight: float
    collision_penalty: float
    fail_penalty: float
    rate_unit_mbps: float
    clip_moves: bool
    arrived_stays: bool
    fly_through: bool
    correct_to_deadline: bool


class State(NamedTuple):
    """Everything a game remembers from slot to slot."""

    position: Ints  # [G, N, 3] voxels
    destination: Ints  # [G, N, 3] voxels
    min_slots: Ints  # [G, N]
    slot: Ints  # [G, N] slots flown in this mission
    ema_rate_mbps: Floats  # [G, N]
    flying: Bools  # [G, N]
    cell_load: Ints  # [G, M]
    past_load: Ints  # [G, MEMORY_SLOTS, M] cell loads seen in the slots before, newest first


class Outcome(NamedTuple):
    """What one slot gave each UAV; zero or false for a UAV that was not flying."""

    reward_terms: Floats  # [G, N, 4], in the order of REWARD_TERMS
    rate_mbps: Floats  # [G, N]
    cell: Ints  # [G, N]
    cell_load: Ints  # [G, N] UAVs in this UAV's cell
    num_rbs: Ints  # [G, N]
    corrected_rate_mbps: Floats  # [G, N]
    utility_mbps: Floats  # [G, N] nonzero only on arrival
    collided: Bools  # [G, N]
    arrived: Bools  # [G, N]
    timed_out: Bools  # [G, N]


def build_rules(scenario: Scenario) -> Rules:
    """Work out the tables and constants that the compiled step needs.

    :param scenario: the scenario
    :return: its rules
    """
    link = radio_map(scenario)
    return Rules(
        grid=scenario.grid,
        actions=action_table(scenario.max_voxel_steps),
        max_voxel_steps=scenario.max_voxel_steps,
        max_slots=scenario.max_slots,
        cell=link.cell,
        rb_rate_mbps=link.rb_rate_mbps,
        num_rbs=scenario.num_rbs,
        ema_beta=scenario.ema_beta,
        nav_weight=scenario.nav_weight,
        collision_penalty=scenario.collision_penalty,
        fail_penalty=scenario.fail_penalty,
        rate_unit_mbps=rate_unit_mbps(scenario),
        clip_moves=scenario.out_of_bounds == "clip",
        arrived_stays=scenario.arrived_uav == "stays",
        fly_through=scenario.arrival == "fly-through",
        correct_to_deadline=scenario.bias_horizon == "deadline",
    )


def empty_state(num_games: int, num_uavs: int, num_gbs: int) -> State:
    """The state of G games of N UAVs and M GBSs, all zero."""
    shape = (num_games, num_uavs)
    return State(
        position=np.zeros((*shape, 3), dtype=np.int64),
        destination=np.zeros((*shape, 3), dtype=np.int64),
        min_slots=np.zeros(shape, dtype=np.int64),
        slot=np.zeros(shape, dtype=np.int64),
        ema_rate_mbps=np.zeros(shape),
        flying=np.zeros(shape, dtype=np.bool_),
        cell_load=np.zeros((num_games, num_gbs), dtype=np.int64),
        past_load=np.zeros((num_games, MEMORY_SLOTS, num_gbs), dtype=np.int64),
    )


def empty_outcome(num_games: int, num_uavs: int) -> Outcome:
    """The outcome of a slot of G games of N UAVs, all zero."""
    shape = (num_games, num_uavs)
    return Outcome(
        reward_terms=np.zeros((*shape, len(REWARD_TERMS))),
        rate_mbps=np.zeros(shape),
        cell=np.zeros(shape, dtype=np.int64),
        cell_load=np.zeros(shape, dtype=np.int64),
        num_rbs=np.zeros(shape, dtype=np.int64),
        corrected_rate_mbps=np.zeros(shape),
        utility_mbps=np.zeros(shape),
        collided=np.zeros(shape, dtype=np.bool_),
        arrived=np.zeros(shape, dtype=np.bool_),
        timed_out=np.zeros(shape, dtype=np.bool_),
    )


@njit
def voxel_of(voxels: Ints, game: int, uav: int) -> Voxel:
    """One voxel out of [G, N, 3]; three numbers cost less in compiled code than a view of the array."""
    return voxels[game, uav, 0], voxels[game, uav, 1], voxels[game, uav, 2]


@njit
def bias_horizon(rules: Rules, slots: int) -> int:
    """T-bar, the slots that the bias of the EMA rate is corrected for: those flown, or T_max (reading)."""
    return rules.max_slots if rules.correct_to_deadline else slots
