"""The checks: nothing is taken on trust, the networks answer with one thing changed, and are compared bit by bit."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice, zip_longest

import numpy as np
import torch as th
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from torch import nn

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.contract.asking import MIXED, Answers, ask
from lawn_sb3.experiment.contract.games import SEED, Games, beside_other_slots, no_trace, play, with_other_states
from lawn_sb3.experiment.contract.messages import Breach, policy_error, refuse_not_finite, where

WEIGHT_NOISE = 0.05
"""How far weights are moved to see what they may come to read: standard deviation."""
ROUNDING = 1e-5
"""What an answer may differ by when only the other slots of the batch have changed, absolute and relative."""
WHOSE = {MIXED: "mixer"}


def check_policy(model: BaseAlgorithm, name: str) -> None:
    """Refuse a policy that breaks the contract.

    The actor may not read x, all answers have the right width and are numbers, and a slot's answer depends on its own
    observation alone. Weights, modes, random states and environment stay as they are.

    :param model: a model with its training environment, before training or after it
    :param name: what the user calls the policy
    :raises UserError: one line: the policy's name, the file it is in, what it does wrong and what is allowed
    """
    games = play(model)
    try:
        with no_trace(model):
            for training in (True, False):
                _check(model, games, training)
            _check_moved(model, games)
    except Breach as breach:
        raise UserError(f"policy {name!r} ({where(model.policy_class)}): {breach}") from None
    except Exception as error:
        raise policy_error(error, model.policy_class, name) from error


def _check(model: BaseAlgorithm, games: Games, training: bool) -> None:
    """The checks in one of the two modes; play is checked more thoroughly."""
    said = ask(model, games, games.flat, training)
    for kind, answers in said.critic.items():
        refuse_not_finite(WHOSE.get(kind, "critic"), th.cat(answers))
    for changed in _changes(said, ask(model, games, games.flat, training), critic_too=True):
        raise Breach(
            f"{changed} change when the same is asked again with the same seeds; an answer may depend on nothing but "
            "weights, observation and torch's random state"
        )
    may_see_x = "state" in getattr(model.policy, "sees", ())
    for becomes, flat in islice(with_other_states(games), 0 if may_see_x else 2 if training else None):
        _refuse_reading(said, ask(model, games, flat, training), f"when x becomes {becomes}")
    for kept, flat in islice(beside_other_slots(games), 1 if training else None):
        then = ask(model, games, flat, training)
        # A network that sorts its rows, as one with several experts does, may round otherwise in other company.
        for changed in _changes(said, then, critic_too=True, kept=kept, rounding=ROUNDING):
            raise Breach(
                f"{changed} change when the other slots of the batch do; an answer may depend on its own slot alone: "
                "no batch norm, no mean over the batch"
            )


def _check_moved(model: BaseAlgorithm, games: Games) -> None:
    """Move the weights, as training would, and see what the actor reads then: a weight of 0 hides what it leads to."""
    _move_weights(model.policy)
    try:
        said = ask(model, games, games.flat)
        count = 0 if "state" in getattr(model.policy, "sees", ()) else 2
        others = [(becomes, ask(model, games, flat)) for becomes, flat in islice(with_other_states(games), count)]
    except (Breach, ArithmeticError, RuntimeError, ValueError):
        return  # weights that training would never come to, such as a variance below 0
    for becomes, then in others:
        _refuse_reading(said, then, f"when x becomes {becomes}, once training has moved its weights")


def _move_weights(policy: nn.Module) -> None:
    generator = th.Generator().manual_seed(SEED)
    owned = [getattr(part, "optimizer", None) for part in policy.modules()]
    groups = [group for one in owned if isinstance(one, th.optim.Optimizer) for group in one.param_groups]
    with th.no_grad():
        for weight in (weight for group in groups for weight in group["params"]):
            weight.add_(WEIGHT_NOISE * th.randn(weight.shape, generator=generator).to(weight))


def _refuse_reading(said: Answers, then: Answers, when: str) -> None:
    for changed in _changes(said, then):
        raise Breach(
            f"its actor reads the global state x: {changed} change {when}; an actor may read o_i alone, "
            "flat[:, self.layout.local]"
        )


def _changes(
    said: Answers,
    then: Answers,
    critic_too: bool = False,
    kept: NDArray[np.bool_] | None = None,
    rounding: float = 0.0,
) -> Iterator[str]:
    """Kinds of answers that changed, with how many of how many rows did.

    :param kept: slots [G, N] that count, and games of such slots alone; all if left out
    :param rounding: differences up to this, absolute or relative, are none
    """
    for before, after in ((said.actor, then.actor), (said.critic, then.critic))[: 1 + critic_too]:
        for kind, answers in before.items():
            rows = []
            for one, other in zip_longest(answers, after[kind], fillvalue=th.empty(0)):
                differ = _differ(one, other, rounding)
                if kept is not None:
                    differ = differ[kept.ravel() if len(differ) == kept.size else kept.all(axis=1)]
                rows.append(differ)
            changed = np.concatenate(rows)
            if changed.any():
                yield f"{changed.sum()} of {len(changed)} {kind}"


def _differ(one: th.Tensor, other: th.Tensor, rounding: float) -> NDArray[np.bool_]:
    """Which rows of two answers are not the same."""
    if one.shape != other.shape:
        return np.ones(len(one), dtype=bool)
    same = th.isclose(one, other, rtol=rounding, atol=rounding, equal_nan=True)
    return np.asarray(~same.reshape(len(one), -1).all(dim=1).cpu())
