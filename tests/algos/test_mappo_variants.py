"""What the variants of MAPPO add: masks, memory, actors of their own, and a critic that takes any number of UAVs."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch as th

from lawn_sb3.algos.mappo import MAPPO, MaskableMAPPO, RecurrentMAPPO
from lawn_sb3.envs import make_vec_env
from lawn_sb3.envs.observation import OWN
from policies.centralized_critic import CentralizedCriticPolicy
from policies.masked import MaskedPolicy
from policies.recurrent import RecurrentPolicy
from policies.separate_actors import SeparateActorsPolicy
from policies.set_critic import SetCriticPolicy
from tests.algos.small import N_STEPS, NUM_GAMES, ROLLOUT, SMALL, learner, small_env

WIDER = SMALL.changed(num_uavs=5)


def variant(algorithm: type, policy: type, **kwargs: Any) -> Any:
    return algorithm(policy, small_env(), n_steps=N_STEPS, batch_size=128, n_epochs=1, seed=0, device="cpu", **kwargs)


@pytest.mark.parametrize(("algorithm", "policy"), [(MaskableMAPPO, MaskedPolicy), (RecurrentMAPPO, RecurrentPolicy)])
def test_minibatches_hold_returns_in_normalised_units(algorithm: type, policy: type) -> None:
    model = variant(algorithm, policy).learn(ROLLOUT)
    buffer, head = model.rollout_buffer, model._value_head
    returns = np.concatenate([batch.returns[_real(batch)].numpy() for batch in buffer.get(64)])
    np.testing.assert_allclose(np.sort(returns), np.sort((buffer.returns.ravel() - head.mean.item()) / head.std.item()))
    assert abs(returns.mean()) < 1e-5
    assert abs(returns.std() - 1.0) < 1e-5


def _real(batch: Any) -> Any:
    """Which entries of a minibatch are no padding."""
    return batch.mask > 0.5 if hasattr(batch, "mask") else slice(None)


@pytest.mark.parametrize(("algorithm", "policy"), [(MaskableMAPPO, MaskedPolicy), (RecurrentMAPPO, RecurrentPolicy)])
def test_without_value_normalisation_returns_keep_reward_units(algorithm: type, policy: type) -> None:
    model = variant(algorithm, policy, normalize_value=False).learn(ROLLOUT)
    returns = np.concatenate([batch.returns[_real(batch)].numpy() for batch in model.rollout_buffer.get(64)])
    np.testing.assert_array_equal(np.sort(returns), np.sort(model.rollout_buffer.returns.ravel()))


@pytest.mark.filterwarnings("ignore:You have specified a mini-batch size")
@pytest.mark.parametrize(("algorithm", "policy"), [(MaskableMAPPO, MaskedPolicy), (RecurrentMAPPO, RecurrentPolicy)])
def test_a_last_minibatch_of_one_row_leaves_numbers(algorithm: type, policy: type) -> None:
    env = make_vec_env(SMALL, num_games=1)
    model: Any = algorithm(policy, env, n_steps=8, batch_size=5, n_epochs=1, seed=0, device="cpu").learn(16)
    assert all(bool(th.isfinite(values).all()) for values in model.policy.parameters())


def test_moves_that_training_took_end_inside_the_airspace() -> None:
    model = variant(MaskableMAPPO, MaskedPolicy).learn(ROLLOUT)
    buffer, layout = model.rollout_buffer, model.policy.layout
    table = model.env.get_attr("simulator", [0])[0].rules.actions
    voxels = np.rint(buffer.observations[:, layout.position] * 10).astype(int)
    ends = voxels + table[buffer.actions.astype(int).ravel()]
    assert ((ends >= 0) & (ends < SMALL.grid)).all()


def test_an_actor_with_memory_acts_on_what_it_saw_and_forgets_it_when_a_mission_starts() -> None:
    model = variant(RecurrentMAPPO, RecurrentPolicy)
    flat = small_env(seed=3).reset()
    fresh = None, np.ones(len(flat), dtype=bool)
    _, nothing_seen = model.predict(flat, *fresh, deterministic=True)
    _, seen_twice = model.predict(flat, nothing_seen, np.zeros(len(flat), dtype=bool), deterministic=True)
    assert not np.allclose(nothing_seen[0], seen_twice[0])
    _, started = model.predict(flat, seen_twice, np.ones(len(flat), dtype=bool), deterministic=True)
    np.testing.assert_array_equal(started[0], nothing_seen[0])


def test_each_uav_is_answered_by_its_own_actor() -> None:
    env = make_vec_env(SMALL, NUM_GAMES, seed=0, extras=["index"])
    model = learner(SeparateActorsPolicy, env)
    flat = th.as_tensor(env.reset())

    def logits() -> Any:
        with th.no_grad():
            return model.policy.get_distribution(flat).distribution.logits

    before = logits()
    with th.no_grad():
        for weight in model.policy.mlp_extractor.policy_net.networks[1].parameters():
            weight.add_(0.1)
    changed = (logits() != before).any(dim=1).reshape(NUM_GAMES, SMALL.num_uavs)
    assert changed.numpy().tolist() == [[False, True]] * NUM_GAMES


def test_the_index_stands_between_o_and_x_and_names_the_slots_uav() -> None:
    plain, indexed = make_vec_env(SMALL, 3, seed=0), make_vec_env(SMALL, 3, seed=0, extras=["index"])
    layout = indexed.get_attr("layout", [0])[0]
    rows, columns = np.asarray(indexed.reset()), layout.extra("index")
    assert (columns.start, columns.stop) == (layout.local.stop, layout.state.start)
    np.testing.assert_array_equal(rows[:, columns], np.tile(np.eye(2), (3, 1)))
    np.testing.assert_array_equal(np.delete(rows, columns, axis=1), plain.reset())


def some_values(model: Any, flat: Any) -> Any:
    with th.no_grad():
        return model.policy.predict_values(th.as_tensor(flat)).numpy().ravel()


def test_a_critic_over_a_set_knows_no_order_of_the_uavs() -> None:
    model = learner(SetCriticPolicy, make_vec_env(WIDER, NUM_GAMES, seed=0), normalize_value=False)
    layout = model.policy.layout
    flat = np.asarray(model.env.reset())
    shuffled = flat.copy()
    uavs = flat[:, layout.state][:, layout.state_uavs].reshape(len(flat), -1, OWN)
    order = np.random.default_rng(0).permutation(WIDER.num_uavs)
    columns = slice(layout.state.start, layout.state.start + OWN * WIDER.num_uavs)
    shuffled[:, columns] = uavs[:, order].reshape(len(flat), -1)
    np.testing.assert_allclose(some_values(model, shuffled), some_values(model, flat), atol=1e-5)
    moved = flat.copy()
    moved[:, columns.start] += 0.5  # the first UAV's x
    assert (np.abs(some_values(model, moved) - some_values(model, flat)) > 1e-6).any()


@pytest.mark.parametrize("num_uavs", [1, 5])
def test_a_critic_over_a_set_loads_and_learns_on_among_any_number_of_uavs(tmp_path: Path, num_uavs: int) -> None:
    small = learner(SetCriticPolicy).learn(ROLLOUT)
    small.save(tmp_path / "model.zip")
    env = make_vec_env(SMALL.changed(num_uavs=num_uavs), NUM_GAMES, seed=0)
    other: Any = MAPPO.load(tmp_path / "model.zip", env=env)
    for name, weight in small.policy.state_dict().items():
        assert th.equal(other.policy.state_dict()[name], weight), name
    assert other.policy.layout.num_uavs == num_uavs
    before = {name: weight.clone() for name, weight in other.policy.state_dict().items()}
    other.learn(N_STEPS * NUM_GAMES * num_uavs)
    assert any(not th.equal(weight, before[name]) for name, weight in other.policy.state_dict().items())


def test_a_critic_of_x_does_not_load_among_another_number_of_uavs(tmp_path: Path) -> None:
    learner(CentralizedCriticPolicy).save(tmp_path / "model.zip")
    with pytest.raises(ValueError, match=r"trained for ObservationLayout\(num_uavs=2.*do not fit .*num_uavs=5"):
        MAPPO.load(tmp_path / "model.zip", env=make_vec_env(WIDER, NUM_GAMES))
