"""Independent Q-learning by quantiles: a policy with quantiles makes each learner an sb3-contrib QRDQN."""

from typing import Any

import numpy as np
import pytest
import torch as th
from numpy.typing import NDArray
from sb3_contrib import QRDQN
from stable_baselines3.common.logger import Logger
from torch import nn

from lawn_sb3.algos.iql import IQL
from lawn_sb3.envs import ObservationLayout
from policies.quantile_q import QuantileQPolicy
from tests.algos.games import ScriptedVecEnv
from tests.algos.small import SMALL, VECTOR, acts, independent, parameters, some_observations

N = SMALL.num_uavs


def learner(**kwargs: Any) -> Any:
    return independent(QuantileQPolicy, **{"policy_kwargs": {"net_arch": [32], "n_quantiles": 4}, **kwargs})


def quantiles(model: IQL, uav: int, flat: NDArray[np.float32]) -> NDArray[np.float32]:
    """A UAV's quantiles of the return by observation, quantile and action."""
    net: Any = model.learners[uav].policy.quantile_net
    with th.no_grad():
        answer: NDArray[np.float32] = net(model.policy.views.observe(uav, th.as_tensor(flat))).numpy()
    return answer


class Corridors(ScriptedVecEnv):
    """Two UAVs, each in a corridor of three cells: the first gets out with action 1, the second with action 0.

    The other action leads back, from the innermost cell nowhere. What a UAV sees is a one at its steps to the way out.
    Getting out pays each of ``pays`` with the same probability.
    """

    def __init__(self, pays: tuple[float, ...] = (1.0,), num_games: int = 16) -> None:
        super().__init__(num_games, ObservationLayout(2, 0), 2)
        self.pays = pays
        self.rng = np.random.default_rng(0)
        self.steps_left = np.full((num_games, 2), 3)

    def observe(self, steps_left: NDArray[np.int64]) -> NDArray[np.float32]:
        flat = np.zeros((self.num_envs, self.layout.flat_dim), dtype=np.float32)
        flat[np.arange(self.num_envs), steps_left.ravel()] = 1.0
        return flat

    def reset(self) -> NDArray[np.float32]:
        self.steps_left[:] = 3
        return self.observe(self.steps_left)

    def step_wait(self) -> Any:
        towards = self.actions == [1, 0]
        following = np.where(towards, self.steps_left - 1, np.minimum(self.steps_left + 1, 3))
        out = following == 0
        rewards = np.where(out, self.rng.choice(self.pays, size=out.shape), 0.0).astype(np.float32)
        last = self.observe(following)
        infos = [{"terminal_observation": last[k]} if gone else {} for k, gone in enumerate(out.ravel())]
        self.steps_left = np.where(out, 3, following)
        return self.observe(self.steps_left), rewards.ravel(), out.ravel(), infos


def out_of_corridors(*pays: float) -> IQL:
    """A table of four quantiles for each cell and action, learned from random walks with a discount of one half."""
    model = IQL(
        QuantileQPolicy, Corridors(pays), learning_rate=lambda progress: 0.05 * progress, buffer_size=5_000,
        learning_starts=160, batch_size=128, gamma=0.5, train_freq=1, target_update_interval=160,
        exploration_final_eps=1.0, policy_kwargs={"net_arch": [], "n_quantiles": 4}, seed=0, device="cpu",
    )  # fmt: skip
    return model.learn(400 * 32)


def test_the_way_out_of_a_corridor_is_found_and_worth_its_discounted_pay() -> None:
    # Forth from 1, 2, 3 steps: 1, 1/2, 1/4. Back from there, then the best: half of 1/2, 1/4 and, from the end, 1/4.
    forth, back = [1.0, 0.5, 0.25], [0.25, 0.125, 0.125]
    model = out_of_corridors(1.0)
    cells = np.zeros((6, model.layout.flat_dim), dtype=np.float32)
    cells[np.arange(6), np.repeat([1, 2, 3], 2)] = 1.0
    assert acts(model, cells) == [1, 0] * 3  # both see the same, each has a way of its own
    for uav, (first, second) in enumerate([(back, forth), (forth, back)]):
        answer = quantiles(model, uav, cells)
        expected = np.stack([first, second], axis=1)[:, None].repeat(4, axis=1)  # sure: all quantiles are the same
        np.testing.assert_allclose(answer, expected, atol=2e-3)


def test_a_coin_s_pay_is_learned_as_a_distribution() -> None:
    """Getting out pays 0 or 1. The Huber loss is quadratic there: quantile q at level t has slope t (1 - q) where it
    lies below a pay of 1 and (1 - t) q where it lies above one of 0, which are as large at q = t."""
    model = out_of_corridors(0.0, 1.0)
    cells = np.zeros((2, model.layout.flat_dim), dtype=np.float32)
    cells[:, 1] = 1.0
    for uav, forth in ((0, 1), (1, 0)):
        answer = quantiles(model, uav, cells)[0, :, forth]
        np.testing.assert_allclose(answer, [1 / 8, 3 / 8, 5 / 8, 7 / 8], atol=0.05)


def test_the_loss_compares_each_quantile_with_the_target_network_s_of_its_best_mean() -> None:
    model = IQL(
        QuantileQPolicy, Corridors(num_games=1), buffer_size=1, batch_size=1, gamma=0.9, seed=0, device="cpu",
        policy_kwargs={"net_arch": [], "n_quantiles": 2},
    )  # fmt: skip
    for one in model.learners:
        assert isinstance(one, QRDQN)
        for net, bias in (
            (one.quantile_net, [[9.0, 2.0], [9.0, 2.0]]),  # by quantile and action
            (one.quantile_net_target, [[0.0, 1.0], [4.0, 2.0]]),  # means 2 and 1.5: action 0 follows
        ):
            layer: Any = net.quantile_net[0]
            with th.no_grad():
                layer.weight.zero_()
                layer.bias.copy_(th.tensor(bias).ravel())
    seen = np.zeros((2, model.layout.flat_dim), dtype=np.float32)
    rewards, dones = np.array([0.5, 0.5], dtype=np.float32), np.array([False, True])
    model.replay_buffer.add(seen, seen, np.array([1, 1]), rewards, dones, [{}, {}])
    model.set_logger(Logger(None, []))
    model.train(1, batch_size=1)
    # The first flies on: targets 0.5 + 0.9 * (0, 4) = (0.5, 4.1), estimates (2, 2), so errors -1.5 and 2.1, Huber's
    # loss 1 and 1.6; weights of the levels 1/4 and 3/4: 1 * (3/4 + 1/4) and 1.6 * (1/4 + 3/4), on average 1.3.
    # The second is done: both targets 0.5, the loss 1.
    losses = [one.logger.name_to_value["train/loss"] for one in model.learners]
    assert losses == pytest.approx([1.3, 1.0])
    assert model.logger.name_to_value["train/loss"] == pytest.approx(1.15)
    assert model.logger.name_to_value["train/n_updates"] == 1
    assert model.logger.name_to_value["train/learning_rate"] == pytest.approx(1e-4)


def test_greedy_play_follows_the_largest_mean_of_a_uav_s_own_quantiles() -> None:
    model, flat = learner().learn(20 * VECTOR), some_observations()
    for uav in range(N):
        assert acts(model, flat)[uav::N] == quantiles(model, uav, flat).mean(axis=1).argmax(axis=1).tolist()


def test_a_policy_has_two_hidden_layers_of_256_relu_units_and_16_quantiles_an_action() -> None:
    model = learner(policy_kwargs={})
    for one in model.learners:
        for net in (one.quantile_net, one.quantile_net_target):
            layers = list(net.quantile_net)
            assert [type(layer) for layer in layers] == [nn.Linear, nn.ReLU, nn.Linear, nn.ReLU, nn.Linear]
            widths = [(layer.in_features, layer.out_features) for layer in layers[::2]]
            assert widths == [(model.layout.local_dim, 256), (256, 256), (256, 16 * 63)]


def test_the_optimiser_is_qrdqn_s_own_unless_the_policy_s_arguments_say_otherwise() -> None:
    def optimiser(**kwargs: Any) -> Any:
        return learner(batch_size=64, policy_kwargs={"net_arch": [], **kwargs}).learners[0].policy.optimizer

    assert optimiser().defaults["eps"] == 0.01 / 64  # QRDQN: 0.01 over the minibatch
    given = optimiser(optimizer_kwargs={"weight_decay": 0.5})
    assert isinstance(given, th.optim.Adam)
    assert given.defaults["weight_decay"] == 0.5
    assert isinstance(optimiser(optimizer_class=th.optim.SGD), th.optim.SGD)


def test_a_gradient_is_no_longer_than_its_limit() -> None:
    model = learner(
        learning_starts=10**6, learning_rate=1.0, max_grad_norm=0.01,
        policy_kwargs={"net_arch": [], "n_quantiles": 4, "optimizer_class": th.optim.SGD},
    ).learn(10 * VECTOR)  # fmt: skip
    before = [parameters(one).copy() for one in model.learners]
    model.train(1, 32)
    steps = [np.linalg.norm(parameters(one).copy() - old) for one, old in zip(model.learners, before, strict=True)]
    assert steps == pytest.approx([0.01] * N, rel=1e-3)


def test_double_q_with_quantiles_is_refused() -> None:
    with pytest.raises(ValueError, match="double_q needs a policy that is a DQNPolicy: QuantileQPolicy is a QRDQN"):
        learner(double_q=True)


def test_no_quantile_at_all_is_refused() -> None:
    with pytest.raises(ValueError, match="n_quantiles = 0: a whole number from 1 up"):
        learner(policy_kwargs={"n_quantiles": 0})
