import warnings
from typing import Any

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test, parallel_seed_test

from lawn_sb3.choices import REWARD_TERMS
from lawn_sb3.envs import LawnEnv, Observer
from lawn_sb3.envs.rendering import draw_picture
from lawn_sb3.errors import UserError
from lawn_sb3.scenario import PRESETS, Scenario
from tests.envs.corridor import CORRIDOR, DESTINATIONS, ORIGINS, action

SCENARIOS = [
    PRESETS["paper"].changed(max_slots=30),
    PRESETS["paper"].changed(num_uavs=1, max_slots=30),
    PRESETS["paper"].changed(num_uavs=7, gbs_grid=(3, 1), arrived_uav="stays", max_slots=30),
]
INFO_KEYS = {
    *("position", "destination", "cell", "cell_load", "num_rbs", "rate_mbps", "ema_rate_mbps", "corrected_rate_mbps"),
    *("slot", "min_slots", "collided", "arrived", "timed_out", "utility_mbps", "action_mask"),
    *(f"reward_{term}" for term in REWARD_TERMS),
}


def corridor_env(**kwargs: Any) -> LawnEnv:
    """The corridor, reset to the missions 0 -> 2 (UAV 0) and 1 -> 3 (UAV 1)."""
    env = LawnEnv(CORRIDOR, **kwargs)
    env.reset(options={"missions": (ORIGINS, DESTINATIONS)})
    return env


def moves(env: LawnEnv, **displacements: int) -> dict[str, int]:
    return {agent: action(env.action_table, dx, 0, 0) for agent, dx in displacements.items()}


def random_actions(env: LawnEnv, rng: np.random.Generator) -> dict[str, int]:
    return {agent: int(rng.integers(len(env.action_table))) for agent in env.agents}


@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda s: f"N={s.num_uavs}")
@pytest.mark.parametrize("timeout", ["terminal", "truncated"])
def test_keeps_pettingzoo_s_api(scenario: Scenario, timeout: Any) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message="reset option 'options' is unknown")  # PettingZoo's test passes one
        parallel_api_test(LawnEnv(scenario, timeout=timeout), num_cycles=200)


@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda s: f"N={s.num_uavs}")
def test_one_seed_gives_one_game(scenario: Scenario) -> None:
    parallel_seed_test(lambda: LawnEnv(scenario), num_cycles=200)


def test_two_seeds_give_two_games_and_no_seed_goes_on() -> None:
    env = LawnEnv()
    first, second = env.reset(seed=0)[0]["uav_0"], env.reset()[0]["uav_0"]
    other = env.reset(seed=1)[0]["uav_0"]
    assert not np.array_equal(first, second)
    assert not np.array_equal(first, other)
    np.testing.assert_array_equal(env.reset(seed=0)[0]["uav_0"], first)
    np.testing.assert_array_equal(env.reset()[0]["uav_0"], second)


@pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda s: f"N={s.num_uavs}")
def test_each_uav_observes_its_local_observation_and_state_is_the_global_one(scenario: Scenario) -> None:
    env, observer, rng = LawnEnv(scenario), Observer(scenario), np.random.default_rng(0)
    observations, _ = env.reset(seed=0)
    assert env.state_space.contains(env.state())
    for _ in range(30):
        flew = list(env.agents)
        np.testing.assert_array_equal(env.state(), observer.state(env.simulator.state)[0])
        local = observer.local(env.simulator.state)[0]
        assert set(observations) >= set(flew)
        for i, agent in enumerate(env.possible_agents):
            if agent in observations:
                np.testing.assert_array_equal(observations[agent], local[i])
                assert env.observation_space(agent).contains(observations[agent])
        observations = env.step(random_actions(env, rng))[0]


def test_observations_and_infos_are_not_overwritten_by_the_next_slot() -> None:
    env = corridor_env()
    observations, _, _, _, infos = env.step(moves(env, uav_0=1, uav_1=0))
    seen, position = observations["uav_0"].copy(), infos["uav_0"]["position"].copy()
    env.step(moves(env, uav_0=-1, uav_1=0))
    np.testing.assert_array_equal(observations["uav_0"], seen)
    np.testing.assert_array_equal(infos["uav_0"]["position"], position)


@pytest.mark.parametrize(
    ("missions", "complaint"),
    [
        ((ORIGINS,), "expected a pair"),
        ((ORIGINS, DESTINATIONS, ORIGINS), "expected a pair"),
        ((ORIGINS * 0, DESTINATIONS), "share an origin"),
        (([[0, 0, 0], [1, 0]], DESTINATIONS), "origins have rows of unequal length"),
        (3, "expected a pair"),
    ],
)
def test_missions_that_cannot_be_flown_are_refused(missions: Any, complaint: str) -> None:
    with pytest.raises(UserError, match=complaint):
        LawnEnv(CORRIDOR).reset(options={"missions": missions})


def test_an_unknown_reset_option_is_named_in_a_warning() -> None:
    with pytest.warns(UserWarning, match="reset option 'mission' is unknown and ignored; known: 'missions'"):
        LawnEnv(CORRIDOR).reset(options={"mission": (ORIGINS, DESTINATIONS)})


def test_an_action_moves_its_uav_by_its_displacement() -> None:
    env = LawnEnv(PRESETS["paper"].changed(num_uavs=1))
    assert env.action_space("uav_0").n == len(env.action_table) == 63
    for index, displacement in enumerate(env.action_table):
        env.reset(options={"missions": ([[5, 5, 1]], [[0, 0, 0]])})
        infos = env.step({"uav_0": index})[4]
        expected = np.clip(np.array([5, 5, 1]) + displacement, 0, [9, 9, 2])  # three layers: a climb of 2 is clipped
        np.testing.assert_array_equal(infos["uav_0"]["position"], expected)


def test_infos_before_the_first_slot_know_the_association_and_have_rated_nothing() -> None:
    _, infos = LawnEnv(CORRIDOR).reset(options={"missions": (ORIGINS.tolist(), DESTINATIONS.tolist())})
    for i, agent in enumerate(["uav_0", "uav_1"]):
        assert set(infos[agent]) == INFO_KEYS
        expected = {
            "position": [i, 0, 0], "destination": [i + 2, 0, 0], "cell": 0, "cell_load": 2, "num_rbs": 2,
            "rate_mbps": 0.0, "ema_rate_mbps": 0.0, "corrected_rate_mbps": 0.0, "slot": 0, "min_slots": 2,
            "collided": False, "arrived": False, "timed_out": False, "utility_mbps": 0.0,
        }  # fmt: skip
        assert_info(infos[agent], expected, dict.fromkeys(REWARD_TERMS, 0.0))


def assert_info(info: dict[str, Any], expected: dict[str, Any], terms: dict[str, float]) -> None:
    """Compare an info to what was worked out by hand, key by key."""
    assert set(info) == INFO_KEYS
    assert {term: info[f"reward_{term}"] for term in REWARD_TERMS} == pytest.approx(terms, rel=1e-9)
    for value in info.values():  # trainers of other projects take these for tensors
        assert isinstance(value, bool | int | float | np.ndarray)
    for key, value in expected.items():
        assert np.asarray(info[key]).tolist() == pytest.approx(value, rel=1e-9), key
        assert isinstance(info[key], bool) == isinstance(value, bool), key


def test_a_game_gives_what_was_worked_out_by_hand() -> None:
    env = corridor_env()

    # Slot 1: UAV 0 flies into UAV 1, which hovers at voxel 1. Two in cell 0: 2 RBs, 4 Mbps; EMA 0.5 * 4 = 2 Mbps,
    # corrected by 1 - 0.5 = 0.5 to 4 Mbps.
    _, rewards, terminations, truncations, infos = env.step(moves(env, uav_0=1, uav_1=0))
    both = {
        "position": [1, 0, 0], "cell": 0, "cell_load": 2, "num_rbs": 2, "rate_mbps": 4.0, "ema_rate_mbps": 2.0,
        "corrected_rate_mbps": 4.0, "slot": 1, "min_slots": 2, "collided": True, "arrived": False,
        "timed_out": False, "utility_mbps": 0.0,
    }  # fmt: skip
    assert_info(infos["uav_0"], both, {"rate": 2.0, "nav": 0.5, "col": -1.0, "term": 0.0})
    assert_info(infos["uav_1"], both, {"rate": 2.0, "nav": 0.0, "col": -1.0, "term": 0.0})
    assert rewards == pytest.approx({"uav_0": 1.5, "uav_1": 1.0})
    assert terminations == truncations == {"uav_0": False, "uav_1": False}
    assert env.agents == ["uav_0", "uav_1"]

    # Slot 2: UAV 0 arrives in cell 1, each is alone: 5 RBs, 10 Mbps; EMA 1 + 5 = 6 Mbps, corrected by 1 - 0.25 to
    # 8 Mbps; U_0 = 8 * 2 / 2.
    _, rewards, terminations, truncations, infos = env.step(moves(env, uav_0=1, uav_1=0))
    alone = {"cell_load": 1, "num_rbs": 5, "rate_mbps": 10.0, "ema_rate_mbps": 6.0, "corrected_rate_mbps": 8.0}
    done = {"position": [2, 0, 0], "cell": 1, "slot": 2, "collided": False, "arrived": True, "utility_mbps": 8.0}
    waits = {"position": [1, 0, 0], "cell": 0, "slot": 2, "collided": False, "arrived": False, "utility_mbps": 0.0}
    assert_info(infos["uav_0"], alone | done, {"rate": 4.0, "nav": 0.5, "col": 0.0, "term": 8.0})
    assert_info(infos["uav_1"], alone | waits, {"rate": 4.0, "nav": 0.0, "col": 0.0, "term": 0.0})
    assert rewards == pytest.approx({"uav_0": 12.5, "uav_1": 4.0})
    assert terminations == {"uav_0": True, "uav_1": False}
    assert truncations == {"uav_0": False, "uav_1": False}
    assert env.agents == ["uav_1"]

    # Slot 3, the deadline: UAV 1 reaches the voxel UAV 0 has left; EMA 3 + 5 = 8 Mbps, corrected by 1 - 0.125.
    observations, rewards, terminations, truncations, infos = env.step(moves(env, uav_1=1))
    late = {
        "position": [2, 0, 0], "cell": 1, "cell_load": 1, "num_rbs": 5, "rate_mbps": 10.0, "ema_rate_mbps": 8.0,
        "corrected_rate_mbps": 8.0 / 0.875, "slot": 3, "collided": False, "arrived": False, "timed_out": True,
        "utility_mbps": 0.0,
    }  # fmt: skip
    assert set(observations) == set(infos) == {"uav_1"}
    assert_info(infos["uav_1"], late, {"rate": 2.0, "nav": 0.5, "col": 0.0, "term": -5.0})
    assert rewards == pytest.approx({"uav_1": -2.5})
    assert (terminations, truncations) == ({"uav_1": True}, {"uav_1": False})
    assert env.agents == []


def test_a_timeout_truncates_if_asked_to_and_costs_the_same() -> None:
    env = corridor_env(timeout="truncated")
    for _ in range(2):
        _, _, terminations, truncations, _ = env.step(moves(env, uav_0=1, uav_1=0))
    assert (terminations["uav_0"], truncations["uav_0"]) == (True, False)  # an arrival terminates either way
    _, rewards, terminations, truncations, infos = env.step(moves(env, uav_1=1))
    assert (terminations, truncations) == ({"uav_1": False}, {"uav_1": True})
    assert rewards == pytest.approx({"uav_1": -2.5})
    assert infos["uav_1"]["timed_out"]
    assert env.agents == []


def test_an_unknown_way_to_time_out_is_refused() -> None:
    with pytest.raises(UserError, match="timeout"):
        LawnEnv(CORRIDOR, timeout="trunctated")  # type: ignore[arg-type]


def test_a_missing_action_is_refused_by_name_and_plays_nothing() -> None:
    env = corridor_env()
    with pytest.raises(UserError, match="no action for uav_1"):
        env.step({"uav_0": 0})
    assert env.simulator.state.slot.tolist() == [[0, 0]]


@pytest.mark.parametrize("index", [-1, 7])
def test_an_action_that_does_not_exist_is_refused(index: int) -> None:
    env = corridor_env()
    with pytest.raises(UserError, match=f"action of uav_0 = {index}: from 0 to 6"):
        env.step({"uav_0": index, "uav_1": 0})


def test_uavs_that_are_done_need_no_action() -> None:
    env = corridor_env()
    for _ in range(2):
        env.step(moves(env, uav_0=1, uav_1=0))
    infos = env.step(moves(env, uav_1=1, uav_0=-1))[4]
    assert list(infos) == ["uav_1"]
    assert env.simulator.state.position[0, 0].tolist() == [2, 0, 0]


def test_text_shows_uavs_over_destinations_over_gbss() -> None:
    env = corridor_env(render_mode="ansi")
    assert env.render() == "01ab\n0: (0, 0, 0) to a: (2, 0, 0), flying\n1: (1, 0, 0) to b: (3, 0, 0), flying"
    env.step(moves(env, uav_0=1, uav_1=0))
    env.step(moves(env, uav_0=1, uav_1=-1))
    assert env.render() == "1^0b\n0: (2, 0, 0) to a: (2, 0, 0), done\n1: (0, 0, 0) to b: (3, 0, 0), flying"


def test_text_has_north_up_and_east_right() -> None:
    scenario = CORRIDOR.changed(width_voxels=4, length_voxels=6, gbs_grid=(2, 1))  # GBSs at (10, 30) and (30, 30) m
    env = LawnEnv(scenario, render_mode="ansi")
    env.reset(options={"missions": ([[3, 5, 0], [0, 0, 0]], [[0, 4, 0], [1, 1, 0]])})
    text = env.render()
    assert isinstance(text, str)
    assert text.splitlines()[:6] == ["...0", "a...", ".^.^", "....", ".b..", "1..."]


def test_picture_changes_as_uavs_move_and_only_then() -> None:
    env = corridor_env(render_mode="rgb_array")
    first = env.render()
    assert isinstance(first, np.ndarray)
    assert first.shape == (480, 480, 3)
    assert first.dtype == np.uint8
    assert len(np.unique(first.reshape(-1, 3), axis=0)) > 5  # more than a blank page
    env.step(moves(env, uav_0=0, uav_1=0))
    np.testing.assert_array_equal(env.render(), first)
    env.step(moves(env, uav_0=1, uav_1=0))
    assert not np.array_equal(np.asarray(env.render()), first)


def test_picture_shows_borders_of_cells_their_loads_and_where_uavs_came_from() -> None:
    env = corridor_env(render_mode="rgb_array")
    env.step(moves(env, uav_0=1, uav_1=0))
    state, trail = env.simulator.state, [ORIGINS]
    whole = np.asarray(env.render())
    np.testing.assert_array_equal(draw_picture(CORRIDOR, state, trail=trail), whole)
    assert not np.array_equal(draw_picture(CORRIDOR, state), whole)
    turned = state._replace(cell_load=np.array([[0, 7]]))
    assert not np.array_equal(draw_picture(CORRIDOR, turned, trail=trail), whole)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lawn_sb3.envs.rendering.cell_borders", lambda scenario: np.zeros((0, 2, 2)))
        assert not np.array_equal(draw_picture(CORRIDOR, state, trail=trail), whole)
    env.reset(options={"missions": (ORIGINS, DESTINATIONS)})
    new = np.asarray(env.render())
    np.testing.assert_array_equal(new, draw_picture(CORRIDOR, env.simulator.state))  # without the last game's trail


def test_nothing_is_drawn_unless_asked_for() -> None:
    assert corridor_env().render() is None


def test_nobody_flies_before_a_reset_or_after_the_end() -> None:
    env = LawnEnv(PRESETS["tiny"])
    with pytest.raises(UserError, match="no game was started: reset"):
        env.step(dict.fromkeys(env.possible_agents, 0))
    env.reset(seed=0)
    while env.agents:
        env.step(dict.fromkeys(env.agents, 0))
    assert env.step({}) == ({}, {}, {}, {}, {})


@pytest.mark.parametrize("scenario", ["paper", {"num_uavs": 2}, None])
def test_what_is_no_scenario_is_refused_with_how_to_make_one(scenario: Any) -> None:
    with pytest.raises(UserError, match=r"is no Scenario; load_scenario\(NAME\) .* lawn_v0.parallel_env\(NAME\)"):
        LawnEnv(scenario)


@pytest.mark.parametrize("seed", ["x", 1.5, -1])
def test_a_seed_is_a_whole_number(seed: Any) -> None:
    with pytest.raises(UserError, match="a whole number from 0 up"):
        LawnEnv(PRESETS["tiny"]).reset(seed=seed)
