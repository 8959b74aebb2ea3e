from typing import Any

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test, parallel_seed_test

from lawn_sb3.choices import REWARD_TERMS, Continuation, RewardTerm
from lawn_sb3.envs import TrainingEnv
from lawn_sb3.errors import UserError
from lawn_sb3.game import Missions
from lawn_sb3.scenario import PRESETS
from tests.envs.corridor import CORRIDOR, DESTINATIONS, ORIGINS, action

SHORT = PRESETS["paper"].changed(max_slots=8)
CONTINUATIONS: list[Continuation] = ["mission", "episode"]


def corridor_env(continuation: Continuation, **kwargs: Any) -> TrainingEnv:
    """One game in the corridor on the missions 0 -> 2 (UAV 0) and 1 -> 3 (UAV 1)."""
    env = TrainingEnv(CORRIDOR, 1, continuation, **kwargs)
    env.reset(seed=0)
    env.simulator.reset(missions=Missions(ORIGINS, DESTINATIONS))
    return env


def moves(env: TrainingEnv, *displacements: int) -> dict[str, int]:
    table = env.simulator.rules.actions
    return {agent: action(table, dx, 0, 0) for agent, dx in zip(env.agents, displacements, strict=True)}


def random_actions(env: TrainingEnv, rng: np.random.Generator) -> dict[str, int]:
    return {agent: int(rng.integers(env.simulator.num_actions)) for agent in env.agents}


@pytest.mark.parametrize("continuation", CONTINUATIONS)
def test_keeps_pettingzoo_s_api(continuation: Continuation) -> None:
    parallel_api_test(TrainingEnv(SHORT, 2, continuation), num_cycles=30)
    parallel_seed_test(lambda: TrainingEnv(SHORT, 2, continuation), num_cycles=30)


def test_agent_g_n_plus_i_is_uav_i_of_game_g() -> None:
    env = TrainingEnv(SHORT, 3, seed=0)
    assert len(env.possible_agents) == 3 * 4
    state = env.simulator.state
    actions = dict.fromkeys(env.agents, 0)
    actions[env.possible_agents[2 * 4 + 1]] = action(env.simulator.rules.actions, 0, 0, 1)
    state.position[..., 2], state.destination[..., 2] = 0, 2
    observations, *_ = env.step(actions)
    climbed = np.argwhere(env.simulator.state.position[..., 2] == 1)
    assert climbed.tolist() == [[2, 1]]
    flat = env.observer.flat(env.simulator.state)
    for k, agent in enumerate(env.possible_agents):
        np.testing.assert_array_equal(observations[agent], flat[k // 4, k % 4])


@pytest.mark.parametrize("continuation", CONTINUATIONS)
def test_nobody_ever_leaves(continuation: Continuation) -> None:
    env, rng = TrainingEnv(SHORT, 2, continuation, seed=0), np.random.default_rng(0)
    env.reset()
    for _ in range(40):
        observations, rewards, terminations, truncations, infos = env.step(random_actions(env, rng))
        assert env.agents == env.possible_agents
        assert list(observations) == list(rewards) == list(infos) == env.possible_agents
        assert not any(terminations.values())
        assert not any(truncations.values())


def test_infos_are_empty_but_at_the_end_of_a_mission() -> None:
    env = corridor_env("mission")
    assert env.step(moves(env, 1, 0))[4] == {"game_0_uav_0": {}, "game_0_uav_1": {}}

    # UAV 0 arrives: rewards 1.5 and 12.5, U = 8 Mbps, as worked out slot by slot in test_parallel_env.py.
    infos = env.step(moves(env, 1, 0))[4]
    assert infos["game_0_uav_1"] == {}
    end = infos["game_0_uav_0"]
    assert end["episode"] == {"r": pytest.approx(14.0), "l": 2}
    assert end["is_success"] is True
    assert end["utility_mbps"] == pytest.approx(8.0)
    np.testing.assert_allclose(end["terminal_observation"][:8], [0.2, 0, 0, 0.2, 0, 0, 0.2, 6.0], rtol=1e-6)

    env.simulator.state.position[0, 0] = [3, 0, 0]  # the next mission is random: keep it out of UAV 1's way
    env.simulator.state.destination[0, 0] = [0, 0, 0]
    late = env.step(moves(env, 0, -1))[4]["game_0_uav_1"]
    assert late["is_success"] is False
    assert late["utility_mbps"] == 0.0
    assert late["episode"]["l"] == 3
    # 1 + 4 so far; now alone again, EMA 3 + 5 = 8: rate +2, one voxel further away -0.5, deadline -5
    assert late["episode"]["r"] == pytest.approx(5.0 + 2.0 - 0.5 - 5.0)
    assert "TimeLimit.truncated" not in late


def test_mission_gives_a_uav_that_is_done_its_next_mission_at_once() -> None:
    env = corridor_env("mission")
    env.step(moves(env, 1, 0))
    observations = env.step(moves(env, 1, 0))[0]
    state = env.simulator.state
    assert state.flying.all()
    assert state.slot.tolist() == [[0, 2]]
    assert state.ema_rate_mbps[0].tolist() == pytest.approx([0.0, 6.0])
    np.testing.assert_array_equal(observations["game_0_uav_0"], env.observer.flat(state)[0, 0])
    assert state.cell_load.sum() == 2


def test_episode_lets_a_uav_wait_without_reward_until_the_whole_game_restarts() -> None:
    env = corridor_env("episode")
    env.step(moves(env, 1, 0))
    assert "episode" in env.step(moves(env, 1, 0))[4]["game_0_uav_0"]
    state = env.simulator.state
    assert state.flying.tolist() == [[False, True]]
    assert state.position[0, 0].tolist() == [2, 0, 0]

    _, rewards, _, _, infos = env.step(moves(env, -1, -1))  # slot 3: the deadline of UAV 1
    assert rewards["game_0_uav_0"] == 0.0
    assert infos["game_0_uav_0"] == {}
    assert "episode" in infos["game_0_uav_1"]
    assert env.simulator.state.flying.all()
    assert env.simulator.state.slot.tolist() == [[0, 0]]
    np.testing.assert_array_equal(env.simulator.state.ema_rate_mbps, 0.0)


def test_a_reset_forgets_the_rewards_of_missions_in_the_air() -> None:
    env = corridor_env("mission")
    env.step(moves(env, 1, 0))
    env.reset()
    env.simulator.reset(missions=Missions(ORIGINS, DESTINATIONS))
    env.step(moves(env, 1, 0))
    assert env.step(moves(env, 1, 0))[4]["game_0_uav_0"]["episode"]["r"] == pytest.approx(14.0)


@pytest.mark.parametrize("continuation", CONTINUATIONS)
def test_a_restored_snapshot_goes_on_as_if_nothing_had_happened(continuation: Continuation) -> None:
    env, rng = TrainingEnv(SHORT, 2, continuation, seed=3), np.random.default_rng(3)
    env.reset()
    for _ in range(5):
        env.step(random_actions(env, rng))
    snapshot = env.snapshot()
    joint_actions = [random_actions(env, rng) for _ in range(30)]
    first = [env.step(actions) for actions in joint_actions]
    assert any("episode" in info for step in first for info in step[4].values())

    twin = TrainingEnv(SHORT, 2, continuation, seed=99)
    for restored in (env, twin):
        restored.restore(snapshot)
        for expected, actions in zip(first, joint_actions, strict=True):
            observations, rewards, _, _, infos = restored.step(actions)
            for agent in env.agents:
                np.testing.assert_array_equal(observations[agent], expected[0][agent])
                np.testing.assert_equal(infos[agent], expected[4][agent])
            assert rewards == expected[1]


@pytest.mark.parametrize("term", REWARD_TERMS)
def test_a_term_left_out_is_missing_from_the_reward_and_nothing_else_is(term: RewardTerm) -> None:
    whole, without = TrainingEnv(SHORT, 8), TrainingEnv(SHORT, 8, without_reward=(term,))
    rng, missing, ends = np.random.default_rng(0), 0.0, 0
    for env in (whole, without):
        env.reset(seed=0)
    for _ in range(12):
        actions = random_actions(whole, rng)
        (seen, rewards, _, _, infos), (seen_too, rest, _, _, infos_too) = whole.step(actions), without.step(actions)
        left_out = whole.simulator.outcome.reward_terms[..., REWARD_TERMS.index(term)].ravel()
        np.testing.assert_allclose(np.subtract([*rewards.values()], [*rest.values()]), left_out, atol=1e-12)
        np.testing.assert_equal(seen, seen_too)
        np.testing.assert_equal(infos, infos_too)  # missions are scored in full
        missing += np.abs(left_out).sum()
        ends += sum("episode" in info for info in infos.values())
    assert missing > 0.0
    assert ends > 0


def test_an_unknown_term_is_refused() -> None:
    with pytest.raises(UserError, match=r"unknown reward term 'navi' .did you mean 'nav'"):
        TrainingEnv(SHORT, 1, without_reward=("navi",))  # type: ignore[arg-type]
