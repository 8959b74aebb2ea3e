"""Independent Q-learning by quantiles: a policy with quantiles makes each learner an sb3-contrib QRDQN."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch as th
from numpy.typing import NDArray
from sb3_contrib import QRDQN
from stable_baselines3 import DQN
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.vec_env import VecEnv
from torch import nn

from lawn_sb3.algos.iql import IQL, LEARNERS, IndependentPolicy
from lawn_sb3.envs import ObservationLayout, make_vec_env
from policies.local_q import LocalQPolicy
from policies.quantile_q import QuantileQPolicy
from policies.state_critic import StateCriticPolicy
from tests.algos.games import ScriptedVecEnv
from tests.algos.small import NUM_GAMES, SMALL, parameters, small_env, some_observations
from tests.algos.test_iql import LocalOnly, acts, network

N = SMALL.num_uavs
VECTOR = NUM_GAMES * N
"""Agent steps in one vector step."""
KINDS: list[dict[str, Any]] = [{}, {"share_parameters": True}, {"n_steps": 3}]
NAMES = ["independent", "shared", "n-step"]


def learner(env: VecEnv | None = None, **kwargs: Any) -> IQL:
    """A small IQL by quantiles, untrained."""
    small: dict[str, Any] = {
        "learning_rate": 1e-3, "buffer_size": 400, "learning_starts": 64, "batch_size": 32, "gamma": 0.9,
        "train_freq": 2, "target_update_interval": 80, "policy_kwargs": {"net_arch": [32], "n_quantiles": 4},
        "seed": 0, "device": "cpu",
    }  # fmt: skip
    return IQL(QuantileQPolicy, env or small_env(), **{**small, **kwargs})


def quantiles(model: IQL, uav: int, flat: NDArray[np.float32]) -> NDArray[np.float32]:
    """A UAV's quantiles of the return by observation, quantile and action."""
    net = model.learners[uav].policy.quantile_net  # type: ignore[union-attr]
    with th.no_grad():
        answer: NDArray[np.float32] = net(model.policy.views.observe(uav, th.as_tensor(flat))).numpy()
    return answer


class Corridors(ScriptedVecEnv):
    """Two UAVs, each in a corridor of three cells: the first gets out with action 1, the second with action 0.

    The other action leads back, from the innermost cell nowhere. What a UAV sees is a one at its steps to the way out.

    :param pays: what getting out may pay, each with the same probability
    :param num_games: games played side by side
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


# --- what is learned -----------------------------------------------------------------------------------------------


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


# --- who learns from what ------------------------------------------------------------------------------------------


def test_the_policy_class_chooses_the_learner() -> None:
    assert issubclass(QuantileQPolicy, tuple(LEARNERS))
    assert issubclass(LocalQPolicy, tuple(LEARNERS))
    assert [type(one) for one in learner().learners] == [QRDQN] * N
    assert [type(one) for one in learner(share_parameters=True).learners] == [QRDQN]
    assert [type(one) for one in IQL(LocalQPolicy, small_env(), buffer_size=100, device="cpu").learners] == [DQN] * N


def test_learners_share_neither_networks_nor_replays_nor_first_weights() -> None:
    model = learner().learn(10 * VECTOR)
    for part in ("policy", "quantile_net", "quantile_net_target", "replay_buffer"):
        assert len({id(getattr(one, part)) for one in model.learners}) == N
    assert [one.replay_buffer.pos for one in model.learners] == [10] * N  # type: ignore[union-attr]
    assert not np.array_equal(network(model.learners[0]), network(model.learners[1]))  # type: ignore[arg-type]


@pytest.mark.parametrize("steps", [0, 20], ids=["untrained", "trained"])
@pytest.mark.parametrize("kind", KINDS, ids=NAMES)
def test_acting_and_values_read_o_i_alone(kind: dict[str, Any], steps: int) -> None:
    model, flat = learner(**kind), some_observations()
    model.learn(steps * VECTOR)
    changed, rng = flat.copy(), np.random.default_rng(0)
    changed[:, model.layout.state] = rng.normal(scale=3.0, size=changed[:, model.layout.state].shape)
    elsewhere = flat.copy()
    elsewhere[:, model.layout.local] *= -3.0
    for uav in range(len(model.learners)):
        np.testing.assert_array_equal(quantiles(model, uav, changed), quantiles(model, uav, flat))
        assert not np.array_equal(quantiles(model, uav, elsewhere), quantiles(model, uav, flat))
    assert acts(model, changed) == acts(model, flat)


def test_greedy_play_follows_the_largest_mean_of_a_uav_s_own_quantiles() -> None:
    model, flat = learner().learn(20 * VECTOR), some_observations()
    for uav in range(N):
        assert acts(model, flat)[uav::N] == quantiles(model, uav, flat).mean(axis=1).argmax(axis=1).tolist()


def test_a_policy_has_two_hidden_layers_of_256_relu_units_and_16_quantiles_an_action() -> None:
    model = learner(policy_kwargs={})
    for one in model.learners:
        for net in (one.quantile_net, one.quantile_net_target):  # type: ignore[union-attr]
            layers = list(net.quantile_net)
            assert [type(layer) for layer in layers] == [nn.Linear, nn.ReLU, nn.Linear, nn.ReLU, nn.Linear]
            widths = [(layer.in_features, layer.out_features) for layer in layers[::2]]
            assert widths == [(model.layout.local_dim, 256), (256, 256), (256, 16 * 63)]


# --- as sb3-contrib's QRDQN ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("n_steps", [1, 3])
def test_one_uav_alone_learns_as_sb3_contrib_s_qrdqn(n_steps: int) -> None:
    """Same random play, then the same minibatches: the same network to the last bit."""
    scenario = SMALL.changed(num_uavs=1)
    settings: dict[str, Any] = {
        "learning_rate": 1e-3, "learning_starts": 10**6, "buffer_size": 400, "batch_size": 64, "gamma": 0.9,
        "tau": 0.5, "seed": 0, "target_update_interval": 40, "max_grad_norm": 0.5, "exploration_fraction": 0.2,
        "exploration_final_eps": 0.1, "n_steps": n_steps, "device": "cpu",
        "policy_kwargs": {"net_arch": [32], "n_quantiles": 4},
    }  # fmt: skip
    iql = IQL(QuantileQPolicy, make_vec_env(scenario, NUM_GAMES), **settings)
    qrdqn = QRDQN(QuantileQPolicy, LocalOnly(make_vec_env(scenario, NUM_GAMES)), **settings)
    for model in (iql, qrdqn):
        model.learn(30 * NUM_GAMES)
        np.random.seed(0)
        for _ in range(10):
            model.train(3, 64)
            model._on_step()
    np.testing.assert_array_equal(network(iql.learners[0]), network(qrdqn))  # type: ignore[arg-type]
    assert iql._n_updates == qrdqn._n_updates == 30
    assert iql.exploration_rate == qrdqn.exploration_rate


@pytest.mark.parametrize("kind", KINDS, ids=NAMES)
def test_the_target_networks_follow_every_so_many_env_steps(kind: dict[str, Any]) -> None:
    model = learner(target_update_interval=5 * NUM_GAMES, learning_starts=0, train_freq=1, **kind)
    for vector_steps, same in ((4, False), (5, True), (6, False), (10, True)):
        model.learn(vector_steps * VECTOR - model.num_timesteps, reset_num_timesteps=False)
        one = model.learners[0]
        assert isinstance(one, QRDQN)
        # At the fifth step the copy is made before that step's update.
        pairs = zip(one.quantile_net.parameters(), one.quantile_net_target.parameters(), strict=True)
        moved = max((online - target).abs().max().item() for online, target in pairs)
        assert (moved < 1.5e-3) == same  # one Adam step of 1e-3, not several


def test_epsilon_falls_over_its_share_of_the_training() -> None:
    seen: list[float] = []

    def watch(local: dict[str, Any], _: dict[str, Any]) -> bool:
        seen.append(local["self"].exploration_rate)  # as it was when the step's actions were drawn
        return True

    model = learner(exploration_fraction=0.5, exploration_initial_eps=0.8, exploration_final_eps=0.2)
    model.learn(8 * VECTOR, callback=watch)
    assert seen == pytest.approx([0.0, 0.65, 0.5, 0.35, 0.2, 0.2, 0.2, 0.2])  # the first step is random play


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
    before = [network(one) for one in model.learners]  # type: ignore[arg-type]
    model.train(1, 32)
    steps = [np.linalg.norm(network(one) - old) for one, old in zip(model.learners, before, strict=True)]  # type: ignore[arg-type]
    assert steps == pytest.approx([0.01] * N, rel=1e-3)


# --- save, load, resume --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS, ids=NAMES)
def test_a_loaded_model_acts_the_same(kind: dict[str, Any], tmp_path: Path) -> None:
    trained, flat = learner(**kind).learn(30 * VECTOR), some_observations()
    trained.save(tmp_path / "model.zip")
    trained.policy.save(tmp_path / "policy.zip")
    loaded = IQL.load(tmp_path / "model.zip", device="cpu")
    assert len(set(acts(trained, flat))) > 1
    assert acts(loaded, flat) == acts(trained, flat)
    assert acts(IndependentPolicy.load(tmp_path / "policy.zip", device="cpu"), flat) == acts(trained, flat)
    np.testing.assert_array_equal(parameters(loaded), parameters(trained))
    assert [type(one) for one in loaded.learners] == [QRDQN] * len(trained.learners)
    actions = []
    for model in (trained, loaded):  # epsilon is saved too
        np.random.seed(0)
        actions.append(model.predict(flat)[0])
    np.testing.assert_array_equal(*actions)


@pytest.mark.parametrize("kind", [*KINDS, {"learning_starts": 24 * NUM_GAMES}], ids=[*NAMES, "amid random play"])
def test_a_training_resumed_with_its_memory_ends_with_the_same_weights(kind: dict[str, Any]) -> None:
    env, saved = small_env(), io.BytesIO()
    whole = learner(env, **kind).learn(21 * VECTOR)
    whole.save(saved)
    memory, games = whole.memory(), env.env_method("snapshot", indices=0)[0]
    random = np.random.get_state(), th.get_rng_state()
    whole.learn(40 * VECTOR, reset_num_timesteps=False)

    env = small_env()
    env.reset()
    saved.seek(0)
    resumed = IQL.load(saved, env=env, device="cpu", force_reset=False)
    before = parameters(resumed)
    resumed.restore_memory(memory)
    env.env_method("restore", games, indices=0)
    np.random.set_state(random[0])
    th.set_rng_state(random[1])
    resumed.learn(40 * VECTOR, reset_num_timesteps=False)
    np.testing.assert_array_equal(parameters(resumed), parameters(whole))
    assert not np.array_equal(parameters(resumed), before)


def test_one_seed_trains_one_model() -> None:
    one, again, other = (learner(seed=seed).learn(20 * VECTOR) for seed in (0, 0, 1))
    np.testing.assert_array_equal(parameters(one), parameters(again))
    assert not np.array_equal(parameters(one), parameters(other))


# --- refusals ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("policy", [StateCriticPolicy, ActorCriticPolicy])
def test_a_policy_without_action_values_is_refused(policy: Any) -> None:
    allowed = r"stable_baselines3.dqn.policies:DQNPolicy or sb3_contrib.qrdqn.policies:QRDQNPolicy"
    with pytest.raises(ValueError, match=f"no learner for a {policy.__name__}: its policy must be a {allowed}"):
        IQL(policy, small_env(), device="cpu")


def test_double_q_with_quantiles_is_refused() -> None:
    with pytest.raises(ValueError, match="double_q needs a policy that is a DQNPolicy: QuantileQPolicy is a QRDQN"):
        learner(double_q=True)


def test_no_quantile_at_all_is_refused() -> None:
    with pytest.raises(ValueError, match="n_quantiles = 0: a whole number from 1 up"):
        learner(policy_kwargs={"n_quantiles": 0})
