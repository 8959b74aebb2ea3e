"""In-time moves of QMIX and IQL: the mask is the game's, in the argmax, in exploration and in the targets."""

from typing import Any

import numpy as np
import pytest
import torch as th
from hypothesis import given, settings
from hypothesis import strategies as st

from lawn_sb3.algos.common.in_time import FORBIDDEN, draw_actions, in_time
from lawn_sb3.algos.iql import IQL
from lawn_sb3.algos.qmix import QMIX
from lawn_sb3.envs import FlatVecEnv, Observer, make_vec_env
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.find_policy import find_policy
from lawn_sb3.experiment.players import ModelPlayer
from lawn_sb3.experiment.recipe import Evaluation, Method
from lawn_sb3.game import Simulator
from lawn_sb3.planning.mean_field.fit import longest_mission
from lawn_sb3.scenario import PRESETS, Scenario
from tests.game.random_play import SEEDS, random_play, scenarios

PAPER = PRESETS["paper"]
REPLAY: dict[str, Any] = {"buffer_size": 2000, "batch_size": 16, "learning_starts": 8, "seed": 0, "device": "cpu"}
KINDS: dict[str, tuple[Any, str]] = {"iql": (IQL, "in_time_q"), "qmix": (QMIX, "in_time_mixer")}
EACH = pytest.mark.parametrize("name", KINDS)


def games(name: str, slack: int | None = 0) -> FlatVecEnv:
    continuation = KINDS[name][0].continuation
    return make_vec_env(PAPER, 4, seed=1, continuation=continuation, extras=["clock"], slack=slack)


def built(name: str, slack: int | None = 0, **more: Any) -> Any:
    algorithm, policy = KINDS[name]
    made: Any = find_policy(policy)
    return algorithm(made, games(name, slack), policy_kwargs={"net_arch": [16]}, **REPLAY, **more)


@given(scenario=scenarios(), seed=SEEDS, slack=st.none() | st.integers(0, 2), slots=st.integers(0, 4))
@settings(max_examples=40)
def test_the_mask_made_of_the_observation_is_that_of_the_game(
    scenario: Scenario, seed: int, slack: int | None, slots: int
) -> None:
    simulator, observer = Simulator(scenario, 2, seed), Observer(scenario, extras=["clock"])
    for _ in random_play(simulator, seed, slots):
        simulator.go_on()
    flat = th.as_tensor(observer.flat(simulator.state)).flatten(0, 1)
    made = in_time(scenario, observer.layout, flat, slack)
    np.testing.assert_array_equal(made.numpy(), simulator.allowed_moves(slack).reshape(len(flat), -1))


def test_draws_are_allowed_and_reach_every_allowed_action() -> None:
    allowed = th.tensor([True, False, True, True]).repeat(400, 1)
    assert set(draw_actions(allowed, 4, (400,)).tolist()) == {0, 2, 3}
    assert set(draw_actions(None, 4, (400,)).tolist()) == {0, 1, 2, 3}


@EACH
@pytest.mark.parametrize("deterministic", [True, False])
def test_no_move_is_late_whether_greedy_or_exploring(name: str, deterministic: bool) -> None:
    model = built(name)
    model.exploration_rate = 1.0
    env = model.env
    obs = env.reset()
    for _ in range(6):
        actions, _ = model.predict(obs, deterministic=deterministic)
        flying = env.flying()
        assert env.action_masks()[np.arange(len(actions)), actions][flying].all()
        obs, *_ = env.step(actions)


@EACH
def test_training_arrives_always_and_plays_in_time(name: str) -> None:
    model = built(name)
    slots: list[int] = []

    def tell(local: dict[str, Any], _: object) -> bool:
        slots.extend(info["episode"]["l"] for info in local["infos"] if "episode" in info)
        return True

    model.learn(400, callback=tell)
    assert model._n_updates > 0
    rows = evaluate(ModelPlayer(model, name), PAPER, 10, seed=3)
    assert (rows.slots == rows.min_slots).all()
    assert max(slots) <= longest_mission(PAPER)


@EACH
def test_values_of_late_moves_are_finite_and_never_a_target(name: str) -> None:
    model = built(name, gamma=1.0)
    model.learn(200)
    policy = model.policy.learners[0] if name == "iql" else model.policy
    obs = th.as_tensor(np.asarray(model.env.reset()))
    seen = obs[:, model.env.games[0].layout.seen(("clock",))]
    values = policy.q_net(seen)
    allowed = policy.allowed(seen)
    assert (values[~allowed] == FORBIDDEN).all()
    assert values[allowed].min() > FORBIDDEN / 2
    if name == "qmix":
        targets = model.target_values(model.replay_buffer.sample(64))
        assert targets.abs().max() < 1e3


def test_slack_with_a_policy_that_knows_no_mask_is_refused(tmp_path: Any) -> None:
    method = Method(label="IQL", algo="iql", policy="local_q", env_steps=10, slack=0)
    cell = Cell("iql", method, 0, PAPER, Evaluation(), tmp_path)
    with pytest.raises(UserError, match=r"method 'iql': policy local_q knows no in-time moves"):
        build_model(cell)


@EACH
def test_a_model_is_saved_and_loaded_with_its_mask(name: str, tmp_path: Any) -> None:
    model = built(name)
    model.save(tmp_path / "model")
    again = KINDS[name][0].load(tmp_path / "model", env=games(name))
    obs = np.asarray(model.env.reset())
    np.testing.assert_array_equal(model.predict(obs, deterministic=True)[0], again.predict(obs, deterministic=True)[0])
