"""Updates in bfloat16: of every variant of MAPPO, of the networks alone, and never of play."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch as th
from torch import nn

from lawn_sb3.algos.imitate import Imitate
from lawn_sb3.algos.mappo import MAPPO, EpisodeMAPPO, MaskableMAPPO, RecurrentMAPPO
from lawn_sb3.algos.mappo.precision import networks_in
from lawn_sb3.envs import make_vec_env
from policies.centralized_critic import CentralizedCriticPolicy
from policies.knows_clock import KnowsClockPolicy
from policies.masked import MaskedPolicy
from policies.recurrent import RecurrentPolicy
from policies.separate_actors import SeparateActorsPolicy
from policies.set_critic import SetCriticPolicy
from tests.algos.small import NUM_GAMES, ROLLOUT, SMALL, VECTOR, learner, parameters, small_env

SETTINGS: dict[str, Any] = {"n_steps": 16, "batch_size": 128, "n_epochs": 2, "seed": 0, "device": "cpu"}
WHOLE: dict[str, Any] = {"continuation": "episode", "extras": ["clock"], "slack": 0}
TAUGHT = {"teacher": "best-route", "taught_fraction": 1.0}

VARIANTS: dict[str, tuple[type, Any, dict[str, Any], dict[str, Any]]] = {
    "plain": (MAPPO, CentralizedCriticPolicy, {}, {}),
    "stock": (MAPPO, "MlpPolicy", {}, {}),
    "stock-raw": (MAPPO, "MlpPolicy", {}, {"normalize_value": False}),
    "set": (MAPPO, SetCriticPolicy, {}, {"clip_apart": True}),
    "separate": (MAPPO, SeparateActorsPolicy, {"extras": ["index"]}, {}),
    "masked": (MaskableMAPPO, MaskedPolicy, {}, {}),
    "recurrent": (RecurrentMAPPO, RecurrentPolicy, {}, {}),
    "episodes": (EpisodeMAPPO, KnowsClockPolicy, WHOLE, {"policy_kwargs": {"reluctance": 1.0}}),
    "taught": (Imitate, KnowsClockPolicy, WHOLE, TAUGHT),
}
"""Algorithm, policy, environment and settings."""


@pytest.fixture(params=VARIANTS)
def variant(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


def untrained(variant: str, **settings: Any) -> Any:
    algorithm, policy, games, own = VARIANTS[variant]
    return algorithm(policy, make_vec_env(SMALL, NUM_GAMES, seed=1, **games), **SETTINGS, **own, **settings)


class Answers:
    """Precisions in which the layers of a policy answered, in play and in training."""

    def __init__(self, policy: nn.Module) -> None:
        self.seen: dict[bool, set[th.dtype]] = {False: set(), True: set()}
        for layer in policy.modules():
            if isinstance(layer, nn.Linear | nn.LSTM):
                layer.register_forward_hook(self.note)

    def note(self, layer: nn.Module, _: Any, answer: Any) -> None:
        self.seen[layer.training].add((answer[0] if isinstance(answer, tuple) else answer).dtype)


def test_networks_are_trained_in_bfloat16_and_play_in_float32(variant: str) -> None:
    model = untrained(variant, autocast="bfloat16")
    answers, before = Answers(model.policy), parameters(model)
    model.learn(ROLLOUT)
    assert answers.seen[False] == {th.float32}
    assert th.bfloat16 in answers.seen[True]
    after = parameters(model)
    assert not np.array_equal(after, before)
    assert np.isfinite(after).all()
    moments = (moment for state in model.policy.optimizer.state.values() for moment in state.values())
    assert {tensor.dtype for tensor in (*model.policy.parameters(), *moments)} == {th.float32}


def test_the_first_rollout_is_that_of_float32_and_its_update_is_not(variant: str) -> None:
    lower, full = (untrained(variant, autocast=choice).learn(1) for choice in ("bfloat16", None))
    for stored in ("observations", "actions", "values", "log_probs"):
        np.testing.assert_array_equal(getattr(lower.rollout_buffer, stored), getattr(full.rollout_buffer, stored))
    assert not np.array_equal(parameters(lower), parameters(full))


def test_answers_are_near_those_of_float32_and_in_float32() -> None:
    model = learner(autocast="bfloat16").learn(ROLLOUT)
    batch = next(model.rollout_buffer.get(128))
    asked = batch.observations, batch.actions.long().flatten()
    full = model.policy.evaluate_actions(*asked)
    with networks_in("bfloat16", model.policy):
        lower = model.policy.evaluate_actions(*asked)
    for one, other in zip(full, lower, strict=True):
        assert other.dtype == th.float32
        assert not th.equal(one, other)
        assert th.allclose(one, other, atol=0.02 * one.abs().max().item())
    for one, other in zip(full, model.policy.evaluate_actions(*asked), strict=True):
        assert th.equal(one, other)  # outside of an update nothing is left of it


def test_a_minibatch_sees_the_weights_that_the_one_before_left() -> None:
    """Torch keeps the weights that it cast for as long as its ``autocast`` lasts."""
    full, lower = (
        learner(autocast=choice, n_epochs=8, learning_rate=3e-3).learn(ROLLOUT) for choice in (None, "bfloat16")
    )
    start = parameters(learner())
    one, other = (parameters(model) - start for model in (full, lower))
    assert one @ other / np.sqrt((one @ one) * (other @ other)) > 0.9


def test_a_loaded_model_goes_on_in_bfloat16(tmp_path: Path) -> None:
    learner(autocast="bfloat16").learn(ROLLOUT).save(tmp_path / "model.zip")
    loaded: Any = MAPPO.load(tmp_path / "model.zip", env=small_env(), device="cpu")
    answers = Answers(loaded.policy)
    loaded.learn(VECTOR)
    assert th.bfloat16 in answers.seen[True]
    learner().save(tmp_path / "full.zip")
    assert MAPPO.load(tmp_path / "full.zip", device="cpu").autocast is None


def test_another_precision_is_refused() -> None:
    with pytest.raises(ValueError, match="autocast = 'float16': bfloat16, or left out for float32"):
        learner(autocast="float16")
