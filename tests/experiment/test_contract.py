"""The contract of policies: what is let through, what is refused, and that training notices nothing of it."""

from __future__ import annotations

import inspect
import random
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch as th
from sb3_contrib.qrdqn.policies import QRDQNPolicy, QuantileNetwork
from stable_baselines3 import DQN
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
from stable_baselines3.common.torch_layers import create_mlp
from stable_baselines3.dqn.policies import DQNPolicy, QNetwork
from torch import nn

from lawn_sb3.algos.mappo import MAPPO, CTDEPolicy, MaskableCTDEPolicy, RecurrentCTDEPolicy
from lawn_sb3.algos.qmix import QMIXPolicy
from lawn_sb3.envs import make_vec_env
from lawn_sb3.envs.observation import EXTRAS
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.contract import check_policy, policy_error, where
from lawn_sb3.experiment.policies import find_policy
from lawn_sb3.experiment.registry import REPOSITORY, algorithm_for, find_algorithm
from lawn_sb3.scenario import Scenario
from tests.algos.games import STEP
from tests.algos.small import NUM_GAMES, ROLLOUT, SMALL, parameters

HERE = "tests/experiment/test_contract.py"
SHIPPED = sorted(path.stem for path in (REPOSITORY / "policies").glob("[!_]*.py"))
REPLAY = {"buffer_size": 800, "batch_size": 32, "target_update_interval": 10, "learning_starts": 4 * STEP}
SETTINGS: dict[str, dict[str, Any]] = {
    "mappo": {"n_steps": 16, "batch_size": 128, "n_epochs": 2, "policy_kwargs": {"net_arch": [32, 32]}},
    "iql": {**REPLAY, "policy_kwargs": {"net_arch": [32]}},
    "qmix": {**REPLAY, "policy_kwargs": {"net_arch": [32, 32]}},
}


def built(policy: type[BasePolicy], scenario: Scenario = SMALL, **kwargs: Any) -> BaseAlgorithm:
    """A small untrained model with a policy, of the algorithm that takes it."""
    name = algorithm_for(policy)
    assert name is not None
    algorithm: Any = find_algorithm(name, policy)
    with_index = getattr(policy, "needs_index", False)
    extras = [sight for sight in getattr(policy, "sees", ()) if sight in EXTRAS]
    env = make_vec_env(scenario, NUM_GAMES, continuation=algorithm.continuation, with_index=with_index, extras=extras)
    model: BaseAlgorithm = algorithm(policy, env, seed=0, device="cpu", **{**SETTINGS[name], **kwargs})
    return model


def refusal(model: BaseAlgorithm) -> str:
    """Why a model's policy is refused: one line that begins with its name and its file."""
    with pytest.raises(UserError) as refused:
        check_policy(model, "mine")
    message = str(refused.value)
    begin = f"policy 'mine' ({HERE}"
    assert message.startswith(begin)
    assert "\n" not in message
    return message.removeprefix(begin)


# --- what is let through -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SHIPPED)
def test_every_policy_that_ships_keeps_the_contract_before_and_after_training(name: str) -> None:
    model = built(find_policy(name))
    check_policy(model, name)
    before = parameters(model)
    model.learn(2 * ROLLOUT)
    assert not np.array_equal(parameters(model), before)
    check_policy(model, name)


class Good(CTDEPolicy):
    def critic_input(self, flat: th.Tensor) -> th.Tensor:
        return flat


class TimesZero(Good):
    """Takes all of [o_i | x], with x multiplied by 0."""

    def seen(self, flat: th.Tensor) -> th.Tensor:
        seen = th.zeros_like(flat)
        seen[:, self.layout.local] = 1.0
        return flat * seen


class OnAClone(Good):
    """Wipes x out of a copy of what it was given."""

    def seen(self, flat: th.Tensor) -> th.Tensor:
        seen = flat.clone()
        seen[:, self.layout.state] = 0.0
        return seen


class Masking(Good):
    """Rules out every odd action: its logit is minus infinity."""

    def _get_action_dist_from_latent(self, latent_pi: th.Tensor) -> Any:
        odd = th.arange(63) % 2 == 1
        return self.action_dist.proba_distribution(self.action_net(latent_pi).masked_fill(odd, -th.inf))


class Dropping(Good):
    """Dropout and layer norm in the actor: random while it trains, but from torch's own random state."""

    def _build_mlp_extractor(self) -> None:
        super()._build_mlp_extractor()
        extractor: Any = self.mlp_extractor
        extractor.policy_net.append(nn.LayerNorm(32)).append(nn.Dropout(0.5))


class Overflowing(Good):
    """A critic that is finite on what really happens and infinite on a hundred times as much."""

    def critic_input(self, flat: th.Tensor) -> th.Tensor:
        return flat.exp()


class Rooted(Good):
    """Breaks down when a weight that starts at 0 falls below it."""

    def _build_mlp_extractor(self) -> None:
        self.scale = nn.Parameter(th.zeros(20))
        super()._build_mlp_extractor()

    def seen(self, flat: th.Tensor) -> th.Tensor:
        return flat[:, self.layout.local] + self.scale.sqrt().sum()


@pytest.mark.parametrize("policy", [Good, TimesZero, OnAClone, Masking, Dropping, Overflowing, Rooted])
def test_what_does_not_read_x_is_let_through(policy: type[BasePolicy]) -> None:
    check_policy(built(policy), "mine")


@pytest.mark.parametrize("name", ["centralized_critic", "local_q", "monotonic_mixer"])
def test_a_uav_that_is_alone_is_let_through_too(name: str) -> None:
    check_policy(built(find_policy(name), SMALL.changed(num_uavs=1)), name)


@pytest.mark.parametrize("setting", ["share_parameters", "double_q"])
def test_every_kind_of_iql_is_let_through(setting: str) -> None:
    check_policy(built(find_policy("local_q"), SMALL, **{setting: True}), "local_q")


# --- actors that read x --------------------------------------------------------------------------------------------


class All(Good):
    def seen(self, flat: th.Tensor) -> th.Tensor:
        return flat


class ABit(Good):
    """One number of o_i is shifted by a ten-thousandth of the whole of x."""

    def seen(self, flat: th.Tensor) -> th.Tensor:
        local = flat[:, self.layout.local].clone()
        local[:, 0] += 1e-4 * flat[:, self.layout.state].sum(dim=1)
        return local


class LastColumn(Good):
    """Reads the height of a GBS, the last number of x: the same in all games."""

    def seen(self, flat: th.Tensor) -> th.Tensor:
        return th.cat([flat[:, self.layout.local], flat[:, self.layout.state][:, -1:]], dim=1)


class Threshold(Good):
    """Has no gradient with respect to x."""

    def seen(self, flat: th.Tensor) -> th.Tensor:
        return th.cat([flat[:, self.layout.local], (flat[:, self.layout.state][:, :1] > 0.45).float()], dim=1)


def first_of_x(policy: CTDEPolicy | QMIXPolicy, obs: Any) -> th.Tensor:
    """An action [B] that depends on x alone: the first UAV's first coordinate in voxels."""
    x: th.Tensor = obs[:, policy.layout.state]
    return (10 * x[:, 0]).long().abs() % 63


class InPredictAlone(Good):
    def _predict(self, observation: Any, deterministic: bool = False) -> th.Tensor:
        return first_of_x(self, observation)


class WhenSamplingAlone(Good):
    def _predict(self, observation: Any, deterministic: bool = False) -> th.Tensor:
        return super()._predict(observation, True) if deterministic else first_of_x(self, observation)


class InRolloutsAlone(Good):
    def forward(self, obs: th.Tensor, deterministic: bool = False) -> tuple[th.Tensor, th.Tensor, th.Tensor]:
        _, values, log_probs = super().forward(obs, deterministic)
        return first_of_x(self, obs), values, log_probs


class InUpdatesAlone(Good):
    def evaluate_actions(self, obs: Any, actions: th.Tensor) -> tuple[th.Tensor, th.Tensor, th.Tensor | None]:
        values, log_probs, entropy = super().evaluate_actions(obs, actions)
        return values, log_probs + 1e-3 * obs[:, self.layout.state.start], entropy


class Recurrent(RecurrentCTDEPolicy):
    def seen(self, flat: th.Tensor) -> th.Tensor:
        return flat

    def critic_input(self, flat: th.Tensor) -> th.Tensor:
        return flat


class Maskable(MaskableCTDEPolicy):
    def seen(self, flat: th.Tensor) -> th.Tensor:
        return flat

    def critic_input(self, flat: th.Tensor) -> th.Tensor:
        return flat


class Additive(QMIXPolicy):
    def make_mixer(self) -> nn.Module:
        return Sum()


class Sum(nn.Module):
    def forward(self, q: th.Tensor, state: th.Tensor) -> th.Tensor:
        return q.sum(dim=1)


class QReadsX(Additive):
    """Acts on its Qs of o_i shifted by a little of x."""

    def _predict(self, observation: Any, deterministic: bool = False) -> th.Tensor:
        local = observation[:, self.layout.local] + 1e-3 * observation[:, self.layout.state][:, :1]
        greedy: th.Tensor = self.q_net(local).argmax(dim=1)
        return greedy


class ActsOnX(Additive):
    """Asks no network at all."""

    def _predict(self, observation: Any, deterministic: bool = False) -> th.Tensor:
        return first_of_x(self, observation)


# Two slots of eight games of two UAVs are 32 rows, all of which change unless x is rounded.
@pytest.mark.parametrize(
    ("policy", "changed"),
    [
        (All, "32 of 32 action distributions change when x becomes that of another game"),
        (ABit, r"\d+ of 32 action distributions change when x becomes that of another game"),
        (LastColumn, "32 of 32 action distributions change when x becomes noise;"),
        (Threshold, r"\d+ of 32 action distributions change when x becomes that of another game"),
        (InPredictAlone, r"\d+ of 32 greedy actions change"),
        (WhenSamplingAlone, r"\d+ of 32 sampled actions change"),
        (InRolloutsAlone, r"\d+ of 32 actions of rollouts change"),
        (InUpdatesAlone, r"\d+ of 32 log-probabilities of updates change"),
        (Recurrent, "32 of 32 action distributions change"),
        (Maskable, "32 of 32 action distributions change"),
        (QReadsX, r"\d+ of \d+ action values change"),
        (ActsOnX, r"\d+ of 32 greedy actions change"),
    ],
)
def test_an_actor_that_reads_x_is_refused(policy: type[BasePolicy], changed: str) -> None:
    message = refusal(built(policy))
    assert re.match(rf"\): its actor reads the global state x: {changed}", message)
    assert "once training has moved" not in message


def test_the_actor_of_a_stock_policy_reads_x() -> None:
    model = MAPPO("MlpPolicy", make_vec_env(SMALL, NUM_GAMES), n_steps=16, batch_size=128, seed=0, device="cpu")
    with pytest.raises(UserError, match=r"^policy 'MlpPolicy' \(.*stable_baselines3.*policies.py\): .* reads the glob"):
        check_policy(model, "MlpPolicy")


def test_a_policy_of_another_kind_is_refused() -> None:
    model = DQN("MlpPolicy", make_vec_env(SMALL, NUM_GAMES), buffer_size=100, device="cpu")
    with pytest.raises(UserError, match=r"^policy 'MlpPolicy' \(.*\): a DQNPolicy is none of the kinds of policy that"):
        check_policy(model, "MlpPolicy")


class Gated(Good):
    """Lets x in through a gate that is 0 until training opens it."""

    def _build_mlp_extractor(self) -> None:
        self.gate = nn.Parameter(th.zeros(1))
        super()._build_mlp_extractor()

    def seen(self, flat: th.Tensor) -> th.Tensor:
        return th.cat([flat[:, self.layout.local], self.gate * flat[:, self.layout.state]], dim=1)


def test_a_gate_that_is_0_is_seen_through_and_once_trained_it_is_a_plain_reading() -> None:
    model = built(Gated)
    flat = th.as_tensor(model.get_env().reset())  # type: ignore[union-attr]
    policy: Any = model.policy
    before = policy.get_distribution(flat).distribution.logits
    other = flat.clone()
    other[:, policy.layout.state] = 1.0
    assert policy.get_distribution(other).distribution.logits.equal(before)  # nothing shows yet
    assert "once training has moved its weights" in refusal(model)
    assert policy.gate.item() == 0.0  # put back
    model.learn(2 * ROLLOUT)
    assert policy.gate.item() != 0.0
    message = refusal(model)
    assert "reads the global state x: 32 of 32 action distributions change when x becomes that of another" in message
    assert "once training" not in message


class ReadsLater(Good):
    """Reads x once it has been updated more than a few times."""

    updates: th.Tensor

    def _build_mlp_extractor(self) -> None:
        self.register_buffer("updates", th.zeros(1))
        super()._build_mlp_extractor()

    def seen(self, flat: th.Tensor) -> th.Tensor:
        x = flat[:, self.layout.state]
        return th.cat([flat[:, self.layout.local], x * (self.updates > 4) if hasattr(self, "updates") else x], dim=1)

    def evaluate_actions(self, obs: Any, actions: th.Tensor) -> tuple[th.Tensor, th.Tensor, th.Tensor | None]:
        self.updates += 1
        return super().evaluate_actions(obs, actions)


def test_what_shows_only_after_training_is_found_after_training() -> None:
    model = built(ReadsLater)
    for _ in range(3):
        check_policy(model, "mine")
    model.learn(2 * ROLLOUT)  # 8 updates: two rollouts, two epochs, two minibatches
    assert "reads the global state x: 32 of 32 action distributions" in refusal(model)


# --- widths --------------------------------------------------------------------------------------------------------


class ActorOf62(Good):
    num_answers = 62

    def _build(self, lr_schedule: Any) -> None:
        super()._build(lr_schedule)
        self.action_net = nn.Linear(32, self.num_answers)


class ActorOf64(ActorOf62):
    num_answers = 64


class MaskableOf62(MaskableCTDEPolicy):
    def critic_input(self, flat: th.Tensor) -> th.Tensor:
        return flat

    def _build(self, lr_schedule: Any) -> None:
        super()._build(lr_schedule)
        self.action_net = nn.Linear(32, 62)


class CriticOf2(Good):
    def _build(self, lr_schedule: Any) -> None:
        super()._build(lr_schedule)
        self.value_net = nn.Linear(32, 2)


class CriticWithoutColumn(Good):
    def predict_values(self, obs: Any) -> th.Tensor:
        return super().predict_values(obs)[:, 0]


class QOf64(DQNPolicy):
    def make_q_net(self) -> QNetwork:
        net = super().make_q_net()
        net.q_net = nn.Sequential(*create_mlp(net.features_dim, 64, [32]))
        return net


class FiveQuantiles(QuantileNetwork):
    def forward(self, obs: Any) -> th.Tensor:
        return super().forward(obs)[:, :5]


class TooFewQuantiles(QRDQNPolicy):
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **{**kwargs, "n_quantiles": 8})

    def make_quantile_net(self) -> QuantileNetwork:
        return FiveQuantiles(**self._update_features_extractor(self.net_args, features_extractor=None))


class TeamQOf62(Additive):
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.q_net = nn.Sequential(nn.Linear(self.layout.local_dim, 62))


class Column(nn.Module):
    def forward(self, q: th.Tensor, state: th.Tensor) -> th.Tensor:
        return q.sum(dim=1, keepdim=True)


class ColumnMixer(QMIXPolicy):
    def make_mixer(self) -> nn.Module:
        return Column()


class TwoActions(Good):
    def _predict(self, observation: Any, deterministic: bool = False) -> th.Tensor:
        return super()._predict(observation, deterministic).repeat(2)


class NoSuchAction(Good):
    def _predict(self, observation: Any, deterministic: bool = False) -> th.Tensor:
        return super()._predict(observation, deterministic) + 63


@pytest.mark.parametrize(
    ("policy", "wrong"),
    [
        (ActorOf62, "actor answers with 62 numbers, the game has 63 actions"),
        (ActorOf64, "actor answers with 64 numbers, the game has 63 actions"),
        (MaskableOf62, "actor answers with 62 numbers, the game has 63 actions"),
        (CriticOf2, "critic answers with 2 numbers, allowed is 1, the value of the slot"),
        (CriticWithoutColumn, r"critic answers with the shape \[16\] in place of \[16, 1\]"),
        (QOf64, "Q-network answers with 64 numbers, the game has 63 actions"),
        (TeamQOf62, "Q-network answers with 62 numbers, the game has 63 actions"),
        (
            TooFewQuantiles,
            r"shape \[8, 5, 63\] in place of \[8, 8, 63\], the game has 63 actions and its policy 8 quan",
        ),
        (ColumnMixer, r"mixer answers with the shape \[8, 1\] in place of \[8\], one value a game"),
        (TwoActions, r"greedy actions for 16 slots have the shape \[32\]"),
        (NoSuchAction, r"lie between \d+ and \d+, allowed is a whole number from 0 to 62"),
    ],
)
def test_an_answer_of_the_wrong_width_is_refused(policy: type[BasePolicy], wrong: str) -> None:
    with pytest.raises(UserError, match=rf"^policy 'mine' \({HERE}\): its .*{wrong}"):
        check_policy(built(policy), "mine")


# --- numbers, and company ------------------------------------------------------------------------------------------


class NanActor(Good):
    def seen(self, flat: th.Tensor) -> th.Tensor:
        return flat[:, self.layout.local] / 0.0


class NanCritic(Good):
    def critic_input(self, flat: th.Tensor) -> th.Tensor:
        return flat.log()  # of positions and rates that are 0


class NanMixer(Sum):
    def forward(self, q: th.Tensor, state: th.Tensor) -> th.Tensor:
        return super().forward(q, state) * th.nan


class NanTeam(QMIXPolicy):
    def make_mixer(self) -> nn.Module:
        return NanMixer()


@pytest.mark.parametrize(("policy", "who"), [(NanActor, "actor"), (NanCritic, "critic"), (NanTeam, "mixer")])
def test_answers_that_are_no_numbers_are_refused(policy: type[BasePolicy], who: str) -> None:
    with pytest.raises(
        UserError, match=rf"\({HERE}\): its {who} answers \d+ of \d+ real observations with NaN or infinity"
    ):
        check_policy(built(policy), "mine")


class NormedCritic(Good):
    """Batch norm: in play it has statistics of its own, in updates it takes those of the batch."""

    def _build_mlp_extractor(self) -> None:
        super()._build_mlp_extractor()
        extractor: Any = self.mlp_extractor
        extractor.value_net.insert(0, nn.BatchNorm1d(self.layout.flat_dim))


class NormedActor(Good):
    def _build_mlp_extractor(self) -> None:
        super()._build_mlp_extractor()
        extractor: Any = self.mlp_extractor
        extractor.policy_net.insert(0, nn.BatchNorm1d(self.layout.local_dim))


class AveragingCritic(Good):
    def critic_input(self, flat: th.Tensor) -> th.Tensor:
        return flat - flat.mean(dim=0)


class Peeking(Good):
    """The actor sees the o_j of the slot before: another UAV's, as long as slots come game by game."""

    def seen(self, flat: th.Tensor) -> th.Tensor:
        local = flat[:, self.layout.local]
        return th.cat([local, local.roll(1, dims=0)], dim=1)


class FollowTheFirst(Peeking):
    """Every second actor sees the o_j of the first UAV of its game, which sees its own alone."""

    def seen(self, flat: th.Tensor) -> th.Tensor:
        local = flat[:, self.layout.local]
        return th.cat([local, local[th.arange(len(local)) // 2 * 2]], dim=1)


class NormedQ(DQNPolicy):
    def make_q_net(self) -> QNetwork:
        net = super().make_q_net()
        net.q_net.insert(0, nn.BatchNorm1d(net.features_dim))
        return net


class MeanMixer(nn.Module):
    def forward(self, q: th.Tensor, state: th.Tensor) -> th.Tensor:
        return q.sum(dim=1) - q.mean()


class MeanTeam(QMIXPolicy):
    def make_mixer(self) -> nn.Module:
        return MeanMixer()


@pytest.mark.parametrize(
    ("policy", "what"),
    [
        (NormedCritic, "values"),
        (NormedActor, "action distributions"),
        (AveragingCritic, "values"),
        (Peeking, "action distributions"),
        (FollowTheFirst, "action distributions"),
        (NormedQ, "action values"),
        (MeanTeam, "values of games"),
    ],
)
def test_an_answer_that_depends_on_the_other_slots_is_refused(policy: type[BasePolicy], what: str) -> None:
    assert f" {what} change when the other slots of the batch do" in refusal(built(policy))


class Experts(Good):
    """Sends each row to one of two networks, so that the size of their batches depends on the other rows."""

    def _build_mlp_extractor(self) -> None:
        super()._build_mlp_extractor()
        self.experts = nn.ModuleList(nn.Linear(self.layout.local_dim, 32) for _ in range(2))

    def _get_action_dist_from_latent(self, latent_pi: th.Tensor) -> Any:
        second = latent_pi[:, 0] > latent_pi[:, 1]
        logits = latent_pi.new_empty(len(latent_pi), 63)
        logits[second] = self.action_net(latent_pi[second])
        logits[~second] = -self.action_net(latent_pi[~second])
        return self.action_dist.proba_distribution(logits)


class Rounding(Good):
    """The other slots change how a slot's value is rounded, as they may where experts share out the rows."""

    def critic_input(self, flat: th.Tensor) -> th.Tensor:
        return flat * (1.0 + 1e-5 * flat[:, :1].mean())


@pytest.mark.parametrize("policy", [Experts, Rounding])
def test_other_slots_may_change_how_an_answer_is_rounded(policy: type[BasePolicy]) -> None:
    check_policy(built(policy), "mine")


class Overwriting(Good):
    """Hides x from its actor by wiping it out for everybody, the critic and the rollout included."""

    def seen(self, flat: th.Tensor) -> th.Tensor:
        flat[:, self.layout.state] = 0.0
        return flat


def test_a_policy_that_writes_into_its_observations_is_refused() -> None:
    assert "it writes into the observations that it is given" in refusal(built(Overwriting))


class OwnDice(Good):
    """Adds noise from a random state of its own."""

    def seen(self, flat: th.Tensor) -> th.Tensor:
        return flat[:, self.layout.local] + float(np.random.default_rng().normal())


def test_an_actor_with_a_random_state_of_its_own_is_refused() -> None:
    assert "change when the same is asked again with the same seeds" in refusal(built(OwnDice))


# --- it leaves no trace --------------------------------------------------------------------------------------------


def seed_all(seed: int) -> None:
    random.seed(seed)
    np.random.seed(seed)
    th.manual_seed(seed)


ONE_EACH = ["centralized_critic", "masked", "recurrent", "local_q", "quantile_q", "monotonic_mixer"]


@pytest.mark.parametrize("policy", [*map(find_policy, ONE_EACH), Dropping], ids=lambda policy: policy.__name__)
def test_a_checked_training_gives_the_same_weights_and_goes_on_with_the_same_random_numbers(
    policy: type[BasePolicy],
) -> None:
    after = []
    for checked in (False, True):
        model = built(policy)
        seed_all(5)
        for _ in range(2):
            if checked:
                check_policy(model, "mine")
            model.learn(ROLLOUT, reset_num_timesteps=False)
        if checked:
            check_policy(model, "mine")
        after.append([*parameters(model), random.random(), np.random.random(), th.rand(1).item()])
    np.testing.assert_array_equal(after[0], after[1])


def test_weights_modes_random_states_and_games_stay_as_they_were_even_when_a_policy_is_refused() -> None:
    for policy in (Good, Gated, NormedCritic):
        model = built(policy)
        seed_all(5)
        model.policy.set_training_mode(True)
        env: Any = model.get_env()
        env.reset()
        seen = env.get_attr("simulator", [0])[0].state.position.copy()
        weights = parameters(model)
        states = random.getstate(), np.random.get_state(legacy=False)["state"]["key"].copy(), th.get_rng_state()
        if policy is Good:
            check_policy(model, "mine")
        else:
            refusal(model)
        assert all(part.training for part in model.policy.modules())
        np.testing.assert_array_equal(parameters(model), weights)
        assert random.getstate() == states[0]
        np.testing.assert_array_equal(np.random.get_state(legacy=False)["state"]["key"], states[1])
        assert th.get_rng_state().equal(states[2])
        with pytest.raises(ValueError, match="invalid values"):  # torch checks its distributions again
            th.distributions.Categorical(logits=th.tensor([th.nan]))
        np.testing.assert_array_equal(env.get_attr("simulator", [0])[0].state.position, seen)


def test_the_number_of_threads_stays_as_it_was() -> None:
    model = built(Good)
    th.set_num_threads(2)
    try:
        check_policy(model, "mine")
        assert th.get_num_threads() == 2
    finally:
        th.set_num_threads(1)


# --- errors --------------------------------------------------------------------------------------------------------


class MisspeltLater(Good):
    def predict_values(self, obs: Any) -> th.Tensor:
        return self.layuot  # type: ignore[return-value]


class Changing(Good):
    """Sees another number of columns than it was built for, though only in batches."""

    def critic_input(self, flat: th.Tensor) -> th.Tensor:
        return flat if len(flat) == 1 else flat[:, 1:]


class Silent(Good):
    def predict_values(self, obs: Any) -> th.Tensor:
        raise ValueError


class Verbose(Good):
    def predict_values(self, obs: Any) -> th.Tensor:
        raise ValueError("first line\nsecond line")


def line_of(function: Any, text: str) -> int:
    """Where a text stands in this file, inside a function."""
    source, begin = inspect.getsourcelines(function)
    return begin + next(k for k, line in enumerate(source) if text in line)


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (
            "def critic_input(self, flat):\n        return flat[:, self.layout.cel_loads]",
            ", line 5): AttributeError: 'ObservationLayout' object has no attribute 'cel_loads' "
            "(did you mean 'cell_loads'?)",
        ),
        ("pass", "): NotImplementedError: Broken does not say what its critic sees: override critic_input"),
        (
            "def __init__(self, observation_space):\n        pass",
            "): TypeError: Broken.__init__() got an unexpected keyword argument 'use_sde'",
        ),
        (
            "def __init__(self, observation_space, action_space, lr_schedule, **kwargs):\n        self.absent()",
            ", line 5): AttributeError: 'Broken' object has no attribute 'absent'",
        ),
    ],
)
def test_an_error_while_a_policy_is_built_becomes_one_line_with_file_line_and_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, body: str, expected: str
) -> None:
    (tmp_path / "policies").mkdir()
    source = f"from lawn_sb3.algos.mappo import CTDEPolicy\n\nclass Broken(CTDEPolicy):\n    {body}\n"
    (tmp_path / "policies" / "broken_contract.py").write_text(source, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    policy = find_policy("broken_contract")
    with pytest.raises((AttributeError, NotImplementedError, TypeError)) as raised:
        built(policy)
    assert str(policy_error(raised.value, policy, "mine")) == f"policy 'mine' (policies/broken_contract.py{expected}"


@pytest.mark.parametrize(
    ("policy", "function", "text", "reason"),
    [
        (MisspeltLater, MisspeltLater.predict_values, "layuot", r"AttributeError: .*\(did you mean 'layout'\?\)"),
        (Silent, Silent.predict_values, "raise", "ValueError"),
        (Verbose, Verbose.predict_values, "raise", "ValueError: first line"),
        (Changing, None, "", r"RuntimeError: mat1 and mat2 shapes cannot be multiplied \(16x\d+ and \d+x32\)"),
    ],
)
def test_an_error_while_a_policy_is_asked_becomes_one_line(
    policy: type[BasePolicy], function: Any, text: str, reason: str
) -> None:
    line = f", line {line_of(function, text)}" if function is not None else ""
    with pytest.raises(UserError, match=rf"^policy 'mine' \({HERE}{line}\): {reason}$"):
        check_policy(built(policy), "mine")


def test_a_users_error_raised_by_a_policy_keeps_its_words() -> None:
    error = UserError("net_arch = []: at least one layer")
    assert str(policy_error(error, Good, "mine")) == f"policy 'mine' ({HERE}): net_arch = []: at least one layer"


def test_a_class_is_placed_by_its_file_or_else_by_its_module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert where(find_policy("state_critic")) == "policies/state_critic.py"
    (tmp_path / "policies").mkdir()
    (tmp_path / "policies" / "placed.py").write_text(
        "from policies.state_critic import StateCriticPolicy\n\n\nclass Placed(StateCriticPolicy):\n    pass\n"
    )
    monkeypatch.chdir(tmp_path)
    assert where(find_policy("placed")) == "policies/placed.py"
    made_by_hand: Any = type("ByHand", (ActorCriticPolicy,), {"__module__": "nowhere"})
    assert where(made_by_hand) == "module nowhere"
    assert "line" not in str(policy_error(ValueError("no"), made_by_hand, "mine"))
