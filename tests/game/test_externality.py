"""What a UAV takes from those in its cell."""

import numpy as np
import pytest

from lawn_sb3.game import Missions, Simulator
from lawn_sb3.game.externality import losses_to_others
from lawn_sb3.scenario import PRESETS, load_scenario

PAPER = PRESETS["paper"]


def flown(origins: list[list[int]], destinations: list[list[int]]) -> Simulator:
    simulator = Simulator(load_scenario("paper", [f"num_uavs={len(origins)}"]))
    simulator.reset(missions=Missions(np.array(origins), np.array(destinations)))
    simulator.step(np.zeros((1, len(origins)), dtype=np.int64))  # all hover
    return simulator


def test_a_lone_uav_takes_nothing() -> None:
    simulator = flown([[0, 0, 0], [9, 9, 0]], [[1, 0, 0], [9, 8, 0]])
    assert losses_to_others(simulator.rules, simulator.state, simulator.outcome).tolist() == [[0.0, 0.0]]


def test_two_in_a_cell_take_half_the_others_rate_weighted_as_its_utility_weighs_it() -> None:
    # Both hover one slot and need one more, T_min = 1 and T = 2. With beta = 0.1 the first of two slots weighs
    # 0.1 * 0.9 / (1 - 0.9^2) * 1/2; alone, a UAV would have 10 RBs instead of 5.
    simulator = flown([[0, 0, 0], [1, 1, 0]], [[1, 0, 0], [1, 2, 0]])
    weight = 0.1 * 0.9 / (1 - 0.81) / 2
    rates = simulator.outcome.rate_mbps[0]
    losses = losses_to_others(simulator.rules, simulator.state, simulator.outcome)[0]
    assert losses == pytest.approx(weight * rates[::-1])


@pytest.mark.parametrize("uav", [0, 1, 2])
def test_own_utility_less_the_losses_is_what_the_welfare_changes_by(uav: int) -> None:
    # All fly straight; without a UAV, the others have what it took from them.
    origins, destinations = [[0, 0, 0], [2, 2, 0], [4, 1, 1]], [[3, 3, 0], [1, 1, 2], [0, 2, 0]]

    def play(uavs: list[int]) -> tuple[np.ndarray, np.ndarray]:
        simulator = Simulator(load_scenario("paper", [f"num_uavs={len(uavs)}"]))
        simulator.reset(missions=Missions(np.array(origins)[uavs], np.array(destinations)[uavs]))
        utility, losses = np.zeros(len(uavs)), np.zeros(len(uavs))
        while simulator.state.flying.any():
            outcome = simulator.step(simulator.allowed_moves(0).argmax(axis=-1))
            utility += outcome.utility_mbps[0]
            losses += losses_to_others(simulator.rules, simulator.state, outcome)[0]
        return utility, losses

    together, losses = play([0, 1, 2])
    others = [j for j in range(3) if j != uav]
    without, _ = play(others)
    assert losses[uav] == pytest.approx(without.sum() - together[others].sum())
