"""The probe of policies: what is let through, and what is refused in one line."""

import inspect
from typing import Any

import numpy as np
import pytest
import torch as th
from sb3_contrib.qrdqn.policies import QRDQNPolicy
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
from stable_baselines3.common.torch_layers import create_mlp
from stable_baselines3.dqn.policies import DQNPolicy, QNetwork
from torch import nn

from lawn_sb3.algos.mappo import MAPPO, MaskableCTDEPolicy, RecurrentCTDEPolicy
from lawn_sb3.algos.qmix import QMIXPolicy
from lawn_sb3.envs import make_vec_env
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.find_policy import find_policy
from lawn_sb3.experiment.policy_errors import policy_error
from lawn_sb3.experiment.probe import check_policy
from lawn_sb3.experiment.registry import REPOSITORY, place
from tests.algos.small import NUM_GAMES, ROLLOUT, SMALL, parameters
from tests.experiment.probed import Good, Masking, NormedCritic, built, wrong_product

SHIPPED = sorted(path.stem for path in (REPOSITORY / "policies").glob("[!_]*.py"))


def refusal(policy: type[BasePolicy]) -> str:
    """Why an untrained model with a policy is refused: one line that begins with its name and its file."""
    model = built(policy)
    with pytest.raises(UserError) as refused:
        check_policy(model, "mine")
    message = str(refused.value)
    begin = f"policy 'mine' ({place(policy)}"
    assert message.startswith(begin)
    assert "\n" not in message
    return message.removeprefix(begin)


class Additive(QMIXPolicy):
    def make_mixer(self) -> nn.Module:
        return Sum()


class Sum(nn.Module):
    def forward(self, q: th.Tensor, state: th.Tensor) -> th.Tensor:
        return q.sum(dim=1)


# --- what is let through -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SHIPPED)
def test_every_policy_that_ships_is_let_through_before_and_after_training(name: str) -> None:
    model = built(find_policy(name))
    check_policy(model, name)
    before = parameters(model)
    model.learn(2 * ROLLOUT)
    assert not np.array_equal(parameters(model), before)
    check_policy(model, name)


class OfRealStatesAlone(Good):
    """Its critic is no number, or breaks down, where x is none of a real game: nobody asks it there."""

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        voxels = (10 * state[:, self.layout.state_uavs][:, :3]).round().long()
        return th.cat([nn.functional.one_hot(voxels, 10).flatten(1), (1.0 + state).log()], dim=1)


@pytest.mark.parametrize("policy", [Masking, OfRealStatesAlone])
def test_what_keeps_its_promises_is_let_through(policy: type[BasePolicy]) -> None:
    check_policy(built(policy), "mine")


@pytest.mark.parametrize("name", ["centralized_critic", "monotonic_mixer", "local_q"])
def test_a_uav_that_is_alone_is_let_through_too(name: str) -> None:
    check_policy(built(find_policy(name), SMALL.changed(num_uavs=1)), name)


# --- actors that read x --------------------------------------------------------------------------------------------


class ReadsX(Good):
    def actor_view(self, flat: th.Tensor) -> th.Tensor:
        return flat


class MaskedReadsX(MaskableCTDEPolicy):
    actor_view, critic_input = ReadsX.actor_view, Good.critic_input


class RecurrentReadsX(RecurrentCTDEPolicy):
    actor_view, critic_input = ReadsX.actor_view, Good.critic_input


class QReadsX(Additive):
    def seen(self, flat: th.Tensor) -> th.Tensor:
        return flat[:, self.layout.local] + flat[:, self.layout.state][:, :1]


class ActsOnX(Additive):
    """Asks no network at all."""

    def _predict(self, observation: Any, deterministic: bool = False) -> th.Tensor:
        x: th.Tensor = observation[:, self.layout.state]
        return (10 * x[:, 0]).long().abs() % 63


class RolloutsReadX(Good):
    def forward(self, obs: Any, deterministic: bool = False) -> tuple[th.Tensor, th.Tensor, th.Tensor]:
        actions, values, log_prob = super().forward(obs, deterministic)
        return actions, values, log_prob + obs[:, self.layout.state].sum(dim=1)


class UpdatesReadX(Good):
    def evaluate_actions(self, obs: Any, actions: th.Tensor) -> tuple[th.Tensor, th.Tensor, th.Tensor | None]:
        values, log_prob, entropy = super().evaluate_actions(obs, actions)
        return values, log_prob + obs[:, self.layout.state].sum(dim=1), entropy


class SampledPlayReadsX(Good):
    def _predict(self, observation: Any, deterministic: bool = False) -> th.Tensor:
        peeped = (10 * observation[:, self.layout.state][:, 0]).long().abs() % 63
        return super()._predict(observation, deterministic) if deterministic else peeped


@pytest.mark.parametrize(
    ("policy", "changed"),
    [
        (ReadsX, "32 of 32 logits"),
        (MaskedReadsX, "32 of 32 logits"),
        (RecurrentReadsX, "32 of 32 logits"),
        (QReadsX, "32 of 32 action values"),
        (ActsOnX, " greedy actions"),
        (SampledPlayReadsX, " sampled actions"),
        (RolloutsReadX, "32 of 32 log-probabilities in rollouts"),
        (UpdatesReadX, "32 of 32 log-probabilities in updates"),
    ],
)
def test_an_actor_that_reads_x_is_refused(policy: type[BasePolicy], changed: str) -> None:
    message = refusal(policy)
    assert message.startswith("): its actor reads the global state x: ")
    becomes = "another game's" if "log-prob" in changed else "noise"
    assert f"{changed} change when x becomes {becomes}; allowed are o_i and what its policy sees" in message


class WritesIntoIt(Good):
    def actor_input(self, local: th.Tensor) -> th.Tensor:
        local[:, self.layout.cell_loads] = 0.0
        return local


def test_a_policy_that_writes_into_what_it_is_handed_is_refused() -> None:
    assert "it writes into what it is handed, which the others read too" in refusal(WritesIntoIt)


def test_a_learner_of_iql_that_reads_x_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    model = built(find_policy("local_q"))
    views = type(model.policy.views)
    monkeypatch.setattr(views, "observe", lambda own, learner, flat: flat[own.slots(learner), -own.layout.local_dim :])
    with pytest.raises(UserError, match=r"policy 'local_q' \(policies/local_q.py\): its actor reads .* action values"):
        check_policy(model, "local_q")


def test_a_policy_that_says_that_it_sees_x_may_read_it() -> None:
    check_policy(built(type("SeesX", (Good,), {"sees": ("state",)})), "mine")


def test_the_actor_of_a_stock_policy_reads_x() -> None:
    model = MAPPO("MlpPolicy", make_vec_env(SMALL, NUM_GAMES), n_steps=16, batch_size=128, seed=0, device="cpu")
    with pytest.raises(UserError, match=r"^policy 'MlpPolicy' \(.*stable_baselines3.*policies.py\): .* reads the glob"):
        check_policy(model, "MlpPolicy")


# --- widths, numbers and company -----------------------------------------------------------------------------------


class ActorOf62(Good):
    def _get_action_dist_from_latent(self, latent_pi: th.Tensor) -> Any:
        return self.action_dist.proba_distribution(self.action_net(latent_pi)[:, :62])


class MaskedOf62(MaskableCTDEPolicy):
    critic_input = Good.critic_input

    def _build(self, lr_schedule: Any) -> None:
        super()._build(lr_schedule)
        self.action_net = nn.Linear(32, 62)


class CriticOf2(Good):
    def _build(self, lr_schedule: Any) -> None:
        super()._build(lr_schedule)
        self.value_net = nn.Linear(32, 2)


class QOf64(DQNPolicy):
    def make_q_net(self) -> QNetwork:
        net = super().make_q_net()
        net.q_net = nn.Sequential(*create_mlp(net.features_dim, 64, [32]))
        return net


class QuantilesOf62(QRDQNPolicy):
    def make_quantile_net(self) -> Any:
        net = super().make_quantile_net()
        net.forward = lambda obs: th.zeros(len(obs), 5, 62)  # type: ignore[method-assign]
        return net


class ColumnTeam(QMIXPolicy):
    def make_mixer(self) -> nn.Module:
        return nn.Bilinear(self.layout.num_uavs, self.layout.state_dim, 1)


@pytest.mark.parametrize(
    ("policy", "wrong"),
    [
        (ActorOf62, "actor answers with 62 numbers, the game has 63 actions"),
        (MaskedOf62, "actor answers with 62 numbers, the game has 63 actions"),
        (CriticOf2, "critic answers with 2 numbers, allowed is 1, the value of the slot"),
        (QOf64, "Q-network answers with 64 numbers, the game has 63 actions"),
        (QuantilesOf62, "Q-network answers with 62 numbers, the game has 63 actions"),
        (ColumnTeam, "mixer answers with shape [16, 1] in place of [16], one value per game"),
    ],
)
def test_an_answer_of_the_wrong_width_is_refused(policy: type[BasePolicy], wrong: str) -> None:
    assert refusal(policy) == f"): its {wrong}"


class NanActor(Good):
    def actor_input(self, local: th.Tensor) -> th.Tensor:
        return local / 0.0


class NanCritic(Good):
    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return local.log()  # of positions and rates that are 0


class NanTeam(Additive):
    def game_values(self, *args: Any, **kwargs: Any) -> th.Tensor:
        return super().game_values(*args, **kwargs) * th.nan


@pytest.mark.parametrize(("policy", "who"), [(NanActor, "actor"), (NanCritic, "critic"), (NanTeam, "mixer")])
def test_answers_that_are_no_numbers_are_refused(policy: type[BasePolicy], who: str) -> None:
    message = refusal(policy)
    assert message.startswith(f"): its {who} answers ")
    assert message.endswith(" real observations with NaN or infinity")


class Peeking(Good):
    """The actor sees the o_j of the slot before: another UAV's, as long as slots come game by game."""

    def actor_input(self, local: th.Tensor) -> th.Tensor:
        return th.cat([local, local.roll(1, dims=0)], dim=1)


class NormedQ(DQNPolicy):
    def make_q_net(self) -> QNetwork:
        net = super().make_q_net()
        net.q_net.insert(0, nn.BatchNorm1d(net.features_dim))
        return net


class MeanTeam(Additive):
    def game_values(self, *args: Any, **kwargs: Any) -> th.Tensor:
        values = super().game_values(*args, **kwargs)
        return values - values.mean()


@pytest.mark.parametrize(
    ("policy", "what"),
    [(NormedCritic, "values"), (Peeking, "logits"), (NormedQ, "action values"), (MeanTeam, "values of games")],
)
def test_an_answer_that_depends_on_the_other_slots_is_refused(policy: type[BasePolicy], what: str) -> None:
    assert f" {what} change when the other slots of the batch do; an answer may depend on its own" in refusal(policy)


# --- errors --------------------------------------------------------------------------------------------------------


class Misspelt(Good):
    def predict_values(self, obs: Any) -> th.Tensor:
        return self.layuot  # type: ignore[return-value]


def test_an_error_while_a_policy_is_asked_becomes_one_line_with_file_line_and_reason() -> None:
    line = inspect.getsourcelines(Misspelt.predict_values)[1] + 1
    reason = "AttributeError: 'Misspelt' object has no attribute 'layuot' (did you mean 'layout'?)"
    assert refusal(Misspelt) == f", line {line}): {reason}"


class Uneven(Good):
    """Its critic's input is wider the more rows there are, and so fits the network for one row alone."""

    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return local[:, : len(local)]


class Mismatched(Good):
    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return local if len(local) == 1 else local @ th.zeros(3, 4)


class Helped(Good):
    def critic_input(self, local: th.Tensor, state: th.Tensor) -> th.Tensor:
        return local if len(local) == 1 else wrong_product(local)


def test_an_inner_error_of_shapes_names_the_line_that_gave_them() -> None:
    begin, end = inspect.getsourcelines(Uneven.critic_input)[1], "RuntimeError: mat1 and mat2 shapes cannot be"
    assert refusal(Uneven).startswith(f", line {begin}, what critic_input gives): {end}")
    line = inspect.getsourcelines(Mismatched.critic_input)[1] + 1
    assert refusal(Mismatched).startswith(f", line {line}): {end}")


def test_an_error_in_another_file_of_the_user_names_that_file() -> None:
    line = inspect.getsourcelines(wrong_product)[1] + 1
    assert refusal(Helped).startswith(f", in tests/experiment/probed.py, line {line}): RuntimeError: mat1")


def test_a_users_error_raised_by_a_policy_keeps_its_words() -> None:
    error = UserError("net_arch = []: at least one layer")
    assert str(policy_error(error, Good, "mine")) == f"policy 'mine' ({place(Good)}): net_arch = []: at least one layer"


def test_a_class_is_placed_by_its_file_or_else_by_its_module() -> None:
    assert place(find_policy("state_critic")) == "policies/state_critic.py"
    made_by_hand: Any = type("ByHand", (ActorCriticPolicy,), {"__module__": "nowhere"})
    assert place(made_by_hand) == "module nowhere"
    assert "line" not in str(policy_error(ValueError("no"), made_by_hand, "mine"))
