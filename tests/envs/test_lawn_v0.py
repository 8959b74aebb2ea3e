"""The game as PettingZoo's users know it, and games that nobody leaves before they are over."""

import copy
import pickle
import warnings
from typing import Any

import numpy as np
import pytest
from pettingzoo.test import api_test, parallel_api_test

from lawn_sb3 import lawn_v0
from lawn_sb3.envs import LawnEnv, make_vec_env
from lawn_sb3.errors import UserError
from lawn_sb3.scenario import PRESETS, load_scenario

HOVER = 0


def _pickled(env: Any) -> Any:
    return pickle.loads(pickle.dumps(env))


COPIES = [copy.deepcopy, _pickled]


def played(env: LawnEnv, seed: int) -> list[dict[str, float]]:
    """Rewards of all slots of a game that is flown at random, the same for every way to play it."""
    env.reset(seed=seed)
    rng, rewards = np.random.default_rng(seed), []
    while env.agents:
        actions = rng.integers(0, len(env.action_table), len(env.possible_agents))
        joint = dict(zip(env.possible_agents, actions, strict=True))
        rewards.append(env.step({uav: joint[uav] for uav in env.agents})[1])
    return rewards


@pytest.mark.parametrize("timeout", ["terminal", "truncated"])
def test_all_stay_until_the_game_is_over_and_it_is_the_same_game(timeout: Any) -> None:
    scenario = load_scenario("paper", ["num_uavs=3", "max_slots=12"])
    leaves, stays = LawnEnv(scenario, timeout), LawnEnv(scenario, timeout, leaving=False)
    lengths = set()
    for seed in range(30):
        fewer, all_of_them = played(leaves, seed), played(stays, seed)
        assert [set(slot) for slot in all_of_them] == [set(stays.possible_agents)] * len(fewer)
        for ours, theirs in zip(all_of_them, fewer, strict=True):
            assert ours == {uav: theirs.get(uav, 0.0) for uav in ours}
        lengths |= {len(slot) for slot in fewer}
    assert {2, 3} <= lengths  # some games did go on after a UAV had arrived


def test_who_is_done_can_only_hover_and_ends_with_the_others() -> None:
    env = LawnEnv(load_scenario("tiny", ["max_slots=3"]), "truncated", leaving=False)
    missions = [[0, 0, 0], [3, 3, 0]], [[1, 0, 0], [0, 3, 0]]
    _, infos = env.reset(options={"missions": missions})
    east = next(k for k, move in enumerate(env.action_table) if tuple(move) == (1, 0, 0))
    assert not env.action_table[HOVER].any()
    assert {uav: info["action_mask"].tolist() for uav, info in infos.items()} == dict.fromkeys(
        env.agents, [1] * len(env.action_table)
    )
    for slot in range(3):
        _, rewards, terminations, truncations, infos = env.step({"uav_0": east, "uav_1": HOVER})
        assert infos["uav_0"]["arrived"] == (slot == 0)
        assert (rewards["uav_0"] != 0.0) == (slot == 0)
        assert np.flatnonzero(infos["uav_0"]["action_mask"]).tolist() == [HOVER]
        over = slot == 2
        assert terminations == {"uav_0": over, "uav_1": False}
        assert truncations == {"uav_0": False, "uav_1": over}  # only who was late is cut short
        assert env.agents == ([] if over else env.possible_agents)


def test_a_trainer_that_wants_nobody_to_leave_is_told_how() -> None:
    env = LawnEnv(load_scenario("tiny"))
    env.reset(options={"missions": ([[0, 0, 0], [3, 3, 0]], [[1, 0, 0], [0, 3, 0]])})
    east = next(k for k, move in enumerate(env.action_table) if tuple(move) == (1, 0, 0))
    env.step({"uav_0": east, "uav_1": HOVER})
    for part in env.step({"uav_1": HOVER}):
        assert list(part) == ["uav_1"]
        assert part.get("uav_0") is None
        with pytest.raises(UserError, match=r"^'uav_0' did not fly .* LawnEnv\(leaving=False\) keeps all"):
            part["uav_0"]
        with pytest.raises(KeyError):  # what a dictionary raises
            part["uav_0"]
        assert _pickled(part).keys() == part.keys()


def test_an_action_outside_the_mask_is_told_of_once_and_does_nothing() -> None:
    missions = [[0, 0, 0], [3, 3, 0]], [[1, 0, 0], [0, 3, 0]]
    masked, hovering = (LawnEnv(load_scenario("tiny"), leaving=False) for _ in range(2))
    east = next(k for k, move in enumerate(masked.action_table) if tuple(move) == (1, 0, 0))
    for env in (masked, hovering):
        env.reset(options={"missions": missions})
        env.step({"uav_0": east, "uav_1": HOVER})
    with pytest.warns(UserWarning, match=f"uav_0 is done, so its action {east} does nothing: .* allows only 0") as told:
        masked.step({"uav_0": east, "uav_1": HOVER})
    assert told[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        masked.step({"uav_0": east, "uav_1": HOVER})
        for _ in range(2):
            hovering.step({"uav_0": HOVER, "uav_1": HOVER})
    np.testing.assert_array_equal(masked.state(), hovering.state())


@pytest.mark.parametrize("leaving", [True, False])
def test_the_interfaces_of_pettingzoo_hold(leaving: bool) -> None:
    parallel_api_test(lawn_v0.parallel_env("tiny", leaving=leaving), num_cycles=200)
    api_test(lawn_v0.env("tiny", leaving=leaving), num_cycles=200)


def test_names_and_changes_are_those_of_a_scenario() -> None:
    assert lawn_v0.parallel_env(changes=("num_uavs=6",), timeout="truncated").scenario.num_uavs == 6
    assert lawn_v0.env("tiny").unwrapped.scenario == PRESETS["tiny"]
    with pytest.raises(UserError, match="did you mean 'paper'"):
        lawn_v0.parallel_env("papre")
    with pytest.raises(UserError, match="changes 'num_uavs': expected key=value"):
        lawn_v0.env(changes=("num_uavs",))


@pytest.mark.parametrize("copied", COPIES)
def test_a_copy_goes_on_as_the_original_does(copied: Any) -> None:
    env = lawn_v0.parallel_env("tiny", changes=("max_slots=30",))
    env.reset(seed=3)
    env.step(dict.fromkeys(env.agents, HOVER))
    other = copied(env)
    for slot in range(40):
        for one in (env, other):
            if not one.agents:
                one.reset()
        actions = {uav: (7 * slot + k) % len(env.action_table) for k, uav in enumerate(env.agents)}
        ours, theirs = env.step(actions), other.step(actions)
        assert ours[1:4] == theirs[1:4]
        for uav, seen in ours[0].items():
            np.testing.assert_array_equal(seen, theirs[0][uav])


@pytest.mark.parametrize("copied", COPIES)
def test_a_copy_of_many_games_goes_on_too(copied: Any) -> None:
    games = make_vec_env(PRESETS["tiny"], num_games=3, seed=5)
    games.reset()
    other = copied(games)
    for slot in range(40):
        actions = (np.arange(games.num_envs) + slot) % 63
        ours, theirs = games.step(actions), other.step(actions)
        for left, right in zip(ours[:3], theirs[:3], strict=True):
            np.testing.assert_array_equal(left, right)


@pytest.mark.parametrize("copied", COPIES)
def test_a_copy_of_a_game_in_turns_goes_on_too(copied: Any) -> None:
    env = lawn_v0.env("tiny", changes=("max_slots=20",))
    env.reset(seed=3)
    env.step(HOVER)  # in the middle of a slot
    other = copied(env)
    for turn in range(60):
        assert env.agent_selection == other.agent_selection
        ours, theirs = env.last(), other.last()
        np.testing.assert_array_equal(ours[0], theirs[0])
        assert ours[1:4] == theirs[1:4]
        for one in (env, other):
            one.step(None if ours[2] or ours[3] else 7 * turn % 27)
        if not env.agents:
            break
    assert not env.agents
    assert not other.agents
