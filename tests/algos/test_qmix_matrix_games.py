"""QMIX on one-step games of two players: what a monotonic mix of Qs can hold, and what it cannot."""

from typing import Any

import numpy as np
import pytest
import torch as th
from numpy.typing import NDArray

from lawn_sb3.algos.qmix import QMIX
from policies.additive_mixer import AdditiveMixerPolicy
from policies.monotonic_mixer import MonotonicMixerPolicy
from tests.algos.games import MatrixGame
from tests.algos.small import acts

MONOTONIC = [[0.0, 2.0, 4.0], [1.0, 3.0, 6.0], [2.0, 5.0, 9.0]]
"""Each player does best to play 2, whatever the other plays; no sum of two numbers gives these payoffs."""
NOT_MONOTONIC = [[8.0, -12.0, -12.0], [-12.0, 0.0, 0.0], [-12.0, 0.0, 0.0]]
"""The game of QMIX's authors: 0 pays if the other plays 0 too, and is ruinous otherwise."""


def matrix_player(payoff: Any, policy: Any = MonotonicMixerPolicy) -> QMIX:
    """QMIX after some seconds of uniformly random play."""
    model = QMIX(
        policy, MatrixGame(payoff), learning_rate=3e-3, buffer_size=2_000, learning_starts=200, batch_size=64,
        target_update_interval=50, exploration_initial_eps=1.0, exploration_final_eps=1.0,
        policy_kwargs={"net_arch": [32, 32]}, seed=0, device="cpu",
    )  # fmt: skip
    return model.learn(700 * 32)


def joint_action(model: QMIX) -> tuple[int, int]:
    one, other = acts(model, MatrixGame(MONOTONIC, num_games=1).reset())
    return one, other


def mixed_payoffs(model: QMIX) -> NDArray[Any]:
    layout = model.policy.layout
    flat = th.as_tensor(MatrixGame(MONOTONIC, num_games=1).reset()).repeat(9, 1, 1)
    joint = th.cartesian_prod(th.arange(3), th.arange(3))
    everybody = th.ones(9, 2, dtype=th.bool)
    with th.no_grad():
        values = model.policy.game_values(flat[..., layout.local], flat[:, 0, layout.state], joint, everybody)
    return values.numpy().reshape(3, 3)


def test_qmix_finds_the_optimum_of_a_monotonic_payoff_and_its_values() -> None:
    model = matrix_player(MONOTONIC)
    assert joint_action(model) == (2, 2)
    np.testing.assert_allclose(mixed_payoffs(model), MONOTONIC, atol=0.3)


def test_the_additive_mixer_cannot_hold_a_payoff_that_is_no_sum_but_finds_its_optimum() -> None:
    model = matrix_player(MONOTONIC, AdditiveMixerPolicy)
    assert joint_action(model) == (2, 2)
    assert np.abs(mixed_payoffs(model) - MONOTONIC).max() > 0.5


@pytest.mark.parametrize("policy", [MonotonicMixerPolicy, AdditiveMixerPolicy])
def test_qmix_misses_the_optimum_of_a_payoff_that_is_not_monotonic(policy: Any) -> None:
    model = matrix_player(NOT_MONOTONIC, policy)
    assert joint_action(model) != (0, 0)
    assert NOT_MONOTONIC[joint_action(model)[0]][joint_action(model)[1]] == 0.0
    assert mixed_payoffs(model)[0, 0] < 4.0  # it cannot even hold it
