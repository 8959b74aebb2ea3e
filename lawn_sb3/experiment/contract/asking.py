"""What the networks of a policy answer to observations, in play and in updates, for each kind of policy."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from itertools import chain
from typing import Any

import numpy as np
import torch as th
from numpy.typing import NDArray
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from sb3_contrib.common.recurrent.type_aliases import RNNStates
from sb3_contrib.qrdqn.policies import QRDQNPolicy
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy
from stable_baselines3.common.utils import obs_as_tensor
from torch import nn

from lawn_sb3.algos.iql import IndependentPolicy
from lawn_sb3.algos.mappo.value_normalization import NormalizedValueHead
from lawn_sb3.algos.qmix import QMIXPolicy
from lawn_sb3.experiment.contract.games import Flat, Games, restored, seed_all
from lawn_sb3.experiment.contract.messages import Breach, refuse_not_finite, refuse_width

MIXED = "values of games"


class Answers:
    """What actor and critic answered: for each kind of answer one tensor a slot of time, one row a UAV or a game."""

    def __init__(self) -> None:
        self.actor: defaultdict[str, list[th.Tensor]] = defaultdict(list)
        self.critic: defaultdict[str, list[th.Tensor]] = defaultdict(list)


@th.no_grad()
def ask(model: BaseAlgorithm, games: Games, flat: Flat, training: bool = False) -> Answers:
    """Let the networks answer, from equal seeds and equal statistics each time; for use inside ``no_trace``.

    :param model: the model
    :param games: the games that the observations are of
    :param flat: their flat observations, perhaps changed [T, G, N, flat_dim]
    :param training: ask in training mode and as an update does; otherwise as play does
    :return: the answers
    :raises Breach: if there is no such kind of policy, an answer is too wide or narrow, the actor's is no number, or
        the policy writes into the observations
    """
    for kind, asked in ASKING.items():
        if isinstance(model.policy, kind):
            seed_all()
            said, given = Answers(), flat.copy()
            with restored(list(model.policy.buffers())):
                asked(model, games, given, training, said)
            if not np.array_equal(given, flat):
                raise Breach("it writes into the observations that it is given; it may write into a clone of them")
            return said
    known = ", ".join(kind.__name__ for kind in ASKING)
    raise Breach(f"a {type(model.policy).__name__} is none of the kinds of policy that are known here: {known}")


def _ask_actor_critic(model: BaseAlgorithm, games: Games, flat: Flat, training: bool, said: Answers) -> None:
    policy: Any = model.policy
    recurrent = isinstance(policy, RecurrentActorCriticPolicy)
    num_slots, num_actions = flat.shape[1] * flat.shape[2], games.inside.shape[-1]
    some_actions = th.arange(num_slots, device=policy.device) % num_actions
    memory = _empty_memory(policy, num_slots) if recurrent else None
    player = _Player(model, num_actions)
    head = getattr(policy, "value_net", None)
    for t, seen in enumerate(flat.reshape(len(flat), num_slots, -1)):
        obs: Any = obs_as_tensor(seen, policy.device)  # the same memory, as in rollouts
        begins = np.full(num_slots, t == 0)
        inside = games.inside[t].reshape(num_slots, -1)
        masks = {"action_masks": inside} if isinstance(policy, MaskableActorCriticPolicy) else {}
        pi: tuple[Any, ...] = ()
        vf: tuple[Any, ...] = ()
        both: tuple[Any, ...] = ()
        if memory is not None:
            starts = th.as_tensor(begins, dtype=th.float32, device=policy.device)
            pi, vf, both = (memory.pi, starts), (memory.vf, starts), (memory, starts)
        policy.set_training_mode(training)
        with head.normalized_units() if training and isinstance(head, NormalizedValueHead) else nullcontext():
            logits = _logits(policy, num_actions, obs, *pi)
            values = policy.predict_values(obs, *vf)
            refuse_width("critic", values, (num_slots, 1), "allowed is 1, the value of the slot")
            acted = policy(obs, *both, **masks)
            judged = policy.evaluate_actions(obs, some_actions, *both, **masks)
        said.actor["action distributions"].append(logits)
        said.actor["actions of rollouts"].append(acted[0])
        said.actor["log-probabilities of rollouts"].append(acted[2])
        said.actor["log-probabilities of updates"].append(judged[1])
        said.actor["entropies of updates"].append(judged[2])
        said.critic["values"].append(values)
        said.critic["values of rollouts"].append(acted[1])
        said.critic["values of updates"].append(judged[0])
        memory = acted[3] if recurrent else None
        if not training:
            player.act(seen, said, begins, **masks)


def _logits(policy: Any, num_actions: int, obs: th.Tensor, *memory: Any) -> th.Tensor:
    """The logits of the actions [B, A]."""
    allowed = f"the game has {num_actions} actions"
    with _listening([policy.action_net] if hasattr(policy, "action_net") else []) as heard:
        try:
            given = policy.get_distribution(obs, *memory)
        except RuntimeError:
            # sb3-contrib fails on a wrong width too, but its words do not say so.
            for answer in chain.from_iterable(heard):
                refuse_width("actor", answer, (len(obs), num_actions), allowed)
            raise
    logits: th.Tensor = (given[0] if memory else given).distribution.logits
    refuse_width("actor", logits, (len(obs), num_actions), allowed)
    refuse_not_finite("actor", logits, masking=True)
    return logits


def _empty_memory(policy: RecurrentActorCriticPolicy, num_slots: int) -> RNNStates:
    layers, _, units = policy.lstm_hidden_state_shape
    nothing = th.zeros(layers, num_slots, units, device=policy.device)
    return RNNStates((nothing, nothing), (nothing, nothing))


class _Player:
    """Plays as an evaluation does, greedily and with sampled actions, each with a memory of its own."""

    def __init__(self, model: BaseAlgorithm, num_actions: int) -> None:
        self.predict: Any = model.predict
        self.num_actions = num_actions
        self.memory: dict[bool, Any] = {}

    def act(
        self, seen: NDArray[np.float32], said: Answers, begins: NDArray[np.bool_] | None = None, **more: Any
    ) -> None:
        for kind, greedy in (("greedy actions", True), ("sampled actions", False)):
            given, memory = self.predict(seen, self.memory.get(greedy), begins, deterministic=greedy, **more)
            actions, self.memory[greedy] = np.asarray(given), memory
            if actions.shape != (len(seen),) or not np.isin(actions, np.arange(self.num_actions)).all():
                raise Breach(
                    f"its {kind} for {len(seen)} slots have the shape {list(actions.shape)} and lie between "
                    f"{actions.min()} and {actions.max()}, allowed is a whole number from 0 to {self.num_actions - 1} "
                    "for each"
                )
            said.actor[kind].append(th.as_tensor(actions))


def _ask_independent(model: BaseAlgorithm, games: Games, flat: Flat, training: bool, said: Answers) -> None:
    policy: Any = model.policy
    player = _Player(model, games.inside.shape[-1])
    networks = [one.quantile_net if isinstance(one, QRDQNPolicy) else one.q_net for one in policy.learners]
    for seen in flat.reshape(len(flat), -1, flat.shape[-1]):
        policy.set_training_mode(training)
        with _listening(networks) as heard:
            if training:
                obs = policy.obs_to_tensor(seen)[0]
                for learner, network in enumerate(networks):
                    network(policy.views.observe(learner, obs))
            else:
                player.act(seen, said)
        for learner, answers in zip(policy.learners, heard, strict=True):
            for answer in answers:
                _refuse_action_values(answer, player.num_actions, getattr(learner, "n_quantiles", None))
        for of_all in zip(*heard, strict=False):
            said.actor["action values"].append(th.stack(of_all, dim=1).flatten(0, 1))  # [G * N, ...]


def _refuse_action_values(answer: th.Tensor, num_actions: int, num_quantiles: int | None = None) -> None:
    allowed = f"the game has {num_actions} actions"
    if num_quantiles is None:
        refuse_width("Q-network", answer, (*answer.shape[:-1], num_actions), allowed)
    else:
        shape = (*answer.shape[:-2], num_quantiles, num_actions)
        refuse_width("Q-network", answer, shape, f"{allowed} and its policy {num_quantiles} quantiles for each")
    refuse_not_finite("Q-network", answer, masking=True)


def _ask_qmix(model: BaseAlgorithm, games: Games, flat: Flat, training: bool, said: Answers) -> None:
    policy: Any = model.policy
    num_games, num_uavs, num_actions = games.inside.shape[1:]
    player = _Player(model, num_actions)
    some_actions = th.arange(num_games * num_uavs, device=policy.device).reshape(num_games, num_uavs) % num_actions
    everybody = th.ones_like(some_actions, dtype=th.bool)
    for seen in flat:
        with _listening([policy.q_net]) as heard:
            if not training:
                player.act(seen.reshape(num_games * num_uavs, -1), said)
            policy.set_training_mode(training)
            obs = policy.obs_to_tensor(seen.reshape(num_games * num_uavs, -1))[0].reshape(num_games, num_uavs, -1)
            local, state = obs[..., games.layout.seen(policy.sees)], obs[:, 0, games.layout.state]
            mixed = policy.game_values(local, state, some_actions, everybody)
        for answer in heard[0]:
            _refuse_action_values(answer, num_actions)
            said.actor["action values"].append(answer)
        refuse_width("mixer", mixed, (num_games,), "one value a game")
        said.critic[MIXED].append(mixed)


ASKING: dict[type[BasePolicy], Callable[[BaseAlgorithm, Games, Flat, bool, Answers], None]] = {
    ActorCriticPolicy: _ask_actor_critic,
    MaskableActorCriticPolicy: _ask_actor_critic,
    IndependentPolicy: _ask_independent,
    QMIXPolicy: _ask_qmix,
}
"""How each kind of policy is asked."""


@contextmanager
def _listening(networks: Sequence[nn.Module]) -> Iterator[list[list[th.Tensor]]]:
    """Collect what networks answer, whoever asks them."""
    heard: list[list[th.Tensor]] = [[] for _ in networks]

    def listener(answers: list[th.Tensor]) -> Callable[..., None]:
        return lambda _network, _asked, answer: answers.append(answer)

    handles = [net.register_forward_hook(listener(own)) for net, own in zip(networks, heard, strict=True)]
    try:
        yield heard
    finally:
        for handle in handles:
            handle.remove()
