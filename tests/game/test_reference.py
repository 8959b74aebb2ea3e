"""The compiled simulator plays exactly the game that the reference plays."""

from typing import cast

import numpy as np
import pytest
from hypothesis import given, settings
from numpy.testing import assert_allclose

from lawn_sb3.choices import Continuation
from lawn_sb3.game import Simulator
from lawn_sb3.scenario import Scenario
from tests.game.random_play import SEEDS, random_actions, scenarios
from tests.game.reference import ReferenceGame, Slot, Uav, Voxel

NUM_GAMES = 2
NUM_SLOTS = 30


def voxel(array: np.ndarray) -> Voxel:
    return cast(Voxel, tuple(array.tolist()))


def mission(simulator: Simulator, game: int, uav: int) -> tuple[Voxel, Voxel]:
    return voxel(simulator.state.position[game, uav]), voxel(simulator.state.destination[game, uav])


def renew(game: ReferenceGame, simulator: Simulator, index: int) -> None:
    """Give the reference's UAVs that are due the missions that the simulator drew for them."""
    if simulator.continuation == "episode" and any(uav.flying for uav in game.uavs):
        return
    for i, uav in enumerate(game.uavs):
        if not uav.flying:
            game.uavs[i] = game.fresh_uav(*mission(simulator, index, i))


def assert_same_outcomes(simulator: Simulator, slots: list[list[Slot]]) -> None:
    for name in Slot._fields:
        expected = [[getattr(slot, name) for slot in game] for game in slots]
        assert_allclose(getattr(simulator.outcome, name), expected, rtol=1e-9, atol=1e-9, err_msg=name)


def assert_same_uavs(simulator: Simulator, games: list[ReferenceGame]) -> None:
    names = [name for name in Uav.__dataclass_fields__ if name != "has_arrived"]
    for name in names:
        expected = [[getattr(uav, name) for uav in game.uavs] for game in games]
        assert_allclose(getattr(simulator.state, name), expected, rtol=1e-9, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("continuation", ["mission", "episode"])
@settings(max_examples=100)
@given(scenario=scenarios(), seed=SEEDS)
def test_simulator_agrees_with_the_reference_slot_by_slot(
    continuation: Continuation, scenario: Scenario, seed: int
) -> None:
    simulator = Simulator(scenario, NUM_GAMES, seed, continuation)
    rng = np.random.default_rng(seed)
    games = [
        ReferenceGame(scenario, [mission(simulator, g, i) for i in range(scenario.num_uavs)]) for g in range(NUM_GAMES)
    ]
    for _ in range(NUM_SLOTS):
        actions = random_actions(simulator, rng)
        simulator.step(actions)
        moves = simulator.rules.actions[actions]
        slots = [game.play([voxel(move) for move in moves[g]]) for g, game in enumerate(games)]
        assert_same_outcomes(simulator, slots)
        assert_same_uavs(simulator, games)
        simulator.go_on()
        for g, game in enumerate(games):
            renew(game, simulator, g)
        assert_same_uavs(simulator, games)
        assert simulator.state.cell_load.tolist() == [game.loads() for game in games]
