"""The probe of every policy, before training and after it: a few real observations, and how they may be answered."""

import random
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from typing import Any

import numpy as np
import torch as th
from numpy.typing import NDArray
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from sb3_contrib.common.recurrent.type_aliases import RNNStates
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy

from lawn_sb3.algos.mappo.value_normalization import NormalizedValueHead
from lawn_sb3.algos.qmix import QMIXPolicy
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.policy_errors import policy_error
from lawn_sb3.experiment.registry import place
from lawn_sb3.game.simulator import Simulator

NUM_GAMES, NUM_SLOTS = 4, 4
ROUNDING = 1e-5  # by the rest of its batch: networks that share it out among them may round otherwise in other company
READS_X = "its actor reads the global state x: {{}} change when x becomes {}; allowed are o_i and what its policy sees"
READS_OTHERS = (
    "{} change when the other slots of the batch do; an answer may depend on its own slot alone: no batch norm, no "
    "mean over the batch"
)

CRITICS = ("values", "values of games")
"""Answers that may depend on x."""
Answers = dict[str, th.Tensor]
"""What the networks answer, by kind: one row per UAV or per game."""


class _Breach(Exception):  # noqa: N818  # it is the policy that errs
    """What a policy does wrong and what is allowed, without its name."""


def check_policy(model: BaseAlgorithm, name: str) -> None:
    """Refuse a policy whose actor reads x, or whose answers have a wrong width, are no numbers or depend on other rows.

    Weights, buffers, modes, random states and environment stay as they are.

    :param model: a model with its training environment
    :param name: what the user calls the policy
    :raises UserError: one line: the policy's name, the file it is in, what it does wrong and what is allowed
    """
    assert model.env is not None
    scenario, observer = (model.env.get_attr(what, [0])[0] for what in ("scenario", "observer"))
    simulator, rng = Simulator(scenario, NUM_GAMES, model.num_timesteps), np.random.default_rng(model.num_timesteps)
    played, moves = [], []  # each slot counts as a game of its own
    for _ in range(NUM_SLOTS):
        simulator.step(rng.integers(simulator.num_actions, size=simulator.state.flying.shape))
        simulator.go_on()
        played.append(observer.flat(simulator.state))
        moves.append(simulator.allowed_moves())
    flat, masks, x = np.concatenate(played), np.concatenate(moves), observer.layout.state
    noisy, elsewhere = flat.copy(), flat.copy()  # [G, N, flat_dim]
    noisy[..., x] = rng.normal(size=noisy[..., x].shape)
    elsewhere[..., x] = np.roll(flat[..., x], 1, axis=0)  # a critic can be asked about it too, unlike about noise
    kept = rng.random(flat.shape[:2]) < 0.5  # single UAVs ...
    kept[: len(kept) // 2] = True  # ... and whole games
    beside_others = np.where(kept[..., None], flat, np.roll(flat, 1, axis=0))
    try:
        for training in (False, True):
            with _no_trace(model.policy):
                answers = _ask(model.policy, training, flat, masks, x)
                if "state" not in getattr(model.policy_class, "sees", ()):
                    _compare(answers, _ask(model.policy, training, noisy, masks, None), READS_X.format("noise"))
                    _compare(
                        answers, _ask(model.policy, training, elsewhere, masks, x), READS_X.format("another game's")
                    )
                _compare(answers, _ask(model.policy, training, beside_others, masks, x), READS_OTHERS, kept)
    except _Breach as breach:
        raise UserError(f"policy {name!r} ({place(model.policy_class)}): {breach}") from None
    except Exception as error:
        raise policy_error(error, model.policy_class, name) from error


def _ask(policy: Any, training: bool, flat: NDArray[np.float32], masks: NDArray[np.bool_], x: slice | None) -> Answers:
    """Ask all networks, from equal seeds each time; those that may read x only where it is told where x lies."""
    _seed_all()
    policy.set_training_mode(training)
    num_games, num_uavs, num_actions = masks.shape
    rows = flat.reshape(num_games * num_uavs, -1)
    obs = th.tensor(rows, device=policy.device)
    if isinstance(policy, ActorCriticPolicy | MaskableActorCriticPolicy):
        answers = _ask_actor_critic(policy, obs, masks.reshape(len(rows), -1), x is not None)
    else:
        answers = {"action values": policy.action_values(obs)}
        _check("Q-network", answers["action values"], (len(rows), num_actions), f"the game has {num_actions} actions")
    if isinstance(policy, QMIXPolicy) and x is not None:
        local = policy.seen(obs).reshape(num_games, num_uavs, -1)
        actions = th.zeros(num_games, num_uavs, dtype=th.long, device=policy.device)
        answers["values of games"] = policy.game_values(local, obs[::num_uavs, x], actions, actions == 0)
        _check("mixer", answers["values of games"], (num_games,), "one value per game")
    if not np.array_equal(obs.cpu().numpy(), rows):
        raise _Breach("it writes into what it is handed, which the others read too; it may change a clone of it")
    if not training:
        mask = {"action_masks": masks.reshape(len(rows), -1)} if isinstance(policy, MaskableActorCriticPolicy) else {}
        for kind, greedy in (("greedy actions", True), ("sampled actions", False)):
            _seed_all()
            answers[kind] = th.as_tensor(policy.predict(rows.copy(), deterministic=greedy, **mask)[0])
    return answers


def _seed_all() -> None:
    for seed in (random.seed, np.random.seed, th.manual_seed):
        seed(0)


def _ask_actor_critic(policy: Any, obs: th.Tensor, masks: NDArray[np.bool_], critic_too: bool) -> Answers:
    """What play, rollouts and updates ask for; values in normalised units, as in others an untrained critic says 0."""
    num_actions = masks.shape[1]
    memory: tuple[Any, ...] = ()
    if isinstance(policy, RecurrentActorCriticPolicy):
        layers, _, units = policy.lstm_hidden_state_shape
        nothing = th.zeros(layers, len(obs), units, device=policy.device)
        memory = (nothing, nothing), th.ones(len(obs), device=policy.device)
    heard: list[th.Tensor] = []
    with policy.action_net.register_forward_hook(lambda *call: heard.append(call[2])):
        try:
            given = policy.get_distribution(obs, *memory)
            logits = (given[0] if memory else given).distribution.logits
        except (RuntimeError, ValueError):  # a distribution refuses wrong widths and NaN too, but in other words
            for wrong in heard:
                _check("actor", wrong, (*wrong.shape[:-1], num_actions), f"the game has {num_actions} actions")
            raise
    _check("actor", logits, (len(obs), num_actions), f"the game has {num_actions} actions")
    if not critic_too:
        return {"logits": logits}
    head = policy.value_net
    with head.normalized_units() if isinstance(head, NormalizedValueHead) else nullcontext():
        values = policy.predict_values(obs, *memory)
        _check("critic", values, (len(obs), 1), "allowed is 1, the value of the slot")
        both = (RNNStates(memory[0], memory[0]), memory[1]) if memory else ()
        mask = {"action_masks": masks} if isinstance(policy, MaskableActorCriticPolicy) else {}
        some_actions = th.arange(len(obs), device=policy.device) % num_actions
        rollout = policy(obs, *both, **mask)
        update = policy.evaluate_actions(obs, some_actions, *both, **mask)
    chances = {"log-probabilities in rollouts": rollout[2], "log-probabilities in updates": update[1]}
    return {"logits": logits, **chances, "actions in rollouts": rollout[0], "values": values}


def _check(who: str, answer: th.Tensor, shape: tuple[int, ...], allowed: str) -> None:
    """Refuse an answer of another shape, or that is no number; minus infinity may rule out actions, though not all."""
    if answer.shape != shape:
        as_deep = answer.shape[:-1] == shape[:-1]
        given = f"{answer.shape[-1]} numbers" if as_deep else f"shape {list(answer.shape)} in place of {list(shape)}"
        raise _Breach(f"its {who} answers with {given}, {allowed}")
    good = answer.isfinite()
    if who in ("actor", "Q-network"):
        good |= answer.isneginf() & good.any(dim=-1, keepdim=True)
    bad = ~good.reshape(len(answer), -1).all(dim=1)
    if bad.any():
        raise _Breach(f"its {who} answers {int(bad.sum())} of {len(bad)} real observations with NaN or infinity")


def _compare(real: Answers, changed: Answers, wrong: str, kept: Any = None) -> None:
    """Refuse answers that changed by a single bit; of rows that were kept beside others, by more than is rounded."""
    rounding = 0.0 if kept is None else ROUNDING
    for kind, answers in changed.items():
        if kept is None and kind in CRITICS:
            continue
        same = th.isclose(answers.double(), real[kind].double(), rtol=rounding, atol=rounding)
        differ = ~same.reshape(len(answers), -1).all(dim=1).cpu().numpy()
        if kept is not None:
            differ = differ[kept.ravel() if len(differ) == kept.size else kept.all(axis=1)]
            differ &= "actions" not in kind  # which may be others where two are worth nearly the same
        if differ.any():
            raise _Breach(wrong.format(f"{differ.sum()} of {len(differ)} {kind}"))


@contextmanager
def _no_trace(policy: BasePolicy) -> Iterator[None]:
    """Put weights, buffers and modes of a policy and all global random states back as they were."""
    tensors, modes = [*policy.parameters(), *policy.buffers()], {part: part.training for part in policy.modules()}
    kept, states = [tensor.detach().clone() for tensor in tensors], (random.getstate(), np.random.get_state())
    with th.no_grad(), th.random.fork_rng([policy.device] if policy.device.type == "cuda" else []):
        try:
            yield
        finally:
            random.setstate(states[0])
            np.random.set_state(states[1])
            for part, training in modes.items():
                part.training = training
            for tensor, value in zip(tensors, kept, strict=True):
                tensor.copy_(value)
