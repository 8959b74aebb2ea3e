"""One test for each defect of SuperSuit's flattening that could reach a learner, and SB3's own tools on top of it."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pytest
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecMonitor, VecNormalize

from lawn_sb3.envs import FlatVecEnv, Observer, make_vec_env
from lawn_sb3.game import Simulator
from lawn_sb3.game.simulator import Continuation
from lawn_sb3.scenario import PRESETS

SHORT = PRESETS["paper"].changed(max_slots=8)
PPO_SMALL: dict[str, Any] = {"n_steps": 8, "batch_size": 64, "n_epochs": 1, "device": "cpu"}


class Step(NamedTuple):
    """What a vector step gave."""

    observations: np.ndarray
    rewards: np.ndarray
    dones: np.ndarray
    infos: list[dict[str, Any]]


def play(venv: VecEnv, slots: int, seed: int = 0) -> Iterator[Step]:
    """Random play; the same seed gives the same actions."""
    rng = np.random.default_rng(seed)
    num_actions = venv.action_space.n  # type: ignore[attr-defined]
    for _ in range(slots):
        yield Step(*venv.step(rng.integers(num_actions, size=venv.num_envs)))  # type: ignore[misc]


def assert_same_play(one: VecEnv, other: VecEnv, slots: int = 25) -> None:
    """Reset both and play both alike; everything must be equal."""
    np.testing.assert_array_equal(one.reset(), other.reset())
    for a, b in zip(play(one, slots), play(other, slots), strict=True):
        np.testing.assert_equal(a, b)


def missions_of(venv: VecEnv) -> list[bytes]:
    """The missions of every game in play, as something that can be compared."""
    states = [simulator.state for simulator in dict.fromkeys(venv.get_attr("simulator"))]
    return [
        state.position[g].tobytes() + state.destination[g].tobytes() for state in states for g in range(len(state.slot))
    ]


# --- seeds ---------------------------------------------------------------------------------------------------------


def test_an_sb3_learner_takes_a_seed() -> None:
    def first_games(seed: int) -> list[bytes]:
        model = PPO("MlpPolicy", make_vec_env(SHORT, 2), seed=seed, **PPO_SMALL)
        model.env.reset()  # type: ignore[union-attr]
        return missions_of(model.env)  # type: ignore[arg-type]

    assert first_games(0) == first_games(0)
    assert first_games(0) != first_games(1)


def test_one_seed_gives_equal_play() -> None:
    assert_same_play(make_vec_env(SHORT, 3, copies=2, seed=5), make_vec_env(SHORT, 3, copies=2, seed=5))


def test_two_seeds_give_different_play() -> None:
    one, other = make_vec_env(SHORT, 3, seed=5), make_vec_env(SHORT, 3, seed=6)
    assert not np.array_equal(one.reset(), other.reset())
    for a, b in zip(play(one, 25), play(other, 25), strict=True):
        assert not np.array_equal(a.observations, b.observations)


def test_without_a_seed_no_two_builds_are_alike() -> None:
    one, other = make_vec_env(SHORT, 2), make_vec_env(SHORT, 2)
    assert not np.array_equal(one.reset(), other.reset())


def test_seeding_and_then_a_reset_play_the_same_again() -> None:
    venv, fresh = make_vec_env(SHORT, 2, copies=2, seed=1), make_vec_env(SHORT, 2, copies=2, seed=7)
    venv.reset()
    list(play(venv, 10))
    venv.seed(7)
    assert_same_play(venv, fresh)


def test_a_reset_without_seeding_goes_on_to_new_games() -> None:
    venv = make_vec_env(SHORT, 2, seed=1)
    first = venv.reset().copy()  # type: ignore[union-attr]
    assert not np.array_equal(venv.reset(), first)


@pytest.mark.parametrize("copies", [1, 4])
def test_neighbouring_seeds_share_no_game(copies: int) -> None:
    played: list[set[bytes]] = []
    for seed in range(4):  # SB3 seeds its i-th environment with seed + i, so that these would overlap
        venv = make_vec_env(SHORT, 2, copies=copies)
        venv.seed(seed)
        venv.reset()
        played.append(set(missions_of(venv)))
        assert len(played[-1]) == 2 * copies
    assert len(set.union(*played)) == 4 * 2 * copies


def test_games_inside_one_environment_differ_and_so_do_copies() -> None:
    venv = make_vec_env(SHORT, 3, copies=2, seed=0)
    venv.reset()
    assert len(set(missions_of(venv))) == 6
    for _ in range(20):  # the same action everywhere: only the random streams can tell the games apart
        observations = venv.step(np.zeros(venv.num_envs, dtype=int))[0]
        rows = observations.reshape(6, 4, -1)[:, 0]  # type: ignore[union-attr]
        assert len(np.unique(rows, axis=0)) == 6


# --- ends of missions ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("continuation", ["mission", "episode"])
def test_infos_report_each_mission_as_summed_up_by_hand(continuation: Continuation) -> None:
    venv = make_vec_env(SHORT, 3, copies=2, seed=0, continuation=continuation)
    venv.reset()
    flying = np.ones(venv.num_envs, dtype=bool)
    total, slots = np.zeros(venv.num_envs), np.zeros(venv.num_envs, dtype=int)
    outcomes = []
    for step in play(venv, 60):
        total += step.rewards
        slots += flying
        for k in np.flatnonzero(step.dones):
            info = step.infos[k]
            assert info["episode"]["r"] == pytest.approx(total[k], abs=1e-4)
            assert info["episode"]["l"] == slots[k]
            # A timeout costs 5 and the slot's progress earns at most 1.6; an arrival loses at most 1.1 (a collision).
            assert info["is_success"] == (step.rewards[k] > -2.0)
            assert info["is_success"] or slots[k] == SHORT.max_slots
            assert (info["utility_mbps"] > 0) == info["is_success"]
            outcomes.append(info["is_success"])
        total[step.dones] = 0.0
        slots[step.dones] = 0
        flying = np.concatenate([state.simulator.state.flying.ravel() for state in venv.games])
        assert all(info == {} for info, done in zip(step.infos, step.dones, strict=True) if not done)
    assert {True, False} == set(outcomes)


@pytest.mark.parametrize("continuation", ["mission", "episode"])
@pytest.mark.parametrize(("num_games", "num_uavs"), [(1, 1), (1, 4), (3, 1), (2, 4)])
def test_play_follows_the_simulator_uav_by_uav(num_games: int, num_uavs: int, continuation: Continuation) -> None:
    """Also where everybody is done at once, which is when SuperSuit would reset on its own."""
    scenario = SHORT.changed(num_uavs=num_uavs)
    venv = make_vec_env(scenario, num_games, continuation=continuation)
    twin = Simulator(scenario, num_games, seed=venv.seed(3)[0], continuation=continuation)
    observer, shape = Observer(scenario), (num_games, num_uavs)

    def seen() -> np.ndarray:
        return observer.flat(twin.state).reshape(venv.num_envs, -1)

    np.testing.assert_array_equal(venv.reset(), seen())
    rng, all_at_once = np.random.default_rng(0), 0
    for _ in range(80):
        actions = rng.integers(twin.num_actions, size=venv.num_envs)
        observations, rewards, dones, infos = venv.step(actions)
        outcome = twin.step(actions.reshape(shape))
        last = seen()
        np.testing.assert_array_equal(dones, (outcome.arrived | outcome.timed_out).ravel())
        np.testing.assert_allclose(rewards, outcome.reward_terms.sum(axis=-1).ravel(), rtol=1e-6, atol=1e-6)
        for k in np.flatnonzero(dones):
            np.testing.assert_array_equal(infos[k]["terminal_observation"], last[k])
            assert infos[k]["is_success"] == outcome.arrived.ravel()[k]
        twin.go_on()
        np.testing.assert_array_equal(observations, seen())
        all_at_once += dones.all()
    assert all_at_once > 0 or venv.num_envs > 1


def test_a_uav_s_terminal_observation_is_not_its_next_mission_s() -> None:
    venv, ends = make_vec_env(SHORT, 2, seed=0), 0
    venv.reset()
    position, destination = venv.games[0].layout.position, venv.games[0].layout.destination
    for step in play(venv, 30):
        for k in np.flatnonzero(step.dones):
            terminal = step.infos[k]["terminal_observation"]
            arrived = np.array_equal(terminal[position], terminal[destination])
            assert arrived == step.infos[k]["is_success"]
            assert not np.array_equal(step.observations[k], terminal)
            ends += 1
    assert ends > 10


def test_observations_are_not_overwritten_by_the_next_step() -> None:
    venv = make_vec_env(SHORT, 2, seed=0)
    first = venv.reset()
    kept = first.copy()  # type: ignore[union-attr]
    for step in play(venv, 10):
        np.testing.assert_array_equal(first, kept)
        first, kept = step.observations, step.observations.copy()


def test_a_timeout_is_terminal_unless_it_is_asked_to_truncate() -> None:
    terminal, truncated = make_vec_env(SHORT, 3, seed=0), make_vec_env(SHORT, 3, seed=0, timeout="truncated")
    np.testing.assert_array_equal(terminal.reset(), truncated.reset())
    timeouts = 0
    for a, b in zip(play(terminal, 30), play(truncated, 30), strict=True):
        np.testing.assert_array_equal(a.dones, b.dones)
        np.testing.assert_array_equal(a.rewards, b.rewards)
        assert not any("TimeLimit.truncated" in info for info in a.infos)
        for info in b.infos:
            timed_out = bool(info) and not info["is_success"]
            assert info.get("TimeLimit.truncated", False) == timed_out
            timeouts += timed_out
    assert timeouts > 0


# --- attributes ----------------------------------------------------------------------------------------------------


def test_get_attr_answers_for_each_slot_s_environment() -> None:
    venv = make_vec_env(SHORT, 2, copies=2)
    first, second = venv.games
    assert venv.num_envs == 16
    assert venv.get_attr("simulator") == [first.simulator] * 8 + [second.simulator] * 8
    assert venv.get_attr("simulator", indices=[0, 15]) == [first.simulator, second.simulator]
    assert venv.get_attr("simulator", indices=8) == [second.simulator]
    with pytest.raises(AttributeError):
        venv.get_attr("no_such_attribute")


def test_set_attr_reaches_the_environments_behind_the_slots() -> None:
    venv = make_vec_env(SHORT, 2, copies=2)
    venv.set_attr("timeout", "truncated", indices=[9])
    assert [game.timeout for game in venv.games] == ["terminal", "truncated"]
    venv.set_attr("timeout", "terminal")
    assert [game.timeout for game in venv.games] == ["terminal", "terminal"]


def test_env_method_is_called_once_an_environment() -> None:
    venv = make_vec_env(SHORT, 2, copies=2)
    calls: list[tuple[int, int, int]] = []

    def recorder(index: int) -> Any:
        def record(first: int, *, second: int) -> int:
            calls.append((index, first, second))
            return index

        return record

    for index, game in enumerate(venv.games):
        game.record = recorder(index)
    assert venv.env_method("record", 10, second=20) == [0] * 8 + [1] * 8
    assert calls == [(0, 10, 20), (1, 10, 20)]
    assert venv.env_method("record", 1, second=2, indices=[12, 3]) == [1, 0]
    assert calls[2:] == [(1, 1, 2), (0, 1, 2)]


def test_no_gymnasium_wrapper_is_claimed() -> None:
    venv = make_vec_env(SHORT, 2)
    assert venv.env_is_wrapped(VecEnvWrapper) == [False] * 8  # type: ignore[arg-type]
    assert venv.env_is_wrapped(VecEnvWrapper, indices=[1, 2]) == [False] * 2  # type: ignore[arg-type]


def test_the_vector_environment_can_be_closed() -> None:
    make_vec_env(SHORT, 2).close()


# --- SB3's own tools -----------------------------------------------------------------------------------------------


def test_vec_monitor_counts_the_missions_that_the_infos_report() -> None:
    plain = make_vec_env(SHORT, 2, seed=0)
    monitored = VecMonitor(make_vec_env(SHORT, 2, seed=0), info_keywords=("is_success",))
    plain.reset()
    monitored.reset()
    ends = 0
    for a, b in zip(play(plain, 40), play(monitored, 40), strict=True):
        for mine, theirs in zip(a.infos, b.infos, strict=True):
            assert bool(mine) == bool(theirs)
            if mine:
                ends += 1
                assert theirs["episode"]["r"] == pytest.approx(mine["episode"]["r"], abs=1e-4)
                assert theirs["episode"]["l"] == mine["episode"]["l"]
                assert theirs["episode"]["is_success"] == mine["is_success"]
    assert ends > 10


def test_vec_normalize_normalises_observations_and_terminal_observations_alike() -> None:
    plain, normalised = make_vec_env(SHORT, 2, seed=0), VecNormalize(make_vec_env(SHORT, 2, seed=0), norm_reward=False)
    plain.reset()
    normalised.reset()
    ends = 0
    for a, b in zip(play(plain, 20), play(normalised, 20), strict=True):
        np.testing.assert_allclose(b.observations, normalised.normalize_obs(a.observations), rtol=1e-6)
        np.testing.assert_array_equal(a.dones, b.dones)
        for k in np.flatnonzero(b.dones):
            expected = normalised.normalize_obs(a.infos[k]["terminal_observation"])
            np.testing.assert_allclose(b.infos[k]["terminal_observation"], expected, rtol=1e-6)
            assert b.infos[k]["episode"] == a.infos[k]["episode"]
            ends += 1
    assert ends > 5


@pytest.mark.parametrize("wrapper", [None, VecMonitor, VecNormalize])
@pytest.mark.parametrize("timeout", ["terminal", "truncated"])
def test_stock_ppo_learns_on_it(wrapper: Any, timeout: Any) -> None:
    venv: VecEnv = make_vec_env(SHORT, 4, timeout=timeout)
    venv = wrapper(venv) if wrapper else venv
    model = PPO("MlpPolicy", venv, seed=0, **PPO_SMALL)
    before = [parameter.detach().clone() for parameter in model.policy.parameters()]
    model.learn(3 * 8 * 16)
    assert model.num_timesteps == 3 * 8 * 16
    assert any(not a.equal(b) for a, b in zip(before, model.policy.parameters(), strict=True))
    assert model.ep_info_buffer
    assert model.ep_success_buffer
    assert len(model.ep_success_buffer) == len(model.ep_info_buffer)
    assert all(1 <= info["l"] <= SHORT.max_slots for info in model.ep_info_buffer)


def test_one_seed_trains_stock_ppo_to_one_policy() -> None:
    def weights(seed: int) -> np.ndarray:
        model = PPO("MlpPolicy", make_vec_env(SHORT, 2), seed=seed, **PPO_SMALL).learn(2 * 8 * 8)
        return model.policy.action_net.weight.detach().numpy()  # type: ignore[no-any-return]

    np.testing.assert_array_equal(weights(0), weights(0))
    assert not np.array_equal(weights(0), weights(1))


def test_slots_games_and_copies_multiply() -> None:
    venv = make_vec_env(SHORT.changed(num_uavs=3), 5, copies=2)
    assert isinstance(venv, FlatVecEnv)
    assert venv.num_envs == 2 * 5 * 3
    observations = venv.reset()
    assert observations.shape == (30, venv.games[0].layout.flat_dim)  # type: ignore[union-attr]
    assert observations.dtype == np.float32  # type: ignore[union-attr]
    assert venv.observation_space == venv.games[0].layout.flat_space()
    assert venv.reset_infos == [{}] * 30


# --- defects that remain -------------------------------------------------------------------------------------------


def test_has_attr_answers_for_the_games() -> None:
    venv = make_vec_env(SHORT, 1)
    assert venv.has_attr("layout")
    assert not venv.has_attr("no_such_attribute")
