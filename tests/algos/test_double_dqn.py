"""Double Q-learning: SB3's DQN with another target and nothing else."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch as th
from gymnasium import spaces
from stable_baselines3 import DQN
from stable_baselines3.common.logger import Logger

from lawn_sb3.algos.iql import DoubleDQN
from lawn_sb3.algos.iql.double_dqn import double_q

TRANSITION: tuple[np.ndarray, ...] = (
    np.array([[1.0, 0.0]], dtype=np.float32),
    np.array([[0.0, 1.0]], dtype=np.float32),
)
ACTION, REWARD, GAMMA = 2, 0.5, 0.9


class Bare(gym.Env[np.ndarray, np.int64]):
    """Three actions, two numbers to see; never stepped."""

    observation_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
    action_space = spaces.Discrete(3)


def learner(algorithm: type[DQN]) -> Any:
    """A linear learner that remembers one transition."""
    model: Any = algorithm(
        "MlpPolicy", Bare(), learning_rate=0.1, buffer_size=1, gamma=GAMMA, seed=0, device="cpu",
        policy_kwargs={"net_arch": [], "optimizer_class": th.optim.SGD},
    )  # fmt: skip
    with th.no_grad():
        online, target = (net.q_net[0] for net in (model.q_net, model.q_net_target))
        for layer in (online, target):
            layer.weight.zero_()
        online.bias.copy_(th.tensor([3.0, 1.0, 2.0]))
        target.bias.copy_(th.tensor([0.5, 4.0, 1.0]))
    return model


def trained_once(algorithm: type[DQN], done: bool = False) -> Any:
    model = learner(algorithm)
    model.set_logger(Logger(None, []))
    model.replay_buffer.add(*TRANSITION, np.array([ACTION]), np.array([REWARD]), np.array([done]), [{}])
    model.train(1, batch_size=1)
    return model


def loss(model: Any) -> float:
    return float(model.logger.name_to_value["train/loss"])


def test_the_online_network_picks_and_the_target_network_judges() -> None:
    online = th.tensor([[3.0, 1.0, 2.0], [0.0, 1.0, 5.0]])
    target = th.tensor([[0.5, 4.0, 1.0], [7.0, 8.0, -1.0]])
    value = double_q(lambda _: online, lambda _: target)(th.zeros(2, 2))
    assert value.tolist() == [[0.5], [-1.0]]  # actions 0 and 2, not the target's own largest, 4 and 8


def test_the_loss_is_that_of_the_double_q_target() -> None:
    # Q = 2 and the loss is |y - Q| - 0.5. Vanilla: y = 0.5 + 0.9 * 4 = 4.1; double: y = 0.5 + 0.9 * 0.5 = 0.95.
    assert loss(trained_once(DQN)) == pytest.approx(1.6)
    assert loss(trained_once(DoubleDQN)) == pytest.approx(0.55)


@pytest.mark.parametrize("algorithm", [DQN, DoubleDQN])
def test_nothing_follows_the_end_of_a_mission(algorithm: type[DQN]) -> None:
    assert loss(trained_once(algorithm, done=True)) == pytest.approx(1.5 - 0.5)  # y = 0.5, Q = 2


def test_only_the_action_taken_moves_and_the_target_network_stays() -> None:
    model = trained_once(DoubleDQN)
    bias = model.q_net.q_net[0].bias
    assert bias.tolist() == pytest.approx([3.0, 1.0, 2.0 - 0.1])  # Huber's slope is 1 beyond an error of 1
    assert model.q_net_target is model.policy.q_net_target
    target_bias = model.q_net_target.q_net[0].bias
    assert target_bias.tolist() == [0.5, 4.0, 1.0]


def test_the_target_network_is_back_after_a_failure() -> None:
    model = learner(DoubleDQN)
    with pytest.raises((ValueError, AttributeError)):  # nothing to sample, no logger
        model.train(1)
    assert model.q_net_target is model.policy.q_net_target
