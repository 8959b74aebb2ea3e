"""One test for each defect of SuperSuit's flattening that could reach a learner, and SB3's own tools on top of it."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pytest
import torch as th
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecMonitor, VecNormalize

from lawn_sb3.choices import Continuation
from lawn_sb3.envs import FlatVecEnv, Observer, make_vec_env
from lawn_sb3.envs.observation import space_of
from lawn_sb3.errors import UserError
from lawn_sb3.game import Simulator
from lawn_sb3.scenario import PRESETS

SHORT = PRESETS["paper"].changed(max_slots=8)
PPO_SMALL: dict[str, Any] = {"n_steps": 8, "batch_size": 64, "n_epochs": 1, "device": "cpu"}


class Step(NamedTuple):
    observations: np.ndarray
    rewards: np.ndarray
    dones: np.ndarray
    infos: list[dict[str, Any]]


def reset(venv: VecEnv) -> np.ndarray:
    """Observations of a reset, which are arrays and not dictionaries here."""
    return np.asarray(venv.reset())


def play(venv: VecEnv, slots: int, seed: int = 0) -> Iterator[Step]:
    """Random play; the same seed gives the same actions."""
    rng = np.random.default_rng(seed)
    num_actions = venv.action_space.n  # type: ignore[attr-defined]
    for _ in range(slots):
        observations, rewards, dones, infos = venv.step(rng.integers(num_actions, size=venv.num_envs))
        yield Step(np.asarray(observations), rewards, dones, infos)


def assert_same_play(one: VecEnv, other: VecEnv, slots: int = 25) -> None:
    np.testing.assert_array_equal(reset(one), reset(other))
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


@pytest.mark.parametrize("seeds", [(5, 6), (None, None)])
def test_two_seeds_and_no_seeds_give_different_play(seeds: tuple[int | None, int | None]) -> None:
    one, other = (make_vec_env(SHORT, 3, seed=seed) for seed in seeds)
    assert not np.array_equal(reset(one), reset(other))
    for a, b in zip(play(one, 25), play(other, 25), strict=True):
        assert not np.array_equal(a.observations, b.observations)


def test_seeding_and_then_a_reset_play_the_same_again() -> None:
    venv, fresh = make_vec_env(SHORT, 2, copies=2, seed=1), make_vec_env(SHORT, 2, copies=2, seed=7)
    venv.reset()
    list(play(venv, 10))
    venv.seed(7)
    assert_same_play(venv, fresh)


def test_a_reset_without_seeding_goes_on_to_new_games() -> None:
    venv = make_vec_env(SHORT, 2, seed=1)
    first = reset(venv).copy()
    assert not np.array_equal(reset(venv), first)


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
        rows = np.asarray(observations).reshape(6, 4, -1)[:, 0]
        assert len(np.unique(rows, axis=0)) == 6


# --- ends of missions ----------------------------------------------------------------------------------------------


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
    rng, total, all_at_once = np.random.default_rng(0), np.zeros(venv.num_envs), False
    for _ in range(80):
        actions = rng.integers(twin.num_actions, size=venv.num_envs)
        observations, rewards, dones, infos = venv.step(actions)
        outcome = twin.step(actions.reshape(shape))
        own = outcome.reward_terms.sum(axis=-1).ravel()
        last, slots, total = seen(), twin.state.slot.ravel(), total + own
        np.testing.assert_array_equal(dones, (outcome.arrived | outcome.timed_out).ravel())
        np.testing.assert_allclose(rewards, own, rtol=1e-6, atol=1e-6)
        for k, (info, done) in enumerate(zip(infos, dones, strict=True)):
            if not done:
                assert info == {}
                continue
            assert info["episode"] == {"r": pytest.approx(total[k]), "l": slots[k]}
            assert info["is_success"] == outcome.arrived.ravel()[k]
            assert info["utility_mbps"] == outcome.utility_mbps.ravel()[k]
            np.testing.assert_array_equal(info["terminal_observation"], last[k])
        total[dones] = 0.0
        twin.go_on()
        np.testing.assert_array_equal(observations, seen())
        all_at_once |= bool(dones.all())
    assert all_at_once or venv.num_envs > 1


def test_observations_are_not_overwritten_by_the_next_step() -> None:
    venv = make_vec_env(SHORT, 2, seed=0)
    first = reset(venv)
    kept = first.copy()
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
    assert venv.has_attr("layout")
    assert not venv.has_attr("no_such_attribute")
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


@pytest.mark.parametrize("copies", [1, 2])
def test_masks_are_those_of_the_slots_that_ask(copies: int) -> None:
    """In the corner (0, 0, 0) the 20 moves without a negative step stay inside, but for (0, 0, 3): H is 3 voxels."""
    env = make_vec_env(SHORT, 3, copies=copies, seed=0)
    env.reset()
    last = env.games[-1].simulator
    last.state.position[2, 3] = 0
    masks = np.stack(env.env_method("action_masks"))
    assert masks.shape == (12 * copies, 63)
    stays = (last.rules.actions >= 0).all(axis=1) & (last.rules.actions != [0, 0, 3]).any(axis=1)
    np.testing.assert_array_equal(masks[-1], stays)
    assert masks[-1].sum() == 19
    for slot, mask in enumerate(masks):
        game, place = env.games[slot // 12].simulator, slot % 12
        ends = game.state.position[place // 4, place % 4] + game.rules.actions
        np.testing.assert_array_equal(mask, ((ends >= 0) & (ends < SHORT.grid)).all(axis=1))
    np.testing.assert_array_equal(env.env_method("action_masks", indices=[5, 1]), masks[[5, 1]])
    np.testing.assert_array_equal(env.action_masks(), masks)
    last.state.flying[2, 3] = False
    np.testing.assert_array_equal(env.flying(), np.arange(12 * copies) < 12 * copies - 1)
    assert env.env_method("flying", indices=[-1, 0]) == [False, True]


def test_no_gymnasium_wrapper_is_claimed_and_it_can_be_closed() -> None:
    venv = make_vec_env(SHORT, 2)
    assert venv.env_is_wrapped(VecEnvWrapper) == [False] * 8
    assert venv.env_is_wrapped(VecEnvWrapper, indices=[1, 2]) == [False] * 2
    venv.close()


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
        np.testing.assert_allclose(b.observations, np.asarray(normalised.normalize_obs(a.observations)), rtol=1e-6)
        np.testing.assert_array_equal(a.dones, b.dones)
        for k in np.flatnonzero(b.dones):
            expected = np.asarray(normalised.normalize_obs(a.infos[k]["terminal_observation"]))
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
    def weights(seed: int) -> th.Tensor:
        model = PPO("MlpPolicy", make_vec_env(SHORT, 2), seed=seed, **PPO_SMALL).learn(2 * 8 * 8)
        weight: th.Tensor = model.policy.state_dict()["action_net.weight"]
        return weight

    assert weights(0).equal(weights(0))
    assert not weights(0).equal(weights(1))


def test_slots_games_and_copies_multiply() -> None:
    venv = make_vec_env(SHORT.changed(num_uavs=3), 5, copies=2)
    assert isinstance(venv, FlatVecEnv)
    assert venv.num_envs == 2 * 5 * 3
    observations = reset(venv)
    assert observations.shape == (30, venv.games[0].layout.flat_dim)
    assert observations.dtype == np.float32
    assert venv.observation_space == space_of(venv.games[0].layout.flat_dim)
    assert venv.reset_infos == [{}] * 30


def test_the_first_games_are_drawn_side_by_side() -> None:
    drawn = make_vec_env(SHORT, 3, copies=2, seed=0)
    drawn.reset()
    picture = drawn.render()
    assert picture.shape == (3 * 480, 2 * 480, 3)
    next(play(drawn, 1))
    assert not np.array_equal(drawn.render(mode="rgb_array"), picture)
    assert len(make_vec_env(SHORT, 64, seed=0).get_images()) == 16
    assert VecMonitor(drawn).render().shape == picture.shape  # type: ignore[union-attr]
    with pytest.raises(UserError, match=r"'human'.*rgb_array"):
        drawn.render("human")
