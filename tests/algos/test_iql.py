"""Independent Q-learning: N learners that share an environment and nothing else."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch as th
from stable_baselines3 import DQN
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.save_util import load_from_zip_file
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecNormalize
from stable_baselines3.common.vec_env.base_vec_env import VecEnvStepReturn

from lawn_sb3.algos.iql import IQL, DoubleDQN, IndependentPolicy
from lawn_sb3.envs import make_vec_env
from lawn_sb3.scenario import PRESETS
from policies.local_q import LocalQPolicy
from tests.algos.small import NUM_GAMES, SMALL, parameters, small_env, some_observations

ROOT = Path(__file__).parents[2]
N = SMALL.num_uavs
VECTOR = NUM_GAMES * N
"""Agent steps in one vector step."""
KINDS: list[dict[str, bool]] = [{}, {"double_q": True}, {"share_parameters": True}]


def learner(env: VecEnv | None = None, **kwargs: Any) -> IQL:
    """A small IQL, untrained."""
    small: dict[str, Any] = {
        "learning_rate": 1e-3, "buffer_size": 400, "learning_starts": 64, "batch_size": 32, "gamma": 0.9,
        "train_freq": 2, "target_update_interval": 80, "policy_kwargs": {"net_arch": [32]}, "seed": 0, "device": "cpu",
    }  # fmt: skip
    return IQL(LocalQPolicy, env or small_env(), **{**small, **kwargs})


def acts(model: Any, observations: np.ndarray) -> list[int]:
    """Greedy actions."""
    actions: list[int] = model.predict(observations, deterministic=True)[0].tolist()
    return actions


def network(one: DQN) -> np.ndarray:
    """All parameters of one learner, target network included."""
    return np.concatenate([tensor.numpy().ravel().copy() for tensor in one.policy.state_dict().values()])


class Recorder(VecEnvWrapper):
    """Keeps everything that passes."""

    def reset(self) -> np.ndarray:
        self.seen: Any = self.venv.reset()
        self.record: list[tuple[Any, ...]] = []
        return np.asarray(self.seen)

    def step_async(self, actions: np.ndarray) -> None:
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
    model = learner(env).learn(30 * VECTOR)
    local = model.layout.local
    ended = 0
    for uav, one in enumerate(model.learners):
        replay = one.replay_buffer
        assert replay is not None
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
    model = learner(small_env(timeout="truncated")).learn(25 * VECTOR)
    timeouts = [one.replay_buffer.timeouts.sum() for one in model.learners]  # type: ignore[union-attr]
    assert min(timeouts) > 0


def test_a_learner_s_space_is_that_of_the_local_observation() -> None:
    model = learner()
    assert [one.observation_space for one in model.learners] == [model.layout.local_space()] * N
    assert type(model.learners[0]) is DQN
    assert type(learner(double_q=True).learners[0]) is DoubleDQN


@pytest.mark.parametrize("kind", KINDS)
def test_the_global_state_never_changes_an_action(kind: dict[str, bool]) -> None:
    model, flat = learner(**kind).learn(20 * VECTOR), some_observations()
    changed = flat.copy()
    changed[:, model.layout.state] = np.random.default_rng(0).normal(
        scale=3.0, size=changed[:, model.layout.state].shape
    )
    assert acts(model, changed) == acts(model, flat)
    changed[:, model.layout.local] *= -3.0
    assert acts(model, changed) != acts(model, flat)


def test_a_learner_does_not_change_with_the_data_of_others() -> None:
    def trained(changed_uav: int | None) -> list[np.ndarray]:
        model = learner(learning_starts=10**6).learn(20 * VECTOR)
        if changed_uav is not None:
            model.learners[changed_uav].replay_buffer.rewards += 1.0  # type: ignore[union-attr]
        np.random.seed(0)
        model.train(5, 32)
        return [network(one) for one in model.learners]

    plain, changed = trained(None), trained(1)
    np.testing.assert_array_equal(changed[0], plain[0])
    assert not np.array_equal(changed[1], plain[1])


def test_learners_share_neither_networks_nor_replays_nor_first_weights() -> None:
    model = learner()
    for part in ("policy", "q_net", "q_net_target", "replay_buffer"):
        assert len({id(getattr(one, part)) for one in model.learners}) == N
    assert not np.array_equal(network(model.learners[0]), network(model.learners[1]))


def test_each_row_is_answered_by_the_network_of_its_uav() -> None:
    model, flat = learner().learn(20 * VECTOR), some_observations()
    for uav, one in enumerate(model.learners):
        own, _ = one.predict(flat[uav::N, model.layout.local], deterministic=True)
        assert acts(model, flat)[uav::N] == own.tolist()


# --- as SB3's DQN --------------------------------------------------------------------------------------------------


class LocalOnly(VecEnvWrapper):
    """Games seen through o_i alone."""

    def __init__(self, venv: VecEnv) -> None:
        self.layout = venv.get_attr("layout", [0])[0]
        super().__init__(venv, observation_space=self.layout.local_space())

    def reset(self) -> np.ndarray:
        return np.asarray(self.venv.reset())[:, self.layout.local]

    def step_wait(self) -> VecEnvStepReturn:
        seen, rewards, dones, infos = self.venv.step_wait()
        for info in infos:
            if "terminal_observation" in info:
                info["terminal_observation"] = info["terminal_observation"][self.layout.local]
        return np.asarray(seen)[:, self.layout.local], rewards, dones, infos


def test_one_uav_alone_learns_as_sb3_s_dqn() -> None:
    """Same random play, then the same minibatches: the same network to the last bit."""
    scenario = SMALL.changed(num_uavs=1)
    settings: dict[str, Any] = {
        "learning_rate": 1e-3, "learning_starts": 10**6, "buffer_size": 400, "gamma": 0.9, "tau": 0.5, "seed": 0,
        "target_update_interval": 40, "policy_kwargs": {"net_arch": [32]}, "device": "cpu",
    }  # fmt: skip
    iql = IQL(LocalQPolicy, make_vec_env(scenario, NUM_GAMES), **settings).learn(30 * NUM_GAMES)
    dqn = DQN(LocalQPolicy, LocalOnly(make_vec_env(scenario, NUM_GAMES)), **settings).learn(30 * NUM_GAMES)
    for model in (iql, dqn):
        np.random.seed(0)
        for _ in range(10):
            model.train(3, 32)
            model._on_step()
    np.testing.assert_array_equal(network(iql.learners[0]), network(dqn))
    assert iql._n_updates == dqn._n_updates == 30
    assert iql.exploration_rate == dqn.exploration_rate


def test_the_target_networks_follow_every_so_many_env_steps() -> None:
    for kind in ({}, {"share_parameters": True}):
        model = learner(target_update_interval=5 * NUM_GAMES, learning_starts=0, train_freq=1, **kind)
        for vector_steps, same in ((4, False), (5, True), (6, False)):
            model.learn(vector_steps * VECTOR - model.num_timesteps, reset_num_timesteps=False)
            one = model.learners[0]
            one.policy.set_training_mode(False)
            # At the fifth step the copy is made before that step's update.
            lag = [a - b for a, b in zip(one.q_net.parameters(), one.q_net_target.parameters(), strict=True)]
            moved = max(tensor.abs().max().item() for tensor in lag)
            assert (moved < 1.5e-3) == same  # one Adam step of 1e-3, not several


@pytest.mark.parametrize("kind", KINDS)
def test_buffer_size_is_in_env_steps(kind: dict[str, bool]) -> None:
    model = learner(buffer_size=400, **kind)
    rows = [one.replay_buffer.buffer_size * one.n_envs for one in model.learners]  # type: ignore[union-attr]
    assert sum(rows) == N * 400


def test_no_update_before_learning_starts_in_env_steps() -> None:
    model = learner(learning_starts=10 * NUM_GAMES, train_freq=1)
    before = parameters(model)
    model.learn(10 * VECTOR)
    np.testing.assert_array_equal(parameters(model), before)
    model.learn(VECTOR, reset_num_timesteps=False)
    assert not np.array_equal(parameters(model), before)


@pytest.mark.parametrize("kind", KINDS)
def test_a_gradient_step_for_every_transition_a_learner_got(kind: dict[str, bool]) -> None:
    model = learner(gradient_steps=-1, learning_starts=0, train_freq=2, **kind).learn(2 * VECTOR)
    assert model._n_updates == 2 * VECTOR // len(model.learners)


def test_the_learning_rate_of_every_learner_follows_the_progress() -> None:
    model = learner(learning_rate=lambda progress: 1e-3 * progress)
    model.learn(40 * VECTOR)
    rates = [one.policy.optimizer.param_groups[0]["lr"] for one in model.learners]
    assert rates == pytest.approx([0.0] * N, abs=1e-9)


def test_the_log_has_the_mean_of_the_learners() -> None:
    model = learner(learning_starts=10**6).learn(20 * VECTOR)
    model.set_logger(Logger(None, []))
    model.train(2, 32)
    losses = [one.logger.name_to_value["train/loss"] for one in model.learners]
    assert model.logger.name_to_value["train/loss"] == pytest.approx(np.mean(losses))
    assert model.logger.name_to_value["train/n_updates"] == 2


# --- exploration ---------------------------------------------------------------------------------------------------


def test_every_slot_draws_epsilon_for_itself() -> None:
    model, flat = learner(), np.repeat(some_observations(N), 200, axis=0)
    greedy, num_actions = np.array(acts(model, flat)), model.action_space.n  # type: ignore[attr-defined]
    model.exploration_rate = 0.5
    explored = [np.mean(model.predict(flat)[0] != greedy) for _ in range(10)]
    expected, spread = 0.5 * (1 - 1 / num_actions), np.sqrt(0.25 / len(flat))
    assert all(abs(share - expected) < 5 * spread for share in explored)


def test_greedy_play_draws_nothing_and_epsilon_one_is_uniform() -> None:
    model, flat = learner(), np.tile(some_observations(N), (2000, 1))
    model.exploration_rate = 1.0
    assert acts(model, flat) == acts(model, flat)
    drawn = model.predict(flat)[0]
    counts = np.bincount(drawn, minlength=63)
    assert counts.min() > 0
    assert np.abs(counts - len(flat) / 63).max() < 6 * np.sqrt(len(flat) / 63)


def test_epsilon_falls_over_its_share_of_the_training() -> None:
    seen: list[float] = []

    def watch(local: dict[str, Any], _: dict[str, Any]) -> bool:
        seen.append(local["self"].exploration_rate)  # as it was when the step's actions were drawn
        return True

    model = learner(exploration_fraction=0.5, exploration_initial_eps=0.8, exploration_final_eps=0.2)
    model.learn(8 * VECTOR, callback=watch)
    assert seen == pytest.approx([0.0, 0.65, 0.5, 0.35, 0.2, 0.2, 0.2, 0.2])  # the first step is random play


# --- save and load -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=KINDS, ids=lambda kind: next(iter(kind), "vanilla"))
def trained(request: pytest.FixtureRequest) -> IQL:
    return learner(**request.param).learn(30 * VECTOR)


@pytest.fixture(scope="module")
def saved(trained: IQL, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("iql") / "model.zip"
    trained.save(path)
    return path


def test_a_loaded_model_acts_the_same(trained: IQL, saved: Path) -> None:
    loaded, flat = IQL.load(saved, device="cpu"), some_observations()
    assert len(set(acts(trained, flat))) > 1
    assert acts(loaded, flat) == acts(trained, flat)
    np.testing.assert_array_equal(parameters(loaded), parameters(trained))
    assert type(loaded.learners[0]) is type(trained.learners[0])
    assert len(loaded.learners) == len(trained.learners)
    actions = []
    for model in (trained, loaded):  # epsilon is saved too
        np.random.seed(0)
        actions.append(model.predict(flat)[0])
    np.testing.assert_array_equal(*actions)


def test_models_act_the_same_in_a_fresh_process(tmp_path: Path) -> None:
    flat, expected = some_observations(), []
    np.save(tmp_path / "flat.npy", flat)
    for number, kind in enumerate(KINDS):
        model = learner(**kind).learn(10 * VECTOR)
        model.save(tmp_path / f"{number}.zip")
        expected.append(acts(model, flat))
    code = (
        "import sys, numpy as np; from lawn_sb3.algos.iql import IQL; flat = np.load(sys.argv[1]); "
        "models = [IQL.load(path, device='cpu') for path in sys.argv[2:]]; "
        "print([model.predict(flat, deterministic=True)[0].tolist() for model in models])"
    )
    files = [str(tmp_path / name) for name in ("flat.npy", "0.zip", "1.zip", "2.zip")]
    command = [sys.executable, "-c", code, *files]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == str(expected)


def test_weights_alone_make_a_fresh_model_act_the_same(trained: IQL, saved: Path) -> None:
    _, weights, _ = load_from_zip_file(saved, load_data=False, device="cpu")
    fresh = learner(seed=1, double_q=trained.double_q, share_parameters=trained.share_parameters)
    fresh.set_parameters(weights, device="cpu")
    assert acts(fresh, some_observations()) == acts(trained, some_observations())


def test_no_network_hides_in_the_pickled_settings(saved: Path) -> None:
    settings, _, _ = load_from_zip_file(saved, device="cpu")
    assert settings is not None
    assert not {"learners", "replay_buffer", "policy"} & set(settings)
    assert not any(isinstance(value, th.nn.Module) for value in settings.values())


def test_a_loaded_model_learns_on_with_its_optimisers_and_counters(trained: IQL, saved: Path) -> None:
    loaded = IQL.load(saved, env=small_env(), device="cpu")
    for one, other in zip(loaded.learners, trained.learners, strict=True):
        assert (one._n_calls, one._n_updates) == (other._n_calls, other._n_updates)
        moments = [m.policy.optimizer.state_dict()["state"][0]["exp_avg"] for m in (one, other)]
        assert moments[0].equal(moments[1])
    assert loaded.learning_starts == trained.learning_starts
    before = parameters(loaded)
    loaded.learn(10 * VECTOR, reset_num_timesteps=False)
    assert loaded.num_timesteps == trained.num_timesteps + 10 * VECTOR
    assert not np.array_equal(parameters(loaded), before)


def test_a_policy_is_saved_and_loaded_on_its_own_as_in_sb3(trained: IQL, tmp_path: Path) -> None:
    trained.policy.save(tmp_path / "policy.zip")
    loaded = IndependentPolicy.load(tmp_path / "policy.zip", device="cpu")
    assert acts(loaded, some_observations()) == acts(trained, some_observations())


def test_replays_are_saved_and_loaded_as_in_sb3(trained: IQL, tmp_path: Path) -> None:
    trained.save_replay_buffer(tmp_path / "replay.pkl")
    other = learner(share_parameters=trained.share_parameters)
    other.load_replay_buffer(tmp_path / "replay.pkl")
    for one, two in zip(other.learners, trained.learners, strict=True):
        assert one.replay_buffer is not None
        assert two.replay_buffer is not None
        assert one.replay_buffer.size() == two.replay_buffer.size() > 0
        np.testing.assert_array_equal(one.replay_buffer.observations, two.replay_buffer.observations)


def test_memory_is_as_long_as_what_is_remembered(trained: IQL) -> None:
    for content, one in zip(trained.memory()["replays"], trained.learners, strict=True):
        assert set(content["arrays"]) == {
            "observations", "next_observations", "actions", "rewards", "dones", "timeouts",
        }  # fmt: skip
        assert {len(array) for array in content["arrays"].values()} == {30}
        assert content["pos"] == one.replay_buffer.pos  # type: ignore[union-attr]


# --- options and refusals ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_one_seed_trains_one_model(kind: dict[str, bool]) -> None:
    one, again = learner(**kind).learn(30 * VECTOR), learner(**kind).learn(30 * VECTOR)
    np.testing.assert_array_equal(parameters(one), parameters(again))
    assert not np.array_equal(parameters(one), parameters(learner(seed=1, **kind).learn(30 * VECTOR)))


@pytest.mark.parametrize("kind", KINDS)
def test_a_single_uav_in_a_single_game_works(kind: dict[str, bool]) -> None:
    env = make_vec_env(SMALL.changed(num_uavs=1), 1)
    model = learner(env, **kind).learn(200)
    observation = np.asarray(env.reset())
    assert model.predict(observation)[0].shape == (1,)
    assert model.predict(observation[0])[0].shape == ()


def test_a_shared_network_sees_who_asks() -> None:
    model = learner(share_parameters=True)
    assert len(model.learners) == 1
    flat = np.repeat(some_observations(1), 2 * N, axis=0)
    seen = model.policy.views.observe(0, th.as_tensor(flat))
    np.testing.assert_array_equal(seen[:, : model.layout.local_dim], flat[:, model.layout.local])
    np.testing.assert_array_equal(seen[:, model.layout.local_dim :], np.tile(np.eye(N), (2, 1)))
    model.learn(20 * VECTOR)
    assert model.learners[0].replay_buffer.size() * model.learners[0].n_envs == 20 * VECTOR  # type: ignore[union-attr]


def test_multi_step_returns_are_sb3_s() -> None:
    model = learner(n_steps=3).learn(30 * VECTOR)
    names = {type(one.replay_buffer).__name__ for one in model.learners}
    assert names == {"NStepReplayBuffer"}
    assert len(model.memory()["replays"]) == N


def test_rows_that_are_no_whole_games_are_refused() -> None:
    with pytest.raises(ValueError, match="3 observations are no whole games of 2 UAVs"):
        learner().predict(some_observations(3))


def test_environments_it_cannot_learn_in_are_refused() -> None:
    with pytest.raises(ValueError, match="layout"):
        IQL("MlpPolicy", "CartPole-v1", device="cpu")
    with pytest.raises(ValueError, match="VecNormalize"):
        learner(VecNormalize(small_env()))


def test_games_of_other_sizes_are_refused_though_the_vector_is_as_long(saved: Path) -> None:
    other = make_vec_env(PRESETS["paper"].changed(num_uavs=1, gbs_grid=[5, 1]), NUM_GAMES)
    assert other.observation_space == small_env().observation_space
    with pytest.raises(ValueError, match="num_uavs=2, num_gbs=4"):
        IQL.load(saved, env=other, device="cpu")


# --- it learns -----------------------------------------------------------------------------------------------------


def success_rate(model: IQL | None, num_games: int = 100) -> float:
    """Share of UAVs that arrive, over joint episodes on the same missions for everybody; no model plays at random."""
    env = make_vec_env(PRESETS["paper"], num_games, seed=1234, continuation="episode")
    observations: Any = env.reset()
    rng = np.random.default_rng(0)
    arrived, done = np.zeros(env.num_envs, dtype=bool), np.zeros(env.num_envs, dtype=bool)
    while not done.all():
        actions = rng.integers(63, size=env.num_envs) if model is None else model.predict(observations)[0]
        observations, _, dones, infos = env.step(actions)
        for k in np.flatnonzero(dones & ~done):
            arrived[k] = infos[k]["is_success"]
        done |= dones
    return float(arrived.mean())


@pytest.mark.slow
def test_a_short_training_beats_random_play() -> None:
    model = IQL(
        LocalQPolicy, make_vec_env(PRESETS["paper"], 32), learning_rate=1e-3, buffer_size=10_000, learning_starts=500,
        batch_size=128, gamma=0.85, train_freq=1, gradient_steps=2, target_update_interval=1600,
        exploration_fraction=0.3, policy_kwargs={"net_arch": [128, 128]}, seed=0, device="cpu",
    )  # fmt: skip
    model.learn(10_000 * 4)
    random, learned = success_rate(None), success_rate(model)
    assert 0.1 < random < 0.35  # the paper's Table II: 22.4 %
    assert learned > random + 0.3
