"""QMIX: its update worked out by hand, its exploration, and a replay that knows who flies."""

from typing import Any

import numpy as np
import pytest
import torch as th
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecNormalize
from torch.nn import functional

from lawn_sb3.algos.qmix import QMIX, JointSamples, QMIXPolicy
from policies.centralized_critic import CentralizedCriticPolicy
from policies.monotonic_mixer import MonotonicMixerPolicy
from tests.algos.games import Countdown
from tests.algos.small import VECTOR, acts, small_env, some_observations, team, whole_games


def a_batch(model: QMIX, **changes: Any) -> JointSamples:
    return model.replay_buffer.sample(64)._replace(**changes)


def by_hand(model: QMIX, batch: JointSamples) -> th.Tensor:
    """Targets, one game and one UAV after the other."""
    policy, targets = model.policy, []
    for g in range(len(batch.rewards)):
        chosen = th.zeros(1, 2)
        for i in range(2):
            if batch.next_flying[g, i]:
                own, theirs = policy.q_net(batch.next_local[g, i]), policy.q_net_target(batch.next_local[g, i])
                chosen[0, i] = theirs[(own if model.double_q else theirs).argmax()]
        value = 0.0 if batch.game_over[g] else policy.mixer_target(chosen, batch.next_state[g : g + 1])[0]
        targets.append(batch.rewards[g] + model.gamma * value)
    return th.stack(targets)


@pytest.mark.parametrize("double_q", [True, False])
def test_targets_are_team_reward_and_the_target_mix_of_those_who_fly_on(double_q: bool) -> None:
    model = team(double_q=double_q, target_update_interval=30, gamma=0.9, learning_rate=1e-2).learn(100 * VECTOR)
    batch = a_batch(model)
    assert batch.next_flying.any(dim=1).logical_not().any()  # some games are over
    assert (batch.next_flying.sum(dim=1) == 1).any()  # in some one UAV has arrived
    with th.no_grad():
        assert model.target_values(batch).allclose(by_hand(model, batch), atol=1e-5)
    other = team(double_q=not double_q)
    other.policy.load_state_dict(model.policy.state_dict())
    other.gamma = model.gamma
    assert not other.target_values(batch).allclose(model.target_values(batch), atol=1e-5)


def test_a_game_that_is_over_is_worth_its_reward_alone() -> None:
    model = team(gamma=0.9).learn(30 * VECTOR)
    nobody, over = th.zeros(64, 2, dtype=th.bool), th.ones(64)
    batch = a_batch(model, next_flying=nobody, game_over=over)
    assert model.target_values(batch).equal(batch.rewards)


def test_one_update_is_a_clipped_step_down_the_huber_loss() -> None:
    settings: dict[str, Any] = {"learning_rate": 0.5, "max_grad_norm": 0.01, "target_update_interval": 10_000}
    settings["policy_kwargs"] = {"net_arch": [16], "optimizer_class": th.optim.SGD}
    model = team(learning_starts=10_000, **settings).learn(40 * VECTOR)
    state = np.random.get_state()
    batch = model.replay_buffer.sample(32)
    twin = team(**settings)
    twin.policy.load_state_dict(model.policy.state_dict())
    values = twin.policy.game_values(batch.local, batch.state, batch.actions, batch.flying)
    functional.huber_loss(values, model.target_values(batch)).backward()  # type: ignore[no-untyped-call]
    gradient = th.cat([parameter.grad.ravel() for parameter in twin.policy.trained_parameters()])
    assert gradient.norm() > 0.01
    before = th.cat([parameter.detach().ravel() for parameter in model.policy.trained_parameters()])
    np.random.set_state(state)
    model._update_current_progress_remaining(0, 1)
    model.train(gradient_steps=1, batch_size=32)
    after = th.cat([parameter.detach().ravel() for parameter in model.policy.trained_parameters()])
    assert (after - before).allclose(-0.5 * 0.01 * gradient / gradient.norm(), atol=1e-6)


def test_targets_stand_still_between_their_updates_and_copy_then() -> None:
    model = team(target_update_interval=10, learning_starts=VECTOR).learn(5 * VECTOR)

    def gap() -> float:
        pairs = zip(model.policy.trained_parameters(), model.policy.target_parameters(), strict=True)
        return float(max((mine - theirs).abs().max().item() for mine, theirs in pairs))

    before = [parameter.clone() for parameter in model.policy.target_parameters()]
    done = model._n_updates
    model.train(9 - done, 32)
    assert all(a.equal(b) for a, b in zip(before, model.policy.target_parameters(), strict=True))
    assert gap() > 0.0
    model.train(1, 32)
    assert gap() == 0.0


def test_tau_moves_the_targets_part_of_the_way() -> None:
    model = team(target_update_interval=1, tau=0.25, learning_starts=10_000).learn(20 * VECTOR)
    before = [parameter.clone() for parameter in model.policy.target_parameters()]
    model.train(1, 32)
    triples = zip(before, model.policy.trained_parameters(), model.policy.target_parameters(), strict=True)
    for old, trained, new in triples:
        assert new.allclose(0.75 * old + 0.25 * trained, atol=1e-6)


def test_every_uav_tosses_its_own_coin() -> None:
    model, flat = team(), some_observations(1)
    many = flat.repeat(20_000, axis=0)
    greedy = acts(model, flat)[0]
    model.exploration_rate = 0.3
    np.random.seed(0)
    share = np.mean(model.predict(many)[0] != greedy)
    assert share == pytest.approx(0.3 * 62 / 63, abs=0.02)
    assert acts(model, many) == [greedy] * len(many)


class Seen(BaseCallback):
    def __init__(self) -> None:
        super().__init__()
        self.rows: list[tuple[float, float, int]] = []

    def _on_step(self) -> bool:
        assert isinstance(self.model, QMIX)
        rate = self.model.policy.optimizer.param_groups[0]["lr"]
        self.rows.append((self.model.exploration_rate, rate, self.model._n_updates))
        return True


def test_exploration_falls_and_the_learning_rate_anneals_with_their_schedules() -> None:
    seen = Seen()
    model = team(exploration_fraction=0.5, exploration_final_eps=0.1, learning_rate=lambda left: 1e-3 * left)
    model.learn(20 * VECTOR, callback=seen)
    exploration, rates, updates = (np.array(column) for column in zip(*seen.rows, strict=True))
    np.testing.assert_allclose(exploration, np.maximum(1.0 - 0.9 * np.arange(20) / 10, 0.1))
    np.testing.assert_allclose(rates[5:], 1e-3 * (1 - np.arange(5, 20) / 20))
    assert updates.tolist() == [0] * 5 + list(range(1, 16))  # the first four vector steps are played at random


@pytest.mark.parametrize(("anew", "steps"), [(True, [12, 6]), (False, [6, 18, 12])])
def test_the_replay_knows_who_flies_whether_learning_starts_anew_or_goes_on(anew: bool, steps: list[int]) -> None:
    env = Countdown()
    model = team(env=env, learning_starts=10_000, buffer_size=600)
    for count in steps:  # six agent steps a slot
        model.learn(count, reset_num_timesteps=anew)
        np.testing.assert_array_equal(model.replay_buffer.now_flying, env.clock.slot[:, None] < env.duration)


def test_a_training_stopped_by_a_callback_goes_on_with_whole_games() -> None:
    env = Countdown()
    model = team(env=env, learning_starts=10_000, buffer_size=600)
    model.learn(60, callback=lambda local, _: local["num_collected_steps"] < 1)
    model.learn(24, reset_num_timesteps=False)
    np.testing.assert_array_equal(model.replay_buffer.now_flying, env.clock.slot[:, None] < env.duration)


def test_missions_that_are_renewed_one_by_one_are_refused() -> None:
    with pytest.raises(ValueError, match="needs continuation='episode'") as refusal:
        team(env=small_env())
    assert "\n" not in str(refusal.value)
    with pytest.raises(ValueError, match="needs continuation='episode'"):
        team().set_env(small_env())


def test_environments_and_policies_that_do_not_fit_are_refused() -> None:
    with pytest.raises(ValueError, match="VecNormalize"):
        team(env=VecNormalize(whole_games()))
    with pytest.raises(ValueError, match="layout, from make_vec_env"):
        QMIX(MonotonicMixerPolicy, "CartPole-v1")
    with pytest.raises(ValueError, match="derived from QMIXPolicy"):
        team(CentralizedCriticPolicy)
    with pytest.raises(NotImplementedError, match=r"QMIXPolicy .* override make_mixer"):
        team(QMIXPolicy)
