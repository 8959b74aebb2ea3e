"""Independent Q-learning: N learners that share an environment and nothing else, each as SB3 would train it alone."""

from typing import Any

import numpy as np
import pytest
import torch as th
from numpy.typing import NDArray
from sb3_contrib import QRDQN
from stable_baselines3 import DQN
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecNormalize
from stable_baselines3.common.vec_env.base_vec_env import VecEnvStepReturn

from lawn_sb3.algos.iql import IQL, LEARNERS, DoubleDQN
from lawn_sb3.envs import make_vec_env
from lawn_sb3.envs.observation import space_of
from lawn_sb3.scenario import PRESETS
from policies.local_q import LocalQPolicy
from policies.quantile_q import QuantileQPolicy
from policies.state_critic import StateCriticPolicy
from tests.algos.small import NUM_GAMES, SMALL, VECTOR, acts, independent, parameters, small_env, some_observations

N = SMALL.num_uavs
QUANTILES: dict[str, Any] = {"policy": QuantileQPolicy, "policy_kwargs": {"net_arch": [32], "n_quantiles": 4}}
KINDS: dict[str, dict[str, Any]] = {
    "vanilla": {},
    "double": {"double_q": True},
    "shared": {"share_parameters": True},
    "quantiles": QUANTILES,
    "shared quantiles": {**QUANTILES, "share_parameters": True},
}
EACH_KIND = pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)


def networks(one: Any) -> tuple[Any, Any]:
    return (one.quantile_net, one.quantile_net_target) if isinstance(one, QRDQN) else (one.q_net, one.q_net_target)


class Recorder(VecEnvWrapper):
    def reset(self) -> NDArray[Any]:
        self.seen: Any = self.venv.reset()
        self.record: list[tuple[Any, ...]] = []
        return np.asarray(self.seen)

    def step_async(self, actions: NDArray[Any]) -> None:
        self.actions = actions.copy()
        super().step_async(actions)

    def step_wait(self) -> VecEnvStepReturn:
        seen, rewards, dones, infos = self.venv.step_wait()
        self.record.append((self.seen, self.actions, seen, rewards, dones, infos))
        self.seen = seen
        return seen, rewards, dones, infos


# --- who learns from what ------------------------------------------------------------------------------------------


def test_each_uav_remembers_its_own_transitions_with_the_last_observation_of_a_mission() -> None:
    env = Recorder(small_env())
    model = independent(env=env).learn(30 * VECTOR)
    local = model.layout.local
    ended = 0
    for uav, one in enumerate(model.learners):
        replay: Any = one.replay_buffer
        assert replay.pos == len(env.record) == 30
        for t, (seen, actions, following, rewards, dones, infos) in enumerate(env.record):
            for game in range(NUM_GAMES):
                slot = game * N + uav
                last = infos[slot].get("terminal_observation", following[slot])
                np.testing.assert_array_equal(replay.observations[t, game], seen[slot, local])
                np.testing.assert_array_equal(replay.next_observations[t, game], last[local])
                assert replay.actions[t, game, 0] == actions[slot]
                assert replay.rewards[t, game] == np.float32(rewards[slot])
                assert replay.dones[t, game] == dones[slot]
                ended += dones[slot]
    assert ended > N


def test_a_missed_deadline_is_marked_where_it_is_a_truncation() -> None:
    model: Any = independent(env=small_env(timeout="truncated")).learn(25 * VECTOR)
    assert min(one.replay_buffer.timeouts.sum() for one in model.learners) > 0


@pytest.mark.parametrize(
    ("kind", "made"), [("vanilla", DQN), ("double", DoubleDQN), ("shared", DQN), ("quantiles", QRDQN)]
)
def test_the_policy_class_chooses_the_learner(kind: str, made: type) -> None:
    model = independent(**KINDS[kind])
    assert issubclass(model.policy_class, tuple(LEARNERS))
    assert [type(one) for one in model.learners] == [made] * (1 if kind == "shared" else N)
    if kind != "shared":
        assert [one.observation_space for one in model.learners] == [space_of(model.layout.local_dim)] * N


@pytest.mark.parametrize("kind", ["vanilla", "quantiles"])
def test_learners_share_neither_networks_nor_replays_nor_first_weights(kind: str) -> None:
    model = independent(**KINDS[kind])
    parts = [(one.policy, *networks(one), one.replay_buffer) for one in model.learners]
    assert len({id(part) for own in parts for part in own}) == 4 * N
    first, second = map(parameters, model.learners)
    assert not np.array_equal(first, second)


def test_a_learner_does_not_change_with_the_data_of_others() -> None:
    def trained(changed_uav: int | None) -> list[NDArray[Any]]:
        model: Any = independent(learning_starts=10**6).learn(20 * VECTOR)
        if changed_uav is not None:
            model.learners[changed_uav].replay_buffer.rewards += 1.0
        np.random.seed(0)
        model.train(5, 32)
        return [parameters(one).copy() for one in model.learners]

    plain, changed = trained(None), trained(1)
    np.testing.assert_array_equal(changed[0], plain[0])
    assert not np.array_equal(changed[1], plain[1])


def test_each_row_is_answered_by_the_network_of_its_uav() -> None:
    model, flat = independent().learn(20 * VECTOR), some_observations()
    for uav, one in enumerate(model.learners):
        assert acts(model, flat)[uav::N] == acts(one, flat[uav::N, model.layout.local])


def test_a_shared_network_sees_who_asks() -> None:
    model = independent(share_parameters=True)
    flat = np.repeat(some_observations(1), 2 * N, axis=0)
    seen = model.policy.views.observe(0, th.as_tensor(flat))
    np.testing.assert_array_equal(seen[:, : model.layout.local_dim], flat[:, model.layout.local])
    np.testing.assert_array_equal(seen[:, model.layout.local_dim :], np.tile(np.eye(N), (2, 1)))
    model.learn(20 * VECTOR)
    assert model.learners[0].replay_buffer.size() * model.learners[0].n_envs == 20 * VECTOR


# --- as SB3's DQN and sb3-contrib's QRDQN --------------------------------------------------------------------------


class LocalOnly(VecEnvWrapper):
    """Games seen through o_i alone."""

    def __init__(self, venv: VecEnv) -> None:
        self.layout = venv.get_attr("layout", [0])[0]
        super().__init__(venv, observation_space=space_of(self.layout.local_dim))

    def reset(self) -> NDArray[Any]:
        return np.asarray(self.venv.reset())[:, self.layout.local]

    def step_wait(self) -> VecEnvStepReturn:
        seen, rewards, dones, infos = self.venv.step_wait()
        for info in infos:
            if "terminal_observation" in info:
                info["terminal_observation"] = info["terminal_observation"][self.layout.local]
        return np.asarray(seen)[:, self.layout.local], rewards, dones, infos


@pytest.mark.parametrize(
    ("alone", "changes"), [(DQN, {}), (QRDQN, QUANTILES), (QRDQN, {**QUANTILES, "n_steps": 3, "max_grad_norm": 0.5})]
)
def test_one_uav_alone_learns_as_sb3_would_train_it(alone: type, changes: dict[str, Any]) -> None:
    """Same random play, then the same minibatches: the same network to the last bit."""
    scenario = SMALL.changed(num_uavs=1)
    settings: dict[str, Any] = {
        "policy": LocalQPolicy, "learning_rate": 1e-3, "learning_starts": 10**6, "buffer_size": 400, "gamma": 0.9,
        "batch_size": 64, "tau": 0.5, "seed": 0, "target_update_interval": 40, "exploration_fraction": 0.2,
        "exploration_final_eps": 0.1, "max_grad_norm": 10.0, "policy_kwargs": {"net_arch": [32]}, "device": "cpu",
        **changes,
    }  # fmt: skip
    iql: Any = IQL(env=make_vec_env(scenario, NUM_GAMES), **settings)
    single: Any = alone(env=LocalOnly(make_vec_env(scenario, NUM_GAMES)), **settings)
    for model in (iql, single):
        model.learn(30 * NUM_GAMES)
        np.random.seed(0)
        for _ in range(10):
            model.train(3, 64)
            model._on_step()
    np.testing.assert_array_equal(parameters(iql.learners[0]), parameters(single))
    assert iql._n_updates == single._n_updates == 30
    assert iql.exploration_rate == single.exploration_rate


@EACH_KIND
def test_the_target_networks_follow_every_so_many_env_steps(kind: dict[str, Any]) -> None:
    model = independent(target_update_interval=5 * NUM_GAMES, learning_starts=0, train_freq=1, **kind)
    for vector_steps, same in ((4, False), (5, True), (6, False), (10, True)):
        model.learn(vector_steps * VECTOR - model.num_timesteps, reset_num_timesteps=False)
        # At the fifth step the copy is made before that step's update.
        pairs = zip(*(net.parameters() for net in networks(model.learners[0])), strict=True)
        moved = max((online - target).abs().max().item() for online, target in pairs)
        assert (moved < 1.5e-3) == same  # one Adam step of 1e-3, not several


@EACH_KIND
def test_buffer_size_is_in_env_steps(kind: dict[str, Any]) -> None:
    model: Any = independent(buffer_size=400, **kind)
    assert sum(one.replay_buffer.buffer_size * one.n_envs for one in model.learners) == N * 400


def test_no_update_before_learning_starts_in_env_steps() -> None:
    model = independent(learning_starts=10 * NUM_GAMES, train_freq=1)
    before = parameters(model)
    model.learn(10 * VECTOR)
    np.testing.assert_array_equal(parameters(model), before)
    model.learn(VECTOR, reset_num_timesteps=False)
    assert not np.array_equal(parameters(model), before)


@EACH_KIND
def test_a_gradient_step_for_every_transition_a_learner_got(kind: dict[str, Any]) -> None:
    model = independent(gradient_steps=-1, learning_starts=0, train_freq=2, **kind).learn(2 * VECTOR)
    assert model._n_updates == 2 * VECTOR // len(model.learners)


def test_the_learning_rate_of_every_learner_follows_the_progress() -> None:
    model = independent(learning_rate=lambda progress: 1e-3 * progress).learn(40 * VECTOR)
    rates = [one.policy.optimizer.param_groups[0]["lr"] for one in model.learners]
    assert rates == pytest.approx([0.0] * N, abs=1e-9)


# --- exploration ---------------------------------------------------------------------------------------------------


def test_every_slot_draws_epsilon_for_itself() -> None:
    model, flat = independent(), np.repeat(some_observations(N), 200, axis=0)
    greedy = np.array(acts(model, flat))
    model.exploration_rate = 0.5
    explored = [np.mean(model.predict(flat)[0] != greedy) for _ in range(10)]
    expected, spread = 0.5 * (1 - 1 / 63), np.sqrt(0.25 / len(flat))
    assert all(abs(share - expected) < 5 * spread for share in explored)


def test_greedy_play_draws_nothing_and_epsilon_one_is_uniform() -> None:
    model, flat = independent(), np.tile(some_observations(N), (2000, 1))
    model.exploration_rate = 1.0
    assert acts(model, flat) == acts(model, flat)
    counts = np.bincount(model.predict(flat)[0], minlength=63)
    assert counts.min() > 0
    assert np.abs(counts - len(flat) / 63).max() < 6 * np.sqrt(len(flat) / 63)


@pytest.mark.parametrize("kind", ["vanilla", "quantiles"])
def test_epsilon_falls_over_its_share_of_the_training(kind: str) -> None:
    seen: list[float] = []

    def watch(local: dict[str, Any], _: dict[str, Any]) -> bool:
        seen.append(local["self"].exploration_rate)  # as it was when the step's actions were drawn
        return True

    rates = {"exploration_fraction": 0.5, "exploration_initial_eps": 0.8, "exploration_final_eps": 0.2}
    independent(**{**KINDS[kind], **rates}).learn(8 * VECTOR, callback=watch)
    assert seen == pytest.approx([0.0, 0.65, 0.5, 0.35, 0.2, 0.2, 0.2, 0.2])  # the first step is random play


# --- what is kept, and refused -------------------------------------------------------------------------------------


def test_a_loaded_model_has_the_optimisers_and_counters_of_every_learner(tmp_path: Any) -> None:
    trained = independent().learn(30 * VECTOR)
    trained.save(tmp_path / "model.zip")
    loaded = IQL.load(tmp_path / "model.zip", env=small_env(), device="cpu")
    for one, other in zip(loaded.learners, trained.learners, strict=True):
        assert (one._n_calls, one._n_updates) == (other._n_calls, other._n_updates)
        moments = [m.policy.optimizer.state_dict()["state"][0]["exp_avg"] for m in (one, other)]
        assert moments[0].equal(moments[1])
    assert loaded.learning_starts == trained.learning_starts
    other_games = make_vec_env(PRESETS["paper"].changed(num_uavs=1, gbs_grid=[5, 1]), NUM_GAMES)
    assert other_games.observation_space == small_env().observation_space  # though the vector is as long
    with pytest.raises(ValueError, match="num_uavs=2, num_gbs=4"):
        IQL.load(tmp_path / "model.zip", env=other_games, device="cpu")


def test_memory_is_as_long_as_what_is_remembered() -> None:
    model: Any = independent().learn(30 * VECTOR)
    for content, one in zip(model.memory()["replays"], model.learners, strict=True):
        assert set(content["arrays"]) == {
            "observations", "next_observations", "actions", "rewards", "dones", "timeouts",
        }  # fmt: skip
        assert {len(array) for array in content["arrays"].values()} == {30}
        assert content["pos"] == one.replay_buffer.pos


@EACH_KIND
def test_a_single_uav_in_a_single_game_works(kind: dict[str, Any]) -> None:
    env = make_vec_env(SMALL.changed(num_uavs=1), 1)
    model = independent(env=env, **kind).learn(200)
    observation = np.asarray(env.reset())
    assert model.predict(observation)[0].shape == (1,)
    assert model.predict(observation[0])[0].shape == ()


def test_rows_that_are_no_whole_games_are_refused() -> None:
    with pytest.raises(ValueError, match="3 observations are no whole games of 2 UAVs"):
        independent().predict(some_observations(3))


def test_environments_it_cannot_learn_in_are_refused() -> None:
    with pytest.raises(ValueError, match="layout"):
        IQL("MlpPolicy", "CartPole-v1", device="cpu")
    with pytest.raises(ValueError, match="VecNormalize"):
        independent(env=VecNormalize(small_env()))


@pytest.mark.parametrize("policy", [StateCriticPolicy, ActorCriticPolicy])
def test_a_policy_without_action_values_is_refused(policy: Any) -> None:
    allowed = r"stable_baselines3.dqn.policies:DQNPolicy or sb3_contrib.qrdqn.policies:QRDQNPolicy"
    with pytest.raises(ValueError, match=f"no learner for a {policy.__name__}: its policy must be a {allowed}"):
        IQL(policy, small_env(), device="cpu")
