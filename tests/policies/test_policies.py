"""Actor-critics of ``policies/``: what their actors and critics see, and how deep and wide they are."""

from typing import Any

import numpy as np
import pytest
import torch as th
from torch import nn

from lawn_sb3.algos.mappo import MAPPO, CTDEPolicy
from policies.centralized_critic import CentralizedCriticPolicy
from policies.congestion_blind import CongestionBlindPolicy
from policies.local_critic import LocalCriticPolicy
from policies.state_critic import StateCriticPolicy
from tests.algos.small import NUM_GAMES, ROLLOUT, SMALL, learner, replaced, small_env, some_observations

POLICIES = [CentralizedCriticPolicy, StateCriticPolicy, LocalCriticPolicy, CongestionBlindPolicy]
CRITIC_SEES_X = {CentralizedCriticPolicy, StateCriticPolicy, CongestionBlindPolicy}
CRITIC_SEES_O = {CentralizedCriticPolicy, LocalCriticPolicy, CongestionBlindPolicy}
CASES = [(policy, trained) for policy in POLICIES for trained in (False, True)]


def case_name(case: tuple[type[CTDEPolicy], bool]) -> str:
    return f"{case[0].__name__}-{'trained' if case[1] else 'untrained'}"


@pytest.fixture(scope="module", params=CASES, ids=case_name)
def policy(request: pytest.FixtureRequest) -> CTDEPolicy:
    """Each policy as it is built and after a little training."""
    policy_class, trained = request.param
    # An untrained one keeps SB3's value layer: MAPPO's answers 0 before the first rollout, whatever the state.
    model: MAPPO = learner(policy_class, normalize_value=trained, policy_kwargs={})
    built = (model.learn(3 * ROLLOUT) if trained else model).policy
    assert isinstance(built, CTDEPolicy)
    built.set_training_mode(False)
    return built


def probabilities(policy: CTDEPolicy, flat: np.ndarray) -> np.ndarray:
    with th.no_grad():
        distribution: Any = policy.get_distribution(th.as_tensor(flat)).distribution
    return np.asarray(distribution.probs)


def values(policy: CTDEPolicy, flat: np.ndarray) -> np.ndarray:
    with th.no_grad():
        return policy.predict_values(th.as_tensor(flat)).numpy().ravel()


def test_no_single_number_of_the_global_state_reaches_the_actor(policy: CTDEPolicy) -> None:
    flat = th.as_tensor(some_observations()).requires_grad_()
    distribution: Any = policy.get_distribution(flat).distribution
    distribution.logits[:, 0].sum().backward()
    assert flat.grad is not None
    assert (flat.grad[:, policy.layout.state] == 0.0).all()
    reached = (flat.grad[:, policy.layout.local] != 0.0).any(dim=0)
    loads = th.zeros_like(reached)
    loads[policy.layout.cell_loads] = True
    hidden = loads if isinstance(policy, CongestionBlindPolicy) else th.zeros_like(reached)
    assert th.equal(reached, ~hidden)


def test_every_number_that_a_critic_is_to_see_reaches_it_and_no_other(policy: CTDEPolicy) -> None:
    flat = th.as_tensor(some_observations()).requires_grad_()
    policy.predict_values(flat).sum().backward()  # type: ignore[no-untyped-call]
    assert flat.grad is not None
    reached = (flat.grad != 0.0).any(dim=0)
    assert (reached[policy.layout.state] == (type(policy) in CRITIC_SEES_X)).all()
    assert (reached[policy.layout.local] == (type(policy) in CRITIC_SEES_O)).all()


def test_only_a_critic_that_sees_o_knows_whose_value_is_asked(policy: CTDEPolicy) -> None:
    flat = small_env(seed=0).reset()
    assert isinstance(flat, np.ndarray)
    by_game = values(policy, flat).reshape(NUM_GAMES, SMALL.num_uavs)
    spread = np.ptp(by_game, axis=1)
    assert np.ptp(by_game[:, 0]) > 1e-3  # different games, different values
    if type(policy) not in CRITIC_SEES_O:
        np.testing.assert_allclose(spread, 0.0, atol=1e-6)
    else:
        assert (spread > 1e-4).all()


def test_actor_and_critic_have_two_hidden_layers_of_256_relu_units(policy: CTDEPolicy) -> None:
    layout = policy.layout
    critic_dim = layout.state_dim * (type(policy) in CRITIC_SEES_X) + layout.local_dim * (type(policy) in CRITIC_SEES_O)
    for network, input_dim in (
        (policy.mlp_extractor.policy_net, layout.local_dim),
        (policy.mlp_extractor.value_net, critic_dim),
    ):
        assert [type(layer) for layer in network] == [nn.Linear, nn.ReLU, nn.Linear, nn.ReLU]
        assert [(layer.in_features, layer.out_features) for layer in network[::2]] == [(input_dim, 256), (256, 256)]
    logits: Any = policy.action_net
    assert (logits.in_features, logits.out_features) == (256, 63)
    last: Any = policy.value_net if isinstance(policy.value_net, nn.Linear) else policy.value_net.linear
    assert (last.in_features, last.out_features) == (256, 1)


def test_actor_and_critic_share_no_parameter(policy: CTDEPolicy) -> None:
    flat = th.as_tensor(some_observations())
    policy.zero_grad(set_to_none=True)
    policy.predict_values(flat).sum().backward()  # type: ignore[no-untyped-call]
    touched = {name for name, parameter in policy.named_parameters() if parameter.grad is not None}
    assert touched
    assert all(name.startswith(("mlp_extractor.value_net", "value_net")) for name in touched)


def test_the_blind_actor_is_blind_to_the_loads_alone() -> None:
    policy = learner(CongestionBlindPolicy).policy
    assert isinstance(policy, CTDEPolicy)
    flat = some_observations()
    np.testing.assert_array_equal(
        probabilities(policy, replaced(flat, policy.layout.cell_loads)), probabilities(policy, flat)
    )
    rates = replaced(flat, policy.layout.ema_rate)
    assert (np.abs(probabilities(policy, rates) - probabilities(policy, flat)).max(axis=1) > 1e-8).all()


@pytest.mark.parametrize("policy_class", POLICIES)
def test_training_changes_actor_and_critic(policy_class: type[CTDEPolicy]) -> None:
    flat, model = some_observations(), learner(policy_class)
    assert isinstance(model.policy, CTDEPolicy)
    before = probabilities(model.policy, flat), values(model.policy, flat)
    model.learn(3 * ROLLOUT)
    assert not np.allclose(probabilities(model.policy, flat), before[0], atol=1e-6)
    assert not np.allclose(values(model.policy, flat), before[1], atol=1e-3)
