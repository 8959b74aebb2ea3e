"""What is wrong with a policy, said in one line."""

from __future__ import annotations

import difflib
import inspect
import traceback
from pathlib import Path

import torch as th
from stable_baselines3.common.policies import BasePolicy

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.registry import place


class Breach(Exception):  # noqa: N818  # it is the policy that errs
    """What a policy does wrong and what is allowed, without its name."""


def where(policy: type[BasePolicy]) -> str:
    """The file that a policy class is defined in, for messages.

    :param policy: the policy class
    :return: its path, relative to the working directory or the repository where possible; its module if it has no file
    """
    try:
        return place(policy)
    except (TypeError, OSError):
        return f"module {policy.__module__}"


def policy_error(error: Exception, policy: type[BasePolicy], name: str) -> UserError:
    """Put whatever was raised while a policy was built or asked into one line.

    :param error: the exception, with its traceback
    :param policy: the policy class
    :param name: what the user calls the policy
    :return: the error: name, file, line in this file if the error passed through it, and the reason's first line
    """
    line = line_in_own_file(error, policy)
    spot = where(policy) if line is None else f"{where(policy)}, line {line}"
    reason = next(iter(str(error).strip().splitlines()), "")
    if not isinstance(error, UserError):
        reason = f"{type(error).__name__}: {reason}".removesuffix(": ")
    return UserError(f"policy {name!r} ({spot}): {reason}{_hint(error)}")


def _hint(error: Exception) -> str:
    """The attribute that was meant, if there is one of nearly that name."""
    if not isinstance(error, AttributeError) or not isinstance(error.name, str):
        return ""
    try:
        known = dir(error.obj)
    except AttributeError:  # a torch module that is not built yet
        return ""
    near = difflib.get_close_matches(error.name, known, n=1)
    return f" (did you mean {near[0]!r}?)" if near else ""


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
    lines = [
        line
        for frame, line in traceback.walk_tb(error.__traceback__)
        if Path(frame.f_code.co_filename).resolve() == own
    ]
    return lines[-1] if lines else None


def refuse_width(who: str, answer: th.Tensor, shape: tuple[int, ...], allowed: str) -> None:
    """Refuse an answer of another shape.

    :param who: whose answer it is
    :param answer: the answer
    :param shape: the shape that it has to have
    :param allowed: what is allowed, in words
    :raises Breach: if it has another one
    """
    if answer.shape != shape:
        as_deep = answer.shape[:-1] == shape[:-1]
        given = (
            f"{answer.shape[-1]} numbers" if as_deep else f"the shape {list(answer.shape)} in place of {list(shape)}"
        )
        raise Breach(f"its {who} answers with {given}, {allowed}")


def refuse_not_finite(who: str, answer: th.Tensor, masking: bool = False) -> None:
    """Refuse an answer that is not a number.

    :param who: whose answer it is
    :param answer: the answer, one row a slot or a game
    :param masking: whether minus infinity may rule out actions, though not all of them
    :raises Breach: if there is NaN or infinity in it
    """
    good = answer.isfinite()
    if masking:
        good |= answer.isneginf() & good.any(dim=-1, keepdim=True)
    bad = ~good.reshape(len(answer), -1).all(dim=1)
    if bad.any():
        raise Breach(f"its {who} answers {int(bad.sum())} of {len(bad)} real observations with NaN or infinity")
