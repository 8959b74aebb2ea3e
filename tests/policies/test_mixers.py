"""Mixers: no UAV that raises its Q lowers the game's value."""

import copy

import numpy as np
import pytest
import torch as th
from hypothesis import given, settings
from hypothesis import strategies as st
from torch.nn import functional

from lawn_sb3.algos.qmix import QMIXPolicy
from policies.additive_mixer import AdditiveMixer, AdditiveMixerPolicy
from policies.monotonic_mixer import MonotonicMixer, MonotonicMixerPolicy
from tests.algos.small import VECTOR, team, whole_games

NUM_UAVS, STATE_DIM = 4, 10
numbers = st.floats(-50.0, 50.0, width=32)
qs = st.lists(numbers, min_size=NUM_UAVS, max_size=NUM_UAVS)
states = st.lists(numbers, min_size=STATE_DIM, max_size=STATE_DIM)


def mixer(seed: int, scale: float = 1.0) -> MonotonicMixer:
    """An untrained mixer, its parameters scaled."""
    th.manual_seed(seed)
    built = MonotonicMixer(NUM_UAVS, STATE_DIM).double()
    with th.no_grad():
        for parameter in built.parameters():
            parameter.mul_(scale)
    return built


def mixed(built: th.nn.Module, q: list[float], state: list[float]) -> float:
    with th.no_grad():
        value: float = built(th.tensor([q], dtype=th.float64), th.tensor([state], dtype=th.float64)).item()
    return value


@settings(max_examples=300)
@given(
    qs, states, st.integers(0, NUM_UAVS - 1), st.floats(0.0, 100.0), st.integers(0, 20), st.sampled_from([0.1, 1, 5])
)
def test_the_mix_never_falls_when_any_q_rises_whatever_the_state(
    q: list[float], state: list[float], uav: int, rise: float, seed: int, scale: float
) -> None:
    built, higher = mixer(seed, scale), list(q)
    higher[uav] += rise
    low, high = mixed(built, q, state), mixed(built, higher, state)
    assert high >= low - 1e-9 * max(1.0, abs(low))


@given(qs, states, st.integers(0, 20))
def test_every_q_counts_in_the_mix(q: list[float], state: list[float], seed: int) -> None:
    built, values = mixer(seed), th.tensor([q], dtype=th.float64, requires_grad=True)
    built(values, th.tensor([state], dtype=th.float64)).sum().backward()
    assert values.grad is not None
    assert (values.grad >= 0.0).all()
    if max(abs(number) for number in (*q, *state)) < 5.0:  # farther out ELU is flat to the last digit
        assert (values.grad > 0.0).all()


def test_training_keeps_the_mix_monotonic() -> None:
    model = team().learn(60 * VECTOR)
    assert isinstance(model.policy, QMIXPolicy)
    batch = model.replay_buffer.sample(256)
    q = th.randn(256, 2, requires_grad=True)
    model.policy.mixer(q, batch.state).sum().backward()
    assert q.grad is not None
    assert (q.grad >= 0.0).all()
    assert (q.grad > 0.0).any()


def test_the_monotonic_mix_is_the_one_of_the_papers_equations() -> None:
    built = mixer(3)
    q, state = th.randn(5, NUM_UAVS, dtype=th.float64), th.randn(5, STATE_DIM, dtype=th.float64)
    with th.no_grad():
        for row in range(5):
            weights_in = built.weights_in(state[row]).abs().reshape(NUM_UAVS, -1)
            hidden = functional.elu(q[row] @ weights_in + built.bias_in(state[row]))
            expected = hidden @ built.weights_out(state[row]).abs() + built.bias_out(state[row])
            assert built(q, state)[row].item() == pytest.approx(expected.item())


def test_weights_and_biases_of_the_monotonic_mix_depend_on_the_state() -> None:
    built, state = mixer(0), th.randn(2, STATE_DIM, dtype=th.float64)
    for part in (built.weights_in, built.bias_in, built.weights_out, built.bias_out):
        assert not part(state[0]).allclose(part(state[1]))


@given(qs, states)
def test_the_additive_mix_is_the_sum_whatever_the_state(q: list[float], state: list[float]) -> None:
    assert mixed(AdditiveMixer(), q, state) == pytest.approx(sum(q))


@pytest.mark.parametrize("policy_class", [MonotonicMixerPolicy, AdditiveMixerPolicy])
def test_the_greedy_joint_action_has_the_highest_mix_of_all(policy_class: type[QMIXPolicy]) -> None:
    policy = team(policy_class).learn(30 * VECTOR).policy
    assert isinstance(policy, QMIXPolicy)
    flat = th.as_tensor(np.asarray(whole_games(seed=1).reset())).reshape(-1, 2, policy.layout.flat_dim)
    local, state = flat[..., policy.layout.local], flat[:, 0, policy.layout.state]
    flying = th.ones(len(flat), 2, dtype=th.bool)
    with th.no_grad():
        greedy = policy.greedy_actions(local, flying)
        best = policy.game_values(local, state, greedy, flying)
        for _ in range(50):
            other = th.randint(int(policy.action_space.n), greedy.shape)
            assert (policy.game_values(local, state, other, flying) <= best + 1e-6).all()


@pytest.mark.parametrize("policy_class", [MonotonicMixerPolicy, AdditiveMixerPolicy])
def test_an_arrived_uavs_q_gets_no_gradient_and_does_not_count(policy_class: type[QMIXPolicy]) -> None:
    policy = team(policy_class).policy
    assert isinstance(policy, QMIXPolicy)
    flat = th.as_tensor(np.asarray(whole_games(seed=1).reset())).reshape(-1, 2, policy.layout.flat_dim)
    local, state = flat[..., policy.layout.local].clone().requires_grad_(), flat[:, 0, policy.layout.state]
    flying = th.ones(len(flat), 2, dtype=th.bool)
    flying[::2, 1] = False
    actions = th.zeros(len(flat), 2, dtype=th.long)
    values = policy.game_values(local, state, actions, flying)
    values.sum().backward()  # type: ignore[no-untyped-call]
    assert local.grad is not None
    touched = (local.grad != 0.0).any(dim=2)
    assert touched.equal(flying)
    with th.no_grad():
        elsewhere, others = copy.copy(local.detach()), actions.clone()
        elsewhere[::2, 1] += 3.0
        others[::2, 1] = 5
        assert policy.game_values(elsewhere, state, others, flying).equal(values.detach())


def test_nobody_flying_leaves_the_q_network_without_gradient() -> None:
    policy = team().policy
    assert isinstance(policy, QMIXPolicy)
    local, state = th.zeros(3, 2, policy.layout.local_dim), th.randn(3, policy.layout.state_dim)
    nobody = th.zeros(3, 2, dtype=th.bool)
    policy.game_values(local, state, th.zeros(3, 2, dtype=th.long), nobody).sum().backward()  # type: ignore[no-untyped-call]
    assert all(parameter.grad is None or not parameter.grad.any() for parameter in policy.q_net.parameters())
