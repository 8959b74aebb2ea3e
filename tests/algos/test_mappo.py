"""MAPPO: what it adds to SB3's PPO, and that all of it is saved and loaded."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch as th
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.utils import LinearSchedule
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

from lawn_sb3.algos.mappo import MAPPO, CTDEPolicy
from lawn_sb3.algos.mappo.value_normalization import NormalizedValueHead
from policies.centralized_critic import CentralizedCriticPolicy
from policies.state_critic import StateCriticPolicy
from tests.algos.small import ROLLOUT, acts, learner, parameters, small_env, some_observations


def test_a_loaded_model_values_states_the_same_and_learns_on_with_its_statistics(tmp_path: Path) -> None:
    trained = learner(ent_coef=0.01).learn(3 * ROLLOUT)
    trained.save(tmp_path / "model.zip")
    loaded: Any = MAPPO.load(tmp_path / "model.zip", env=small_env(), device="cpu")
    head, same, flat = trained.policy.value_net, loaded.policy.value_net, th.as_tensor(some_observations())
    assert head.std.item() > 0.0
    assert (same.mean.item(), same.std.item()) == (head.mean.item(), head.std.item())
    with th.no_grad():
        mine, theirs = (model.policy.predict_values(flat) for model in (trained, loaded))
    assert mine.std() > 0.0
    assert theirs.equal(mine)
    buffer = loaded.rollout_buffer
    loaded.learn(ROLLOUT, reset_num_timesteps=False)
    assert buffer.value_head is loaded.policy.value_net is same
    assert same.mean.item() == pytest.approx(buffer.returns.mean(dtype=np.float64))
    assert buffer.values.std() > 0.0  # the critic answered in reward units from the first slot on
    assert loaded.ent_coef == 0.01


def test_plain_ppo_and_other_layers_survive_save_and_load(tmp_path: Path) -> None:
    policy_kwargs = {"net_arch": {"pi": [16], "vf": [24, 8]}}
    model = learner(StateCriticPolicy, normalize_value=False, policy_kwargs=policy_kwargs).learn(ROLLOUT)
    model.save(tmp_path / "model.zip")
    loaded, observations = MAPPO.load(tmp_path / "model.zip", device="cpu"), some_observations()
    assert isinstance(loaded.policy, StateCriticPolicy)
    assert isinstance(loaded.policy.value_net, NormalizedValueHead)
    assert (loaded.policy.value_net.mean.item(), loaded.policy.value_net.std.item()) == (0.0, 1.0)
    assert acts(loaded, observations) == acts(model, observations)
    np.testing.assert_array_equal(parameters(loaded), parameters(model))


def test_without_value_normalisation_it_is_plain_ppo() -> None:
    layout = small_env().get_attr("layout", 0)[0]
    settings: dict[str, Any] = {"n_steps": 16, "batch_size": 128, "n_epochs": 2, "seed": 0, "device": "cpu"}
    policy_kwargs = {"layout": layout, "net_arch": {"pi": [32, 32], "vf": [32, 32]}}
    ppo: Any = PPO(CentralizedCriticPolicy, small_env(), policy_kwargs=policy_kwargs, **settings)
    ppo.learn(3 * ROLLOUT)
    np.testing.assert_array_equal(parameters(learner(normalize_value=False).learn(3 * ROLLOUT)), parameters(ppo))
    normalised = learner().learn(3 * ROLLOUT)
    action_nets = [model.policy.action_net.weight for model in (ppo, normalised)]
    assert not action_nets[0].equal(action_nets[1])


class AtUpdates(BaseCallback):
    def __init__(self) -> None:
        super().__init__()
        self.logged: list[dict[str, Any]] = []

    def _on_step(self) -> bool:
        return True

    def _note(self) -> None:
        optimiser: Any = self.model.policy.optimizer
        noted = dict(self.logger.name_to_value)
        noted["optimiser/learning_rate"] = optimiser.param_groups[0]["lr"]
        if "train/ent_coef" in noted:
            self.logged.append(noted)

    def _on_rollout_start(self) -> None:
        self._note()

    def _on_training_end(self) -> None:
        self._note()


def test_entropy_coefficient_and_learning_rate_anneal_with_their_schedules() -> None:
    seen = AtUpdates()
    model = learner(ent_coef=lambda left: 0.02 * left, learning_rate=lambda left: 1e-3 * left)
    assert model.ent_coef == 0.02
    model.learn(4 * ROLLOUT, callback=seen)
    assert [noted["train/ent_coef"] for noted in seen.logged] == pytest.approx([0.015, 0.01, 0.005, 0.0])
    rates = [noted["optimiser/learning_rate"] for noted in seen.logged]
    assert rates == pytest.approx([7.5e-4, 5e-4, 2.5e-4, 0.0])
    assert model.ent_coef == 0.0


def test_the_entropy_coefficient_reaches_the_loss() -> None:
    plain, annealed, constant = (
        parameters(learner(ent_coef=coefficient).learn(2 * ROLLOUT))
        for coefficient in (0.0, lambda left: 0.1 * (left > 0.25), 0.1)
    )
    assert not np.array_equal(plain, annealed)
    assert not np.array_equal(annealed, constant)


def test_schedules_survive_save_and_load(tmp_path: Path) -> None:
    learner(ent_coef=LinearSchedule(0.02, 0.0, 1.0)).save(tmp_path / "model.zip")
    seen = AtUpdates()
    MAPPO.load(tmp_path / "model.zip", env=small_env(), device="cpu").learn(2 * ROLLOUT, callback=seen)
    assert [noted["train/ent_coef"] for noted in seen.logged] == pytest.approx([0.01, 0.0])


def test_return_statistics_are_logged() -> None:
    seen = AtUpdates()
    model = learner().learn(2 * ROLLOUT, callback=seen)
    assert seen.logged[-1]["train/return_mean"] == model.policy.value_net.mean.item()
    assert seen.logged[-1]["train/return_std"] == model.policy.value_net.std.item()


@pytest.mark.parametrize("normalize_value", [True, False])
def test_the_stock_mlp_policy_learns_too(normalize_value: bool, tmp_path: Path) -> None:
    model = learner("MlpPolicy", normalize_value=normalize_value)
    before = parameters(model)
    model.learn(2 * ROLLOUT).save(tmp_path / "model.zip")
    assert not np.array_equal(parameters(model), before)
    observations = some_observations()
    for env in (None, small_env()):
        assert acts(MAPPO.load(tmp_path / "model.zip", env, "cpu"), observations) == acts(model, observations)


@pytest.mark.parametrize("wrapper", [VecMonitor, VecNormalize])
def test_the_layout_is_found_through_sb3_s_wrappers(wrapper: Any) -> None:
    env = small_env()
    model = learner(env=wrapper(env))
    assert model.policy.layout == env.get_attr("layout", 0)[0]
    model.learn(ROLLOUT)


def test_a_policy_must_say_what_its_critic_sees() -> None:
    with pytest.raises(NotImplementedError, match=r"CTDEPolicy .* override critic_input"):
        learner(CTDEPolicy)


# --- what MAPPO's own code does otherwise --------------------------------------------------------------------------


def gradient_norms(model: Any) -> tuple[float, float]:
    """Of the last update's gradients: the actor's and the critic's."""
    actor, critic = model.policy.mlp_extractor.policy_net, model.policy.mlp_extractor.value_net
    parts = [actor, model.policy.action_net], [critic, model.policy.value_net]
    gradients = [th.cat([one.grad.flatten() for part in both for one in part.parameters()]) for both in parts]
    return gradients[0].norm().item(), gradients[1].norm().item()


def test_gradients_are_clipped_together_as_in_sb3_or_each_by_itself_as_in_mappos_own_code(tmp_path: Path) -> None:
    together, apart = (learner(max_grad_norm=1e-4, clip_apart=choice).learn(ROLLOUT) for choice in (False, True))
    assert np.hypot(*gradient_norms(together)) == pytest.approx(1e-4, rel=1e-2)
    assert gradient_norms(apart) == pytest.approx((1e-4, 1e-4), rel=1e-2)
    assert apart.max_grad_norm == 1e-4
    apart.save(tmp_path / "model.zip")
    loaded: Any = MAPPO.load(tmp_path / "model.zip", env=small_env(), device="cpu")
    assert gradient_norms(loaded.learn(ROLLOUT)) == pytest.approx((1e-4, 1e-4), rel=1e-2)


def test_advantages_are_normalised_once_a_rollout_where_asked_for() -> None:
    model = learner(normalize_per_rollout=True).learn(ROLLOUT)
    advantages = model.rollout_buffer.advantages
    assert (advantages.mean(), advantages.std()) == (pytest.approx(0.0, abs=1e-6), pytest.approx(1.0, rel=1e-4))
    assert not model.normalize_advantage  # SB3's, once a minibatch
    assert learner().learn(ROLLOUT).rollout_buffer.advantages.std() != pytest.approx(1.0, rel=1e-2)
