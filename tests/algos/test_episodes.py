"""MAPPO on whole episodes: what its buffer holds, its masks, credit, imitation; and the symmetric frame."""

import copy
from typing import Any

import numpy as np
import pytest
import torch as th
from gymnasium import spaces

from lawn_sb3.algos.common.encoder import Encoder
from lawn_sb3.algos.imitate import Imitate
from lawn_sb3.algos.mappo import EpisodeMAPPO, FramedPolicy
from lawn_sb3.algos.mappo.episodes import EpisodeBuffer
from lawn_sb3.envs import FlatVecEnv, Observer, make_vec_env
from lawn_sb3.envs.observation import EXTRAS
from lawn_sb3.envs.symmetry import EIGHT, turned
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.find_policy import find_policy
from lawn_sb3.game import Missions, Simulator
from lawn_sb3.scenario import PRESETS, Scenario, load_scenario

PAPER = PRESETS["paper"]
RUNGS = ["nothing", "loads", "clock", "memory", "destinations", "intents", "state"]
SETTINGS: dict[str, Any] = {
    "batch_size": 64, "n_epochs": 1, "seed": 0, "device": "cpu", "gamma": 1.0, "gae_lambda": 1.0, "learning_rate": 1e-3,
    "policy_kwargs": {"net_arch": [16]},
}  # fmt: skip


def rung(name: str) -> type[FramedPolicy]:
    policy = find_policy(f"knows_{name}")
    assert issubclass(policy, FramedPolicy)
    return policy


def games(policy: type[FramedPolicy] = FramedPolicy, scenario: Scenario = PAPER, **more: Any) -> FlatVecEnv:
    extras = [extra for extra in EXTRAS if extra in policy.sees]
    return make_vec_env(scenario, 8, seed=1, continuation="episode", extras=extras, **{"slack": 0, **more})


def observations(policy: type[FramedPolicy], simulator: Simulator) -> th.Tensor:
    observer = Observer(simulator.scenario, extras=[extra for extra in EXTRAS if extra in policy.sees])
    return th.as_tensor(observer.flat(simulator.state)).flatten(0, 1)


@pytest.mark.parametrize("name", RUNGS)
def test_logits_turn_with_the_airspace(name: str) -> None:
    policy_class = rung(name)
    model = EpisodeMAPPO(policy_class, games(policy_class), **SETTINGS)
    tables = model.policy.mlp_extractor.encoder
    rng = np.random.default_rng(0)
    simulator = Simulator(PAPER, 12, seed=3)
    simulator.step(rng.integers(simulator.num_actions, size=(12, 4)))
    state = simulator.state
    with th.no_grad():
        logits = model.policy.mlp_extractor.forward_actor(observations(policy_class, simulator))
        for k, turn in enumerate(EIGHT):
            other = copy.deepcopy(simulator)
            for voxels in (other.state.position, other.state.destination):
                voxels[..., :2] = turned(voxels[..., :2], turn, 10)
            other.state.cell_load[:, tables.cell[k]] = state.cell_load
            other.state.past_load[:, :, tables.cell[k]] = state.past_load
            then = model.policy.mlp_extractor.forward_actor(observations(policy_class, other))
            # Where the place alone leaves a choice of turns, loads may lie otherwise: on a diagonal, going along it.
            here, goal = state.position.reshape(-1, 3), state.destination.reshape(-1, 3)
            unsure = [_on_a_diagonal(a) and _on_a_diagonal(b) for a, b in zip(here, goal, strict=True)]
            apart = (then.gather(1, tables.action[k].expand(len(then), -1)) - logits).abs().amax(dim=1)
            assert apart[~th.as_tensor(unsure)].max() < 1e-5


def _on_a_diagonal(voxel: np.ndarray) -> bool:
    return bool(voxel[0] == voxel[1] or voxel[0] + voxel[1] == 9)


@pytest.mark.parametrize("name", RUNGS[:-1])
def test_nothing_of_x_reaches_an_actor_that_does_not_say_it_sees_it(name: str) -> None:
    policy_class = rung(name)
    model = EpisodeMAPPO(policy_class, games(policy_class), **SETTINGS)
    seen = observations(policy_class, Simulator(PAPER, 5, seed=2))
    changed = seen.clone()
    changed[:, model.policy.layout.state] = 0.5  # type: ignore[union-attr, index]
    layers = model.policy.mlp_extractor
    assert th.equal(layers.forward_actor(seen), layers.forward_actor(changed))
    assert not th.equal(layers.forward_critic(seen), layers.forward_critic(changed))


def test_the_lowest_rung_does_not_look_at_the_loads() -> None:
    for name, looks in (("nothing", False), ("clock", True)):
        layers = EpisodeMAPPO(rung(name), games(rung(name)), **SETTINGS).policy.mlp_extractor
        seen = observations(rung(name), Simulator(PAPER, 5, seed=2))
        changed = seen.clone()
        changed[:, layers.encoder.layout.cell_loads] += 0.5
        assert th.equal(layers.forward_actor(seen), layers.forward_actor(changed)) != looks
        faster = seen.clone()
        faster[:, layers.encoder.layout.ema_rate] += 0.5  # past loads show in the rate
        assert th.equal(layers.forward_actor(seen), layers.forward_actor(faster)) != looks


def test_loads_are_counted_without_oneself_and_shares_as_on_joining() -> None:
    # Both in cell 0, turned to lie last: one other there, and 10 // 2 of 10 RBs; all 10 anywhere else.
    simulator = Simulator(load_scenario("paper", ["num_uavs=2"]))
    simulator.reset(missions=Missions(np.array([[1, 0, 0], [2, 1, 0]]), np.array([[9, 9, 0], [5, 1, 0]])))
    encoder = Encoder(simulator.scenario, Observer(simulator.scenario).layout, symmetric=True)
    features, _ = encoder(th.as_tensor(Observer(simulator.scenario).flat(simulator.state))[0])
    assert features[0, -8:].tolist() == [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.5]


def test_headed_counts_and_memory_are_those_of_the_game() -> None:
    simulator = Simulator(load_scenario("paper", ["num_uavs=3"]))
    origins, destinations = np.array([[0, 0, 0], [9, 9, 0], [5, 1, 0]]), np.array([[9, 8, 0], [9, 1, 0], [9, 0, 0]])
    simulator.reset(missions=Missions(origins, destinations))
    observer = Observer(simulator.scenario, extras=EXTRAS)
    cell = simulator.rules.cell
    headed = observer.headed(simulator.state)[0]
    assert headed.sum(axis=1).tolist() == [2, 2, 2]
    assert headed[0, cell[9, 1, 0]] == 2
    before = simulator.state.cell_load.copy()
    simulator.step(np.zeros((1, 3), dtype=np.int64))
    memory = observer.flat(simulator.state)[0, 0, observer.layout.extra("memory")].reshape(-1, 4)
    np.testing.assert_allclose(memory[0] * 4, before[0])
    assert not memory[1:].any()


def test_whole_episodes_hold_flown_slots_alone_and_undiscounted_returns() -> None:
    model = EpisodeMAPPO(rung("clock"), games(without_reward=["rate", "nav", "col"]), **SETTINGS)
    model.learn(1)
    buffer = model.rollout_buffer
    state = model.env.get_attr("simulator")[0].state  # type: ignore[union-attr]
    assert len(buffer.actions) < buffer.pos * 32  # those that wait are left out
    assert model.num_timesteps % 4 == 0
    assert model.num_timesteps <= buffer.pos * 32
    assert state.position.shape == (8, 4, 3)
    clock = buffer.observations[:, model.policy.layout.extra("clock")][:, 0] * 10  # type: ignore[union-attr, index]
    first = clock.round() == 0
    assert first.sum() == 32  # each of 32 missions begins once
    # The return of a mission's first slot is its utility: the sum of all rewards there are.
    utilities = [info["r"] for info in model.ep_info_buffer]  # type: ignore[union-attr]
    assert len(utilities) == 32


def buffer_of(flying: list[list[bool]], rewards: list[list[float]], values: list[float], **more: Any) -> EpisodeBuffer:
    space = spaces.Box(-1, 1, (1,), np.float32)
    buffer = EpisodeBuffer(1, space, spaces.Discrete(2), "cpu", n_envs=2, **more)
    buffer.reset()
    k = 0
    for flies, reward in zip(flying, rewards, strict=True):
        count = sum(flies)
        rows = np.zeros((count, 1), np.float32), np.zeros(count, np.int64), np.array(values[k : k + count], np.float32)
        buffer.add_slot(
            np.array(flies), np.array(reward, np.float32), *rows, np.zeros(count, np.float32), np.ones((count, 2), bool)
        )
        k += count
    buffer.finish()
    return buffer


def test_returns_and_advantages_worked_out_by_hand() -> None:
    # UAV 0 flies one slot and waits two, in which its team earns 2 and 4; UAV 1 flies all three.
    flying = [[True, True], [False, True], [False, True]]
    rewards = [[1.0, 0.0], [2.0, 0.0], [4.0, 8.0]]
    buffer = buffer_of(flying, rewards, [3.0, 1.0, 2.0, 4.0], gamma=0.5, gae_lambda=1.0)
    # 1 + 0.5 * 2 + 0.25 * 4 = 3; 0.25 * 8 = 2, 0.5 * 8 = 4 and 8.
    assert buffer.returns.tolist() == [3.0, 2.0, 4.0, 8.0]
    assert buffer.advantages.tolist() == [0.0, 1.0, 2.0, 4.0]
    short = buffer_of(flying, rewards, [3.0, 1.0, 2.0, 4.0], gamma=0.5, gae_lambda=0.0)
    assert short.advantages.tolist() == [0.0, 0.0, 0.0, 4.0]  # 0.5 * 2 - 1, 0.5 * 4 - 2 and 8 - 4


def test_equal_seeds_learn_equal_weights_and_other_seeds_others() -> None:
    weights = []
    for seed in (0, 0, 1):
        model = EpisodeMAPPO(rung("clock"), games(), **{**SETTINGS, "seed": seed}).learn(300)
        weights.append(th.cat([part.flatten() for part in model.policy.parameters()]))
    assert th.equal(weights[0], weights[1])
    assert not th.equal(weights[0], weights[2])


@pytest.mark.parametrize("credit", ["own", "team", "difference"])
def test_every_credit_trains(credit: str) -> None:
    model = EpisodeMAPPO(rung("clock"), games(credit=credit), **SETTINGS).learn(300)
    assert model.num_timesteps >= 300


def test_team_reward_is_the_mean_over_the_uavs_of_a_game() -> None:
    own, team = (games(credit=credit) for credit in ("own", "team"))
    own.reset(), team.reset()
    actions = np.zeros(32, dtype=np.int64)
    rewards = own.step(actions)[1].reshape(8, 4)
    np.testing.assert_allclose(team.step(actions)[1].reshape(8, 4), rewards.mean(axis=1, keepdims=True).repeat(4, 1))


def test_games_of_fewer_uavs_leave_only_those_that_fly_in_the_batch() -> None:
    env = games(fewest_uavs=1)
    model = EpisodeMAPPO(rung("clock"), env, **SETTINGS).learn(60)
    episodes = model.ep_info_buffer
    assert episodes is not None
    slots = sum(int(episode["l"]) for episode in episodes)  # those that fly are done once each, the others never
    assert len(model.rollout_buffer.actions) == slots
    assert len(episodes) < 32


def test_an_unknown_credit_is_refused() -> None:
    with pytest.raises(UserError, match="unknown credit 'teams'"):
        games(credit="teams")


def test_imitation_learns_the_teachers_moves() -> None:
    env = games(rung("clock"))
    settings = {**SETTINGS, "n_epochs": 20, "learning_rate": 3e-3, "policy_kwargs": {"net_arch": [64]}}
    model = Imitate(rung("clock"), env, teacher="best-route", taught_fraction=1.0, **settings)
    hits = []
    for _ in range(12):
        model.learn(1, reset_num_timesteps=False)
        hits.append(model.logger.name_to_value["train/imitation_percent"])
    assert hits[-1] > hits[0] + 10.0


def test_an_unknown_teacher_is_refused() -> None:
    with pytest.raises(UserError, match="unknown teacher 'forcast'"):
        Imitate(rung("clock"), games(), teacher="forcast", **SETTINGS)
