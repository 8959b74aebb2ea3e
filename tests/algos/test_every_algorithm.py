"""What holds for every algorithm: one seed, one model; models are saved and loaded whole; actors read o_i alone."""

import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import torch as th
from sb3_contrib import QRDQN
from stable_baselines3.common.save_util import load_from_zip_file

from lawn_sb3.algos.iql import IQL
from lawn_sb3.algos.mappo import MAPPO
from lawn_sb3.algos.qmix import QMIX
from lawn_sb3.envs import make_vec_env
from lawn_sb3.scenario import PRESETS
from policies.additive_mixer import AdditiveMixerPolicy
from policies.centralized_critic import CentralizedCriticPolicy
from policies.local_q import LocalQPolicy
from policies.monotonic_mixer import MonotonicMixerPolicy
from policies.quantile_q import QuantileQPolicy
from policies.state_critic import StateCriticPolicy
from tests.algos.small import (
    N_STEPS,
    ROLLOUT,
    VECTOR,
    acts,
    independent,
    learner,
    parameters,
    replaced,
    small_env,
    some_observations,
    team,
    whole_games,
)

ROOT = Path(__file__).parents[2]
QUANTILES = {"policy": QuantileQPolicy, "policy_kwargs": {"net_arch": [32], "n_quantiles": 4}}


class Case(NamedTuple):
    """A small learner, and how long it is trained."""

    build: Callable[..., Any]
    settings: dict[str, Any]
    steps: int = 30 * VECTOR

    def untrained(self, **changes: Any) -> Any:
        return self.build(**{**self.settings, **changes})

    def trained(self, **changes: Any) -> Any:
        return self.untrained(**changes).learn(self.steps)


CASES = {
    "mappo": Case(learner, {"ent_coef": 0.01}, 3 * ROLLOUT),
    "mappo-state": Case(learner, {"policy": StateCriticPolicy}, 3 * ROLLOUT),
    "iql": Case(independent, {}),
    "iql-double": Case(independent, {"double_q": True}),
    "iql-shared": Case(independent, {"share_parameters": True}),
    "iql-quantiles": Case(independent, QUANTILES),
    "iql-shared-quantiles": Case(independent, {**QUANTILES, "share_parameters": True}),
    "iql-n-step": Case(independent, {**QUANTILES, "n_steps": 3}),
    "qmix": Case(team, {}, 40 * VECTOR),
    "qmix-additive": Case(team, {"policy": AdditiveMixerPolicy}, 40 * VECTOR),
}


@pytest.fixture(scope="module", params=CASES)
def case(request: pytest.FixtureRequest) -> Case:
    return CASES[request.param]


@pytest.fixture(scope="module")
def trained(case: Case) -> Any:
    return case.trained()


def test_no_mission_counts_before_the_first_deadline_when_only_successful_ones_can_have_ended(
    case: Case, trained: Any
) -> None:
    early = case.untrained().learn(N_STEPS * VECTOR)
    assert early.env.get_attr("scenario")[0].max_slots >= N_STEPS
    assert not early.ep_info_buffer
    assert not early.ep_success_buffer
    assert trained.ep_info_buffer
    assert False in trained.ep_success_buffer


@pytest.fixture(scope="module")
def saved(trained: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("saved") / "model.zip"
    trained.save(path)
    return path


def test_one_seed_trains_one_model(case: Case, trained: Any) -> None:
    np.testing.assert_array_equal(parameters(case.trained()), parameters(trained))
    assert not np.array_equal(parameters(case.trained(seed=1)), parameters(trained))
    assert not np.array_equal(parameters(case.untrained()), parameters(trained))


def test_the_global_state_never_changes_an_action_but_the_own_observation_does(trained: Any) -> None:
    flat, layout = some_observations(), trained.env.get_attr("layout", [0])[0]
    assert acts(trained, replaced(flat, layout.state)) == acts(trained, flat)
    assert acts(trained, replaced(flat, layout.local)) != acts(trained, flat)


def test_a_loaded_model_acts_the_same(trained: Any, saved: Path) -> None:
    loaded, flat = type(trained).load(saved, device="cpu"), some_observations()
    assert len(set(acts(trained, flat))) > 1
    assert acts(loaded, flat) == acts(trained, flat)
    np.testing.assert_array_equal(parameters(loaded), parameters(trained))
    assert isinstance(loaded.policy, type(trained.policy))
    explored = []
    for model in (trained, loaded):  # the rate of exploration is saved too
        np.random.seed(0)
        th.manual_seed(0)
        explored.append(model.predict(flat)[0].tolist())
    assert explored[0] == explored[1]


def test_models_act_the_same_in_a_fresh_process(tmp_path: Path) -> None:
    flat, expected = some_observations(), []
    np.save(tmp_path / "flat.npy", flat)
    for name, case in CASES.items():
        model = case.trained()
        model.save(tmp_path / f"{name}.zip")
        expected.append(acts(model, flat))
    code = (
        "import sys, numpy as np; from lawn_sb3.algos.iql import IQL; from lawn_sb3.algos.mappo import MAPPO; "
        "from lawn_sb3.algos.qmix import QMIX; flat = np.load(sys.argv[1]); "
        "kinds = {'i': IQL, 'm': MAPPO, 'q': QMIX}; "
        "models = [kinds[path.rpartition('/')[2][0]].load(path, device='cpu') for path in sys.argv[2:]]; "
        "print([model.predict(flat, deterministic=True)[0].tolist() for model in models])"
    )
    files = [str(tmp_path / name) for name in ("flat.npy", *(f"{name}.zip" for name in CASES))]
    command = [sys.executable, "-c", code, *files]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == str(expected)


def test_the_saved_file_holds_weights_as_tensors_and_neither_networks_nor_replays(trained: Any, saved: Path) -> None:
    """Weights can be read without unpickling code."""
    settings, tensors, _ = load_from_zip_file(saved, device="cpu")
    assert settings is not None
    assert not {"learners", "replay_buffer", "rollout_buffer", "policy", "_value_head"} & set(settings)
    assert not any(isinstance(value, th.nn.Module) for value in settings.values())
    weights = load_from_zip_file(saved, load_data=False, device="cpu")[1]["policy"]
    assert set(weights) == set(tensors["policy"]) == set(trained.policy.state_dict())
    assert saved.stat().st_size < 2_000_000


def test_weights_alone_make_a_fresh_model_act_the_same(case: Case, trained: Any, saved: Path) -> None:
    _, weights, _ = load_from_zip_file(saved, load_data=False, device="cpu")
    fresh = case.untrained(seed=1)
    fresh.set_parameters(weights, device="cpu")
    assert acts(fresh, some_observations()) == acts(trained, some_observations())


def test_a_loaded_model_learns_on_with_its_counters(case: Case, trained: Any, saved: Path) -> None:
    loaded = type(trained).load(saved, env=case.untrained().env, device="cpu")
    before, counted = parameters(loaded), loaded._n_updates
    assert counted == trained._n_updates > 0
    loaded.learn(ROLLOUT, reset_num_timesteps=False)
    assert loaded.num_timesteps == trained.num_timesteps + ROLLOUT
    assert loaded._n_updates > counted
    assert not np.array_equal(parameters(loaded), before)


def test_a_policy_is_saved_and_loaded_on_its_own_as_in_sb3(trained: Any, tmp_path: Path) -> None:
    trained.policy.save(str(tmp_path / "policy.zip"))
    loaded = type(trained.policy).load(str(tmp_path / "policy.zip"), device="cpu")
    assert acts(loaded, some_observations()) == acts(trained, some_observations())


@pytest.mark.parametrize("name", [name for name, case in CASES.items() if case.build is not learner])
def test_replays_are_saved_and_loaded_as_in_sb3(name: str, tmp_path: Path) -> None:
    def replays(model: Any) -> list[Any]:
        return [one.replay_buffer for one in model.learners] if isinstance(model, IQL) else [model.replay_buffer]

    trained, other = CASES[name].trained(), CASES[name].untrained()
    trained.save_replay_buffer(tmp_path / "replay.pkl")
    other.load_replay_buffer(tmp_path / "replay.pkl")
    for one, same in zip(replays(other), replays(trained), strict=True):
        assert one.size() == same.size() > 0
        np.testing.assert_array_equal(one.observations, same.observations)


@pytest.mark.parametrize("build", [learner, independent, team])
def test_policy_kwargs_given_by_the_caller_are_left_alone(build: Callable[..., Any]) -> None:
    policy_kwargs = {"net_arch": [16]}
    build(policy_kwargs=policy_kwargs)
    assert policy_kwargs == {"net_arch": [16]}


@pytest.mark.parametrize(
    ("build", "name"), [(independent, "optimize_memory_usage"), (team, "optimize_memory_usage"), (team, "n_steps")]
)
def test_settings_that_mean_nothing_are_refused(build: Callable[..., Any], name: str) -> None:
    with pytest.raises(TypeError, match=f"takes no {name}"):
        build(**{name: True})


def test_settings_may_be_given_by_position_as_to_sb3() -> None:
    assert learner().learning_rate == 3e-4
    assert MAPPO(CentralizedCriticPolicy, learner().env, 2e-3, 32, device="cpu").n_steps == 32
    one = IQL(QuantileQPolicy, independent().env, 2e-3, 300, device="cpu").learners[0]
    assert isinstance(one, QRDQN)
    assert (one.learning_rate, one.exploration_final_eps, one.max_grad_norm) == (2e-3, 0.05, 10)  # DQN's own


def success_rate(model: Any) -> float:
    """Share of UAVs that arrive, on the same missions for everybody; no model plays at random."""
    env: Any = make_vec_env(PRESETS["paper"], 100, seed=1234, continuation="episode")
    observations, rng = env.reset(), np.random.default_rng(0)
    arrived, done = np.zeros(env.num_envs, dtype=bool), np.zeros(env.num_envs, dtype=bool)
    while not done.all():
        drawn = rng.integers(env.action_space.n, size=env.num_envs)
        observations, _, dones, infos = env.step(drawn if model is None else model.predict(observations)[0])
        for k in np.flatnonzero(dones & ~done):
            arrived[k] = infos[k]["is_success"]
        done |= dones
    return float(arrived.mean())


@pytest.fixture(scope="module")
def random_play() -> float:
    return success_rate(None)


@pytest.mark.slow
@pytest.mark.parametrize("policy", [CentralizedCriticPolicy, StateCriticPolicy])
def test_a_short_training_of_mappo_beats_random_play(policy: Any, random_play: float) -> None:
    model = MAPPO(
        policy, make_vec_env(PRESETS["paper"], 32), learning_rate=1e-3, n_steps=32, batch_size=512, n_epochs=4,
        ent_coef=0.01, policy_kwargs={"net_arch": {"pi": [64, 64], "vf": [64, 64]}}, seed=0, device="cpu",
    )  # fmt: skip
    assert 0.1 < random_play < 0.35  # the paper's Table II: 22.4 %
    assert success_rate(model.learn(20 * 32 * 32 * 4)) > random_play + 0.3


@pytest.mark.slow
def test_a_short_training_of_iql_beats_random_play(random_play: float) -> None:
    model = IQL(
        LocalQPolicy, make_vec_env(PRESETS["paper"], 32), learning_rate=1e-3, buffer_size=10_000, learning_starts=500,
        batch_size=128, gamma=0.85, train_freq=1, gradient_steps=2, target_update_interval=1600,
        exploration_fraction=0.3, policy_kwargs={"net_arch": [128, 128]}, seed=0, device="cpu",
    )  # fmt: skip
    assert success_rate(model.learn(10_000 * 4)) > random_play + 0.3


@pytest.mark.slow
@pytest.mark.parametrize("policy", [MonotonicMixerPolicy, AdditiveMixerPolicy])
def test_a_short_training_of_qmix_beats_random_play(policy: Any, random_play: float) -> None:
    model = QMIX(
        policy, make_vec_env(PRESETS["paper"], 32, continuation="episode"), learning_rate=1e-3, gamma=0.85,
        exploration_fraction=0.5, batch_size=128, target_update_interval=100, policy_kwargs={"net_arch": [64, 64]},
        seed=0, device="cpu",
    )  # fmt: skip
    assert success_rate(model.learn(600 * 32 * 4)) > random_play + 0.3


@pytest.mark.parametrize("build", [learner, independent, team])
def test_games_that_go_on_in_another_way_are_refused(build: Callable[..., Any], tmp_path: Path) -> None:
    model, others = build(), small_env() if build is team else whole_games()
    model.save(tmp_path / "model.zip")
    needed = f"needs continuation='{type(model).continuation}'"
    loads = partial(type(model).load, tmp_path / "model.zip", env=others)
    for try_it in (partial(build, env=others), partial(model.set_env, others), loads):
        with pytest.raises(ValueError, match=needed) as refusal:
            try_it()
        assert "\n" not in str(refusal.value)
