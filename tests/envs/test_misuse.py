"""What the environments are handed wrongly, and the one line that says so: nothing is played, nothing guessed."""

import copy
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from lawn_sb3.envs import FlatVecEnv, LawnEnv, make_vec_env
from lawn_sb3.errors import UserError
from lawn_sb3.scenario import PRESETS

TINY: Any = PRESETS["tiny"]
"""Two UAVs, 63 actions."""


def step(actions: Any) -> Callable[[], object]:
    """Play one slot of a game that has begun."""

    def play() -> object:
        env = LawnEnv(TINY)
        env.reset(seed=0)
        return env.step(actions)

    return play


def first(action: Any) -> Callable[[], object]:
    return step({"uav_0": action, "uav_1": 0})


def reset(**arguments: Any) -> Callable[[], object]:
    return lambda: LawnEnv(TINY).reset(**arguments)


def made(**arguments: Any) -> Callable[[], object]:
    return lambda: make_vec_env(**{"scenario": TINY, "num_games": 2, **arguments})


def step_all(actions: Any) -> Callable[[], object]:
    """Play one slot of two games of two UAVs."""

    def play() -> object:
        env = make_vec_env(TINY, num_games=2, seed=0)
        env.reset()
        return env.step(actions)

    return play


def step_seeded() -> object:
    """Seed games, which starts none, and play a slot of them."""
    env = make_vec_env(TINY, num_games=2, copies=2)
    env.seed(3)
    return env.step(np.zeros(8, int))


MISUSES: Mapping[str, tuple[Callable[[], object], str]] = {
    "no reset": (lambda: LawnEnv(TINY).step({"uav_0": 0, "uav_1": 0}), "no game was started: reset() starts one"),
    "no reset of many": (
        lambda: make_vec_env(TINY, num_games=2, seed=0).step(np.zeros(4, int)),
        "no game was started: reset() starts one",
    ),
    "seed without a reset": (step_seeded, "no game was started: reset() starts one"),
    "action 10^30": (first(10**30), f"action of uav_0 = {10**30}: from 0 to 62"),
    "action -10^30": (first(-(10**30)), f"action of uav_0 = {-(10**30)}: from 0 to 62"),
    "action 2^63": (first(2**63), f"action of uav_0 = {2**63}: from 0 to 62"),
    "action 63": (first(63), "action of uav_0 = 63: from 0 to 62"),
    "action -1": (first(np.int64(-1)), "action of uav_0 = np.int64(-1): from 0 to 62"),
    "action 1.5": (first(1.5), "action of uav_0 = 1.5: a whole number"),
    "action nan": (first(float("nan")), "action of uav_0 = nan: a whole number"),
    "action in text": (first("1"), "action of uav_0 = '1': a whole number"),
    "action none": (first(None), "action of uav_0 = None: a whole number"),
    "actions for one": (first([1]), "action of uav_0 = [1]: a whole number"),
    "nothing": (step({}), "no action for uav_0, uav_1: every UAV in the air needs one"),
    "one missing": (step({"uav_0": 0}), "no action for uav_1: every UAV in the air needs one"),
    "by number": (step({0: 0, 1: 0}), "no action for uav_0, uav_1"),
    "one more": (step({"uav_0": 0, "uav_1": 0, "uav_9": 0}), "action of 'uav_9': there are uav_0, uav_1"),
    "actions in a list": (step([0, 0]), "actions = [0, 0]: one for each UAV in the air, by its name"),
    "actions none": (step(None), "actions = None: one for each UAV in the air, by its name"),
    "seed below": (reset(seed=-1), "seed = -1: a whole number from 0 up"),
    "seed in text": (reset(seed="x"), "seed = 'x': a whole number from 0 up"),
    "seed 1.5": (reset(seed=1.5), "seed = 1.5: a whole number from 0 up"),
    "options in a list": (reset(options=[1]), "options = [1]: a dictionary, such as"),
    "options in text": (reset(options="missions"), "options = 'missions': a dictionary, such as"),
    "missions no pair": (reset(options={"missions": 5}), "option 'missions' = 5: expected a pair"),
    "missions empty": (reset(options={"missions": ([], [])}), "origins have shape (0,), expected (1, 2, 3)"),
    "a name": (lambda: LawnEnv("paper"), "scenario 'paper' is no Scenario; load_scenario(NAME) makes one"),  # type: ignore[arg-type]
    "a name for many": (made(scenario="paper"), "scenario 'paper' is no Scenario; load_scenario(NAME) makes one"),
    "no games": (made(num_games=0), "num_games = 0: at least 1 game"),
    "a game and a half": (made(num_games=1.5), "num_games = 1.5: at least 1 game"),
    "true games": (made(num_games=True), "num_games = True: at least 1 game"),
    "no copies": (made(copies=0), "copies = 0: at least 1"),
    "seed for many below": (made(seed=-1), "seed = -1: a whole number from 0 up"),
    "seed for many in text": (made(seed="x"), "seed = 'x': a whole number from 0 up"),
    "unknown continuation": (made(continuation="missions"), "unknown continuation 'missions' (did you mean"),
    "unknown timeout": (made(timeout="never"), "unknown timeout 'never'"),
    "unknown reward": (made(without_reward=("navi",)), "unknown reward term 'navi' (did you mean 'nav'?)"),
    "unknown extra": (made(extras=("clocks",)), "unknown extra 'clocks' (did you mean 'clock'?)"),
    "unknown credit": (made(credit="ours"), "unknown credit 'ours'"),
    "slack below": (made(slack=-1), "slack = -1: a whole number from 0 up"),
    "slack 1.5": (made(slack=1.5), "slack = 1.5: a whole number from 0 up"),
    "nobody": (made(fewest_uavs=0, continuation="episode"), "fewest_uavs = 0: from 1 to num_uavs = 2"),
    "too few for all": (step_all(np.zeros(3, int)), "actions are int64 of shape (3,): must be 4 whole numbers"),
    "too many for all": (step_all(np.zeros(5, int)), "actions are int64 of shape (5,): must be 4 whole numbers"),
    "a column": (step_all(np.zeros((4, 1), int)), "actions are int64 of shape (4, 1): must be 4 whole numbers"),
    "halves": (step_all(np.full(4, 1.5)), "actions are float64 of shape (4,): must be 4 whole numbers"),
    "no numbers": (step_all(np.full(4, np.nan)), "actions are float64 of shape (4,): must be 4 whole numbers"),
    "text": (step_all("abcd"), "must be 4 whole numbers"),
    "none": (step_all(None), "actions are object of shape (): must be 4 whole numbers"),
    "all 10^30": (step_all(np.full(4, 10**30, dtype=object)), "actions are object of shape (4,): must be 4 whole"),
    "all too large": (step_all(np.full(4, 63)), "actions must be whole numbers from 0 to 62"),
    "all below": (step_all(np.full(4, -1)), "actions must be whole numbers from 0 to 62"),
}


@pytest.mark.parametrize(("call", "words"), MISUSES.values(), ids=MISUSES)
def test_what_is_wrong_is_said_in_one_line(call: Callable[[], object], words: str) -> None:
    with pytest.raises(UserError) as refusal:
        call()
    assert words in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_uavs_that_are_done_may_still_be_given_actions() -> None:
    env = LawnEnv(TINY)
    env.reset(seed=0)
    everybody = dict.fromkeys(env.possible_agents, 0)
    while env.agents:
        env.step(everybody)
    assert env.step(everybody) == ({}, {}, {}, {}, {})


def test_lists_of_whole_numbers_will_do() -> None:
    env = make_vec_env(TINY, num_games=2, seed=0)
    assert isinstance(env, FlatVecEnv)
    env.reset()
    assert env.step([0, 0, 0, 0])[1].shape == (4,)  # type: ignore[arg-type]


def test_games_that_were_gone_back_to_or_copied_have_been_started() -> None:
    env, other = make_vec_env(TINY, num_games=2, seed=0), make_vec_env(TINY, num_games=2)
    env.reset()
    other.env_method("restore", env.env_method("snapshot", indices=0)[0], indices=0)
    hover = np.zeros(4, int)
    seen = env.step(hover)[0]
    np.testing.assert_array_equal(other.step(hover)[0], seen)
    again = copy.deepcopy(other)
    np.testing.assert_array_equal(again.step(hover)[0], env.step(hover)[0])
