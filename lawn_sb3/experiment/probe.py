"""The probe of every policy, before training and after it: a few real observations, and how they may be answered."""

from __future__ import annotations

import difflib
import inspect
import random
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any

import numpy as np
import torch as th
from numpy.typing import NDArray
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from sb3_contrib.common.recurrent.policies import RecurrentActorCriticPolicy
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy, BasePolicy

from lawn_sb3.algos.mappo.value_normalization import NormalizedValueHead
from lawn_sb3.algos.qmix import QMIXPolicy
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.registry import place
from lawn_sb3.game.simulator import Simulator

NUM_GAMES, NUM_SLOTS = 4, 4
ROUNDING = 1e-5  # by the rest of its batch: networks that share it out among them may round otherwise in other company
READS_X = "its actor reads the global state x: {} change when x becomes noise; allowed are o_i and what its policy sees"
READS_OTHERS = (
    "{} change when the other slots of the batch do; an answer may depend on its own slot alone: no batch norm, no "
    "mean over the batch"
)


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
    noisy = flat.copy()  # [G, N, flat_dim]
    noisy[..., x] = rng.normal(size=noisy[..., x].shape)
    kept = rng.random(flat.shape[:2]) < 0.5  # single UAVs ...
    kept[: len(kept) // 2] = True  # ... and whole games
    beside_others = np.where(kept[..., None], flat, np.roll(flat, 1, axis=0))
    try:
        for training in (False, True):
            with _no_trace(model.policy):
                said = _ask(model.policy, training, flat, masks, x)
                if "state" not in getattr(model.policy_class, "sees", ()):
                    _compare(said, _ask(model.policy, training, noisy, masks, None), READS_X)
                _compare(said, _ask(model.policy, training, beside_others, masks, x), READS_OTHERS, kept)
    except _Breach as breach:
        raise UserError(f"policy {name!r} ({place(model.policy_class)}): {breach}") from None
    except Exception as error:
        raise policy_error(error, model.policy_class, name) from error


def _ask(
    policy: Any, training: bool, flat: NDArray[np.float32], masks: NDArray[np.bool_], x: slice | None
) -> dict[str, th.Tensor]:
    """What the networks answer, one row a UAV or a game, from equal seeds each time; critics only where x is told."""
    for seed in (random.seed, np.random.seed, th.manual_seed):
        seed(0)
    policy.set_training_mode(training)
    num_games, num_uavs, num_actions = masks.shape
    rows = flat.reshape(num_games * num_uavs, -1)
    obs, said = th.tensor(rows, device=policy.device), dict[str, th.Tensor]()
    answers, allowed = (len(rows), num_actions), f"the game has {num_actions} actions"
    memory: tuple[Any, ...] = ()
    if isinstance(policy, RecurrentActorCriticPolicy):
        layers, _, units = policy.lstm_hidden_state_shape
        nothing = th.zeros(layers, len(rows), units, device=policy.device)
        memory = (nothing, nothing), th.ones(len(rows), device=policy.device)
    if isinstance(policy, ActorCriticPolicy | MaskableActorCriticPolicy):
        heard: list[th.Tensor] = []
        with policy.action_net.register_forward_hook(lambda *call: heard.append(call[2])):
            try:
                given: Any = policy.get_distribution(obs, *memory)
            except (RuntimeError, ValueError):  # a distribution refuses wrong widths and NaN too, but in other words
                for logits in heard:
                    _refuse("actor", logits, (*logits.shape[:-1], num_actions), allowed)
                raise
        said["logits"] = (given[0] if memory else given).distribution.logits
        _refuse("actor", said["logits"], answers, allowed)
        if x is not None:
            head = policy.value_net  # whose values are all 0 before it has seen any, but for these units
            with head.normalized_units() if isinstance(head, NormalizedValueHead) else nullcontext():
                said["values"] = policy.predict_values(obs, *memory)
            _refuse("critic", said["values"], (len(rows), 1), "allowed is 1, the value of the slot")
    else:
        said["action values"] = policy.action_values(obs)
        _refuse("Q-network", said["action values"], answers, allowed)
    if isinstance(policy, QMIXPolicy) and x is not None:
        local = policy.seen(obs).reshape(num_games, num_uavs, -1)
        actions = th.zeros(num_games, num_uavs, dtype=th.long, device=policy.device)
        said["values of games"] = policy.game_values(local, obs[::num_uavs, x], actions, actions == 0)
        _refuse("mixer", said["values of games"], (num_games,), "one value a game")
    if not training:
        more = {"action_masks": masks.reshape(answers)} if isinstance(policy, MaskableActorCriticPolicy) else {}
        said["greedy actions"] = th.as_tensor(policy.predict(rows.copy(), deterministic=True, **more)[0])
    return said


def _compare(said: dict[str, th.Tensor], then: dict[str, th.Tensor], wrong: str, kept: Any = None) -> None:
    """Refuse answers that changed by a single bit; of rows that were kept beside others, by more than is rounded."""
    rounding = 0.0 if kept is None else ROUNDING
    for kind, answers in then.items():
        same = th.isclose(answers.double(), said[kind].double(), rtol=rounding, atol=rounding)
        changed = ~same.reshape(len(answers), -1).all(dim=1).cpu().numpy()
        if kept is not None:
            changed = changed[kept.ravel() if len(changed) == kept.size else kept.all(axis=1)]
            changed &= kind != "greedy actions"  # which may be others where two are worth nearly the same
        if changed.any():
            raise _Breach(wrong.format(f"{changed.sum()} of {len(changed)} {kind}"))


def _refuse(who: str, answer: th.Tensor, shape: tuple[int, ...], allowed: str) -> None:
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


def policy_error(error: Exception, policy: type[BasePolicy], name: str) -> UserError:
    """Put whatever was raised while a policy was built or asked into one line.

    :param error: the exception, with its traceback
    :param policy: the policy class
    :param name: what the user calls the policy
    :return: the error: name, file, line in this file if the error passed through it, and the reason's first line
    """
    line, reason = line_in_own_file(error, policy), next(iter(str(error).strip().splitlines()), "")
    if not isinstance(error, UserError):
        reason = f"{type(error).__name__}: {reason}".removesuffix(": ")
    near = []
    if isinstance(error, AttributeError) and isinstance(error.name, str):
        with suppress(AttributeError):  # of a torch module that is not built yet
            near = difflib.get_close_matches(error.name, dir(error.obj), n=1)
    hint = f" (did you mean {near[0]!r}?)" if near else ""
    return UserError(f"policy {name!r} ({place(policy)}{'' if line is None else f', line {line}'}): {reason}{hint}")


def line_in_own_file(error: Exception, policy: type[BasePolicy]) -> int | None:
    """Find where an error passed through a policy's own file.

    :param error: the exception, with its traceback
    :param policy: the policy class
    :return: the last such line; none if it passed elsewhere
    """
    try:
        own = Path(inspect.getfile(policy)).resolve()
    except (TypeError, OSError):
        return None
    passed = [(Path(frame.f_code.co_filename), line) for frame, line in traceback.walk_tb(error.__traceback__)]
    return next((line for path, line in reversed(passed) if path.resolve() == own), None)
