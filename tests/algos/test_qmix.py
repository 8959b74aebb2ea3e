import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch as th
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.save_util import load_from_zip_file
from stable_baselines3.common.vec_env import VecNormalize
from torch.nn import functional

from lawn_sb3.algos.qmix import QMIX, JointReplayBuffer, JointSamples, QMIXPolicy
from lawn_sb3.envs import make_vec_env
from lawn_sb3.scenario import PRESETS
from policies.additive_mixer import AdditiveMixerPolicy
from policies.centralized_critic import CentralizedCriticPolicy
from policies.monotonic_mixer import MonotonicMixerPolicy
from tests.algos.games import STEP, Countdown, MatrixGame, team, whole_games
from tests.algos.small import NUM_GAMES, SMALL, parameters, small_env, some_observations

ROOT = Path(__file__).parents[2]
MIXERS = [MonotonicMixerPolicy, AdditiveMixerPolicy]


def acts(model: Any, observations: np.ndarray) -> list[int]:
    """Greedy actions."""
    actions: list[int] = model.predict(observations, deterministic=True)[0].tolist()
    return actions


# --- matrix games --------------------------------------------------------------------------------------------------

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


def mixed_payoffs(model: QMIX) -> np.ndarray:
    """The value of each joint action."""
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


@pytest.mark.parametrize("policy", MIXERS)
def test_qmix_misses_the_optimum_of_a_payoff_that_is_not_monotonic(policy: Any) -> None:
    model = matrix_player(NOT_MONOTONIC, policy)
    assert joint_action(model) != (0, 0)
    assert NOT_MONOTONIC[joint_action(model)[0]][joint_action(model)[1]] == 0.0
    assert mixed_payoffs(model)[0, 0] < 4.0  # it cannot even hold it


# --- the update ----------------------------------------------------------------------------------------------------


def a_batch(model: QMIX, **changes: Any) -> JointSamples:
    """What the small games gave."""
    return model.replay_buffer.sample(64)._replace(**changes)


def by_hand(model: QMIX, batch: JointSamples) -> th.Tensor:
    """Targets, one game and one UAV after the other."""
    policy, targets = model.policy, []
    for g in range(len(batch.rewards)):
        chosen = th.zeros(1, 2)
        for i in range(2):
            if batch.next_flying[g, i]:
                own, theirs = policy.q_net(batch.next_local[g, i]), policy.q_net_target(batch.next_local[g, i])
                chosen[0, i] = theirs[(own if model.double_q else theirs).argmax()]
        value = 0.0 if batch.game_over[g] else policy.mixer_target(chosen, batch.next_state[g : g + 1])[0]
        targets.append(batch.rewards[g] + model.gamma * value)
    return th.stack(targets)


@pytest.mark.parametrize("double_q", [True, False])
def test_targets_are_team_reward_and_the_target_mix_of_those_who_fly_on(double_q: bool) -> None:
    model = team(double_q=double_q, target_update_interval=30, gamma=0.9, learning_rate=1e-2).learn(100 * STEP)
    batch = a_batch(model)
    assert batch.next_flying.any(dim=1).logical_not().any()  # some games are over
    assert (batch.next_flying.sum(dim=1) == 1).any()  # in some one UAV has arrived
    with th.no_grad():
        assert model.target_values(batch).allclose(by_hand(model, batch), atol=1e-5)
    other = team(double_q=not double_q)
    other.policy.load_state_dict(model.policy.state_dict())
    other.gamma = model.gamma
    assert not other.target_values(batch).allclose(model.target_values(batch), atol=1e-5)


def test_a_game_that_is_over_is_worth_its_reward_alone() -> None:
    model = team(gamma=0.9).learn(30 * STEP)
    nobody, over = th.zeros(64, 2, dtype=th.bool), th.ones(64)
    batch = a_batch(model, next_flying=nobody, game_over=over)
    assert model.target_values(batch).equal(batch.rewards)


def test_one_update_is_a_clipped_step_down_the_huber_loss() -> None:
    settings: dict[str, Any] = {"learning_rate": 0.5, "max_grad_norm": 0.01, "target_update_interval": 10_000}
    settings["policy_kwargs"] = {"net_arch": [16], "optimizer_class": th.optim.SGD}
    model = team(learning_starts=10_000, **settings).learn(40 * STEP)
    state = np.random.get_state()
    batch = model.replay_buffer.sample(32)
    twin = team(**settings)
    twin.policy.load_state_dict(model.policy.state_dict())
    values = twin.policy.game_values(batch.local, batch.state, batch.actions, batch.flying)
    functional.huber_loss(values, model.target_values(batch)).backward()  # type: ignore[no-untyped-call]
    gradient = th.cat([parameter.grad.ravel() for parameter in twin.policy.trained_parameters()])  # type: ignore[union-attr]
    assert gradient.norm() > 0.01
    before = th.cat([parameter.detach().ravel() for parameter in model.policy.trained_parameters()])
    np.random.set_state(state)
    model._update_current_progress_remaining(0, 1)
    model.train(gradient_steps=1, batch_size=32)
    after = th.cat([parameter.detach().ravel() for parameter in model.policy.trained_parameters()])
    assert (after - before).allclose(-0.5 * 0.01 * gradient / gradient.norm(), atol=1e-6)


def test_targets_stand_still_between_their_updates_and_copy_then() -> None:
    model = team(target_update_interval=10, learning_starts=STEP).learn(5 * STEP)

    def gap() -> float:
        pairs = zip(model.policy.trained_parameters(), model.policy.target_parameters(), strict=True)
        return max((mine - theirs).abs().max().item() for mine, theirs in pairs)

    before = [parameter.clone() for parameter in model.policy.target_parameters()]
    done = model._n_updates
    model.train(9 - done, 32)
    assert all(a.equal(b) for a, b in zip(before, model.policy.target_parameters(), strict=True))
    assert gap() > 0.0
    model.train(1, 32)
    assert gap() == 0.0


def test_tau_moves_the_targets_part_of_the_way() -> None:
    model = team(target_update_interval=1, tau=0.25, learning_starts=10_000).learn(20 * STEP)
    before = [parameter.clone() for parameter in model.policy.target_parameters()]
    model.train(1, 32)
    triples = zip(before, model.policy.trained_parameters(), model.policy.target_parameters(), strict=True)
    for old, trained, new in triples:
        assert new.allclose(0.75 * old + 0.25 * trained, atol=1e-6)


# --- playing -------------------------------------------------------------------------------------------------------


def test_acting_reads_o_i_alone() -> None:
    model, flat = team().learn(30 * STEP), some_observations(200)
    columns = model.policy.layout.state
    elsewhere = flat.copy()
    elsewhere[:, columns] = np.random.default_rng(0).normal(size=elsewhere[:, columns].shape)
    assert len(set(acts(model, flat))) > 1
    assert acts(model, elsewhere) == acts(model, flat)


def test_every_uav_tosses_its_own_coin() -> None:
    model, flat = team(), some_observations(1)
    many = flat.repeat(20_000, axis=0)
    greedy = acts(model, flat)[0]
    model.exploration_rate = 0.3
    np.random.seed(0)
    share = np.mean(model.predict(many)[0] != greedy)
    assert share == pytest.approx(0.3 * 62 / 63, abs=0.02)
    assert acts(model, many) == [greedy] * len(many)


class Seen(BaseCallback):
    """Exploration, learning rate and number of updates at each vector step."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[tuple[float, float, int]] = []

    def _on_step(self) -> bool:
        assert isinstance(self.model, QMIX)
        rate = self.model.policy.optimizer.param_groups[0]["lr"]
        self.rows.append((self.model.exploration_rate, rate, self.model._n_updates))
        return True


def test_exploration_falls_and_the_learning_rate_anneals_with_their_schedules() -> None:
    seen = Seen()
    model = team(exploration_fraction=0.5, exploration_final_eps=0.1, learning_rate=lambda left: 1e-3 * left)
    model.learn(20 * STEP, callback=seen)
    exploration, rates, updates = (np.array(column) for column in zip(*seen.rows, strict=True))
    np.testing.assert_allclose(exploration, np.maximum(1.0 - 0.9 * np.arange(20) / 10, 0.1))
    np.testing.assert_allclose(rates[5:], 1e-3 * (1 - np.arange(5, 20) / 20))
    assert updates.tolist() == [0] * 5 + list(range(1, 16))  # the first four vector steps are played at random


def test_one_seed_trains_one_team() -> None:
    one, again = team().learn(30 * STEP), team().learn(30 * STEP)
    np.testing.assert_array_equal(parameters(one), parameters(again))
    assert not np.array_equal(parameters(one), parameters(team(seed=1).learn(30 * STEP)))


def test_the_replay_starts_anew_with_the_environment() -> None:
    env = Countdown()
    model = team(env=env, learning_starts=10_000, buffer_size=600)
    model.learn(12)
    assert not model.replay_buffer.now_flying.all()
    model.learn(6)  # one slot of the second game: UAVs that fly for two are still up
    np.testing.assert_array_equal(model.replay_buffer.now_flying, env.clock.slot[:, None] < env.duration)


def test_the_replay_knows_who_flies_when_learning_goes_on() -> None:
    env = Countdown()
    model = team(env=env, learning_starts=10_000, buffer_size=600)
    for slots in (1, 3, 2):
        model.learn(6 * slots, reset_num_timesteps=False)
        np.testing.assert_array_equal(model.replay_buffer.now_flying, env.clock.slot[:, None] < env.duration)


def test_a_training_stopped_by_a_callback_goes_on_with_whole_games() -> None:
    env = Countdown()
    model = team(env=env, learning_starts=10_000, buffer_size=600)
    model.learn(60, callback=lambda local, _: local["num_collected_steps"] < 1)
    model.learn(24, reset_num_timesteps=False)
    np.testing.assert_array_equal(model.replay_buffer.now_flying, env.clock.slot[:, None] < env.duration)


# --- save and load -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=MIXERS)
def trained(request: pytest.FixtureRequest) -> QMIX:
    return team(request.param).learn(40 * STEP)


@pytest.fixture(scope="module")
def saved(trained: QMIX, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("qmix") / "model.zip"
    trained.save(path)
    return path


def test_a_loaded_team_acts_the_same(trained: QMIX, saved: Path) -> None:
    loaded, observations = QMIX.load(saved, device="cpu"), some_observations()
    assert len(set(acts(trained, observations))) > 1
    assert acts(loaded, observations) == acts(trained, observations)
    np.testing.assert_array_equal(parameters(loaded), parameters(trained))
    assert isinstance(loaded.policy, type(trained.policy))
    assert loaded.exploration_rate == trained.exploration_rate


def test_a_team_acts_the_same_in_a_fresh_process(trained: QMIX, saved: Path, tmp_path: Path) -> None:
    observations = some_observations()
    np.save(tmp_path / "observations.npy", observations)
    code = (
        "import sys, numpy as np; from lawn_sb3.algos.qmix import QMIX; "
        "model = QMIX.load(sys.argv[1], device='cpu'); "
        "print(model.predict(np.load(sys.argv[2]), deterministic=True)[0].tolist())"
    )
    command = [sys.executable, "-c", code, str(saved), str(tmp_path / "observations.npy")]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert result.stdout.strip() == str(acts(trained, observations))


def test_the_saved_file_holds_weights_as_tensors_and_no_replay(trained: QMIX, saved: Path) -> None:
    settings, tensors, _ = load_from_zip_file(saved, device="cpu")
    assert settings is not None
    assert not any(isinstance(value, th.nn.Module | JointReplayBuffer) for value in settings.values())
    assert set(tensors["policy"]) == set(trained.policy.state_dict())
    assert saved.stat().st_size < 2_000_000


def test_a_loaded_team_learns_on(trained: QMIX, saved: Path) -> None:
    loaded = QMIX.load(saved, env=whole_games(), device="cpu")
    before = parameters(loaded)
    loaded.learn(10 * STEP, reset_num_timesteps=False)
    assert loaded.num_timesteps == trained.num_timesteps + 10 * STEP
    assert not np.array_equal(parameters(loaded), before)


def test_the_replay_is_saved_and_loaded_on_its_own_as_in_sb3(trained: QMIX, tmp_path: Path) -> None:
    trained.save_replay_buffer(tmp_path / "replay.pkl")
    other = team(type(trained.policy))
    other.load_replay_buffer(tmp_path / "replay.pkl")
    assert other.replay_buffer.size() == trained.replay_buffer.size()
    np.testing.assert_array_equal(other.replay_buffer.observations, trained.replay_buffer.observations)


def test_a_policy_is_saved_and_loaded_on_its_own_as_in_sb3(trained: QMIX, tmp_path: Path) -> None:
    trained.policy.save(str(tmp_path / "policy.pt"))
    loaded, observations = type(trained.policy).load(str(tmp_path / "policy.pt"), device="cpu"), some_observations()
    assert loaded.predict(observations)[0].tolist() == acts(trained, observations)


# --- what it refuses -----------------------------------------------------------------------------------------------


def test_missions_that_are_renewed_one_by_one_are_refused() -> None:
    with pytest.raises(ValueError, match="needs continuation='episode'") as refusal:
        team(env=small_env())
    assert "\n" not in str(refusal.value)
    with pytest.raises(ValueError, match="needs continuation='episode'"):
        team().set_env(small_env())


def test_environments_and_policies_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ValueError, match="VecNormalize"):
        team(env=VecNormalize(whole_games()))
    with pytest.raises(ValueError, match="layout, from make_vec_env"):
        QMIX(MonotonicMixerPolicy, "CartPole-v1")
    with pytest.raises(ValueError, match="derived from QMIXPolicy"):
        team(CentralizedCriticPolicy)
    with pytest.raises(NotImplementedError, match=r"QMIXPolicy .* override make_mixer"):
        team(QMIXPolicy)


def test_policy_kwargs_given_by_the_caller_are_left_alone() -> None:
    policy_kwargs = {"net_arch": [16]}
    team(policy_kwargs=policy_kwargs)
    assert policy_kwargs == {"net_arch": [16]}


# --- it learns -----------------------------------------------------------------------------------------------------


def success_rate(model: QMIX | None, num_games: int = 100) -> float:
    """Share of UAVs that arrive when greedy, on the same missions for everybody; no model plays at random."""
    env = make_vec_env(PRESETS["paper"], num_games, seed=1234, continuation="episode")
    observations, rng = env.reset(), np.random.default_rng(0)
    arrived, done = np.zeros(env.num_envs, dtype=bool), np.zeros(env.num_envs, dtype=bool)
    while not done.all():
        if model is None:
            actions = rng.integers(env.action_space.n, size=env.num_envs)  # type: ignore[attr-defined]
        else:
            actions = model.predict(observations, deterministic=True)[0]  # type: ignore[arg-type]
        observations, _, dones, infos = env.step(actions)
        for k in np.flatnonzero(dones & ~done):
            arrived[k] = infos[k]["is_success"]
        done |= dones
    return float(arrived.mean())


@pytest.mark.slow
@pytest.mark.parametrize("policy", MIXERS)
def test_a_short_training_beats_random_play(policy: Any) -> None:
    env = make_vec_env(PRESETS["paper"], 32, continuation="episode")
    model = QMIX(
        policy, env, learning_rate=1e-3, gamma=0.85, exploration_fraction=0.5, batch_size=128, seed=0, device="cpu",
        policy_kwargs={"net_arch": [64, 64]}, target_update_interval=100,
    )  # fmt: skip
    model.learn(600 * 32 * 4)
    assert success_rate(model) > success_rate(None) + 0.3


def test_the_small_games_have_the_size_the_tests_count_with() -> None:
    assert whole_games().num_envs == STEP == NUM_GAMES * SMALL.num_uavs
