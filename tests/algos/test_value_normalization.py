"""Value normalisation: the critic learns in normalised units, and nobody else notices."""

from typing import Any

import numpy as np
import pytest
import torch as th
from hypothesis import given
from hypothesis import strategies as st
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.type_aliases import RolloutBufferSamples
from stable_baselines3.common.vec_env import VecEnvWrapper
from torch import nn

from lawn_sb3.algos.mappo.value_normalization import NormalizedRolloutBuffer, NormalizedValueHead
from tests.algos.small import N_STEPS, ROLLOUT, learner, parameters, small_env, some_observations


class ScaledRewards(VecEnvWrapper):
    def __init__(self, venv: Any, scale: float) -> None:
        super().__init__(venv)
        self.scale = scale

    def reset(self) -> Any:
        return self.venv.reset()

    def step_wait(self) -> Any:
        observations, rewards, dones, infos = self.venv.step_wait()
        return observations, self.scale * rewards, dones, infos


class RecordingBuffer(NormalizedRolloutBuffer):
    """Keeps what it hands out, and what the value head answers while it does."""

    def reset(self) -> None:
        super().reset()
        self.handed_out: list[RolloutBufferSamples] = []

    def _get_samples(self, *args: Any, **kwargs: Any) -> RolloutBufferSamples:
        self.handed_out.append(super()._get_samples(*args, **kwargs))
        return self.handed_out[-1]


def values(model: Any, observations: Any) -> Any:
    """The critic's values in reward units."""
    with th.no_grad():
        return model.policy.predict_values(th.as_tensor(observations)).numpy().ravel()


def head_of(model: Any) -> NormalizedValueHead:
    head = model.policy.value_net
    assert isinstance(head, NormalizedValueHead)
    return head


def some_head(seed: int = 0, width: int = 5) -> NormalizedValueHead:
    th.manual_seed(seed)
    head = NormalizedValueHead(nn.Linear(width, 1))
    head.forget()
    return head


def test_a_new_head_is_the_plain_layer() -> None:
    head, features = NormalizedValueHead(nn.Linear(5, 1)), th.randn(4, 5)
    assert th.equal(head(features), head.linear(features))


def test_before_the_first_statistics_every_value_is_zero_whatever_the_scale_of_the_rewards() -> None:
    head, features = some_head(), th.ones(3, 5)
    assert head(features).tolist() == [[0.0], [0.0], [0.0]]
    with head.normalized_units():
        assert (head(features) != 0.0).all()


def test_a_value_in_reward_units_is_the_mean_plus_normalised_value_times_standard_deviation() -> None:
    head, features = some_head(), th.randn(4, 5)
    head.update(np.array([8.0, 12.0], dtype=np.float32))  # mean 10, standard deviation 2
    np.testing.assert_allclose(
        head(features).detach().numpy(), 10 + 2 * head.linear(features).detach().numpy(), rtol=1e-6
    )
    assert head(features).dtype == th.float32
    with head.normalized_units():
        assert head(features).equal(head.linear(features))
    assert head.normalize(th.tensor([8.0, 10.0, 14.0])).tolist() == [-1.0, 0.0, 2.0]


def test_reward_units_come_back_even_if_an_update_fails() -> None:
    head, features = some_head(), th.ones(1, 5)
    head.update(np.array([8.0, 12.0], dtype=np.float32))
    before = head(features)
    with pytest.raises(RuntimeError), head.normalized_units():
        raise RuntimeError
    assert head(features).equal(before)


# Mean and standard deviation of returns that are not constant but for rounding.
returns_statistics = st.tuples(st.floats(-1e4, 1e4), st.floats(1e-3, 10.0)).map(
    lambda s: (s[0], s[1] * (1 + abs(s[0])))
)


@given(seed=st.integers(0, 1000), statistics=st.lists(returns_statistics, min_size=2, max_size=5))
def test_new_statistics_never_change_a_value_in_reward_units(seed: int, statistics: list[tuple[float, float]]) -> None:
    head, features = some_head(seed), th.randn(16, 5)
    first_mean, first_std = statistics[0]
    head.update(np.array([first_mean - first_std, first_mean + first_std], dtype=np.float32))
    before = head(features).detach().numpy()
    size = max(max(abs(mean), std) for mean, std in statistics)
    for mean, std in statistics[1:]:
        head.update(np.array([mean - std, mean + std], dtype=np.float32))
        np.testing.assert_allclose(head(features).detach().numpy(), before, rtol=0, atol=1e-5 * size)


def test_new_statistics_never_change_a_value_of_a_whole_model() -> None:
    model, observations = learner(), some_observations()
    model.learn(ROLLOUT)
    model.lr_schedule = lambda _: 0.0  # from here on only the statistics change
    before, old_mean = values(model, observations), head_of(model).mean.item()
    assert before.std() > 0.0
    model.learn(ROLLOUT, reset_num_timesteps=False)
    assert head_of(model).mean.item() != old_mean
    np.testing.assert_allclose(values(model, observations), before, rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("constant", [0.0, 0.1, -3.0])
def test_constant_returns_do_not_divide_by_zero(constant: float) -> None:
    head, features = some_head(), th.ones(2, 5)
    returns = np.full(1000, constant, dtype=np.float32)
    head.update(returns)
    assert head.normalize(th.as_tensor(returns)).tolist() == [0.0] * 1000
    np.testing.assert_allclose(head(features).detach().numpy(), constant, rtol=1e-6)

    head.update(np.array([8.0, 12.0], dtype=np.float32))
    before = head(features).detach().numpy()
    head.update(returns)
    assert head.std.item() == 2.0
    np.testing.assert_allclose(head(features).detach().numpy(), before, rtol=1e-5)
    assert head.normalize(th.as_tensor(returns)).tolist() == [0.0] * 1000


def test_learning_without_any_reward_stays_finite() -> None:
    model = learner(env=ScaledRewards(small_env(), 0.0)).learn(3 * ROLLOUT)
    assert np.isfinite(parameters(model)).all()
    assert (values(model, some_observations()) == 0.0).all()


def test_returns_handed_out_have_zero_mean_and_unit_variance_over_the_rollout() -> None:
    model = learner(rollout_buffer_class=RecordingBuffer, n_epochs=1)
    for _ in range(2):
        model.learn(ROLLOUT, reset_num_timesteps=False)
        buffer: Any = model.rollout_buffer
        returns = th.cat([samples.returns for samples in buffer.handed_out]).numpy()
        assert returns.shape == (ROLLOUT,)
        assert returns.mean(dtype=np.float64) == pytest.approx(0.0, abs=1e-5)
        assert returns.std(dtype=np.float64) == pytest.approx(1.0, abs=1e-5)
        raw = buffer.returns.ravel()  # flattened in place by SB3, still in reward units
        np.testing.assert_allclose(np.sort(returns), np.sort((raw - raw.mean()) / raw.std()), atol=1e-4)


def test_advantages_are_handed_out_in_reward_units() -> None:
    model = learner(rollout_buffer_class=RecordingBuffer, n_epochs=1).learn(2 * ROLLOUT)
    buffer: Any = model.rollout_buffer
    advantages = th.cat([samples.advantages for samples in buffer.handed_out]).numpy()
    np.testing.assert_array_equal(np.sort(advantages), np.sort(buffer.advantages.ravel()))
    np.testing.assert_allclose(buffer.advantages, buffer.returns - buffer.values, atol=1e-4)


def test_the_critic_is_trained_in_the_units_of_its_targets() -> None:
    """Before a rollout's first gradient step, new values equal old values: in units, and in statistics."""
    model = learner(rollout_buffer_class=RecordingBuffer, n_epochs=1)
    model.learn(ROLLOUT)
    answers: list[th.Tensor] = []
    hook = head_of(model).register_forward_hook(lambda _, __, output: answers.append(output.detach().flatten()))
    model.learn(ROLLOUT, reset_num_timesteps=False)
    hook.remove()
    buffer: Any = model.rollout_buffer
    num_minibatches = len(buffer.handed_out)
    first_answer, first_minibatch = answers[-num_minibatches], buffer.handed_out[0]
    np.testing.assert_allclose(first_answer.numpy(), first_minibatch.old_values.numpy(), atol=1e-4)
    raw = buffer.values.ravel()
    assert not np.isin(first_minibatch.old_values.numpy(), raw).any()  # normalised units are not reward units


class Rollout(BaseCallback):
    """Copies of the last rollout and of what the critic said of it, taken before the update."""

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        model: Any = self.model
        buffer = model.rollout_buffer
        flat = buffer.observations.reshape(-1, buffer.observations.shape[-1])
        self.values = buffer.values.copy()
        self.critic = values(model, flat).reshape(buffer.values.shape)
        self.last_values = values(model, model._last_obs)
        self.rewards, self.starts = buffer.rewards.copy(), buffer.episode_starts.copy()
        self.last_dones = model._last_episode_starts
        self.advantages, self.returns = buffer.advantages.copy(), buffer.returns.copy()


def test_advantage_estimation_stays_in_reward_units() -> None:
    model, rollout = learner(gamma=0.9, gae_lambda=0.8), Rollout()
    model.learn(3 * ROLLOUT, callback=rollout)
    assert rollout.values.std() > 0.0
    np.testing.assert_allclose(rollout.values, rollout.critic, rtol=1e-5, atol=1e-5)

    # eq:gae: delta_t = r_t + gamma V(t+1) - V(t), A_t = sum_k (gamma lambda)^k delta_{t+k}, cut where a mission ends
    next_values = np.vstack([rollout.critic[1:], rollout.last_values])
    ends = np.vstack([rollout.starts[1:], rollout.last_dones]).astype(bool)
    assert ends.any()
    deltas = rollout.rewards + 0.9 * np.where(ends, 0.0, next_values) - rollout.critic
    expected = np.zeros_like(deltas)
    for t in range(N_STEPS):
        for k in reversed(range(t, N_STEPS)):
            expected[t] = deltas[k] + 0.9 * 0.8 * np.where(ends[k], 0.0, expected[t])
    np.testing.assert_allclose(rollout.advantages, expected, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(rollout.returns, expected + rollout.critic, rtol=1e-4, atol=1e-4)


def test_a_truncated_mission_is_bootstrapped_in_reward_units() -> None:
    class Watch(Rollout):
        """Also the rewards as the environment gave them, and the value of every truncated mission's last state."""

        def _on_rollout_start(self) -> None:
            self.given: list[np.ndarray] = []
            self.bootstrapped = 0

        def _on_step(self) -> bool:
            rewards = self.locals["rewards"].copy()
            for k, info in enumerate(self.locals["infos"]):
                if info.get("TimeLimit.truncated"):
                    rewards[k] += 0.9 * values(self.model, info["terminal_observation"][None])[0]
                    self.bootstrapped += 1
            self.given.append(rewards)
            return True

    model, rollout = learner(env=small_env(timeout="truncated"), gamma=0.9), Watch()
    model.learn(3 * ROLLOUT, callback=rollout)
    assert rollout.bootstrapped > 0
    np.testing.assert_allclose(rollout.rewards, np.array(rollout.given), rtol=1e-5, atol=1e-5)


def trained_on_scaled_rewards(scale: float, **kwargs: Any) -> Any:
    return learner(env=ScaledRewards(small_env(), scale), **kwargs).learn(4 * ROLLOUT)


def weights(model: Any) -> Any:
    """Everything that is learned; the statistics are not."""
    return np.concatenate([parameter.detach().numpy().ravel() for parameter in model.policy.parameters()])


def test_learning_is_the_same_when_every_reward_is_a_thousand_times_as_large() -> None:
    before = weights(learner())
    one, thousand = trained_on_scaled_rewards(1.0), trained_on_scaled_rewards(1000.0)
    learned = np.abs(weights(one) - before).mean()
    np.testing.assert_allclose(weights(thousand), weights(one), rtol=0, atol=0.05 * learned)
    assert head_of(thousand).std.item() == pytest.approx(1000 * head_of(one).std.item(), rel=1e-3)
    observations = some_observations()
    np.testing.assert_allclose(values(thousand, observations), 1000 * values(one, observations), rtol=1e-3, atol=1.0)
    losses = [model.logger.name_to_value["train/value_loss"] for model in (one, thousand)]
    assert losses[0] == pytest.approx(losses[1], rel=1e-3)


def test_without_value_normalisation_learning_depends_on_the_scale_of_the_rewards() -> None:
    one, thousand = (trained_on_scaled_rewards(scale, normalize_value=False) for scale in (1.0, 1000.0))
    learned = np.abs(weights(one) - weights(learner(normalize_value=False))).mean()
    assert np.abs(weights(thousand) - weights(one)).max() > learned


def test_the_optimiser_trains_the_last_layer_of_the_critic() -> None:
    model = learner().learn(ROLLOUT)
    trained = {id(parameter) for group in model.policy.optimizer.param_groups for parameter in group["params"]}
    assert trained == {id(parameter) for parameter in model.policy.parameters()}
