"""The networks' part of an update in bfloat16: forward and backward. All else stays in float32.

Weights, gradients, optimiser, losses and whatever is made of logits and values are in float32, and so is play. Torch
casts the weights for each minibatch anew, by its ``autocast``; every processor can, one with bfloat16 instructions
(AVX512-BF16, AMX) gains by it.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any

import torch as th
from stable_baselines3.common.policies import BasePolicy
from torch import nn

PRECISIONS = {"bfloat16": th.bfloat16}
"""What ``autocast`` may be, besides none."""
QUESTIONS = ("evaluate_actions", "get_distribution", "predict_values")
"""How an update asks a policy."""


def check_autocast(autocast: str | None) -> None:
    """Refuse a precision that is not offered.

    :raises ValueError: if it is not
    """
    if autocast is not None and autocast not in PRECISIONS:
        raise ValueError(f"autocast = {autocast!r}: {' or '.join(PRECISIONS)}, or left out for float32")


@contextmanager
def networks_in(autocast: str | None, policy: BasePolicy) -> Iterator[None]:
    """Let an actor-critic work in a lower precision for the duration of a ``with`` block.

    :param autocast: one of :data:`PRECISIONS`; nothing changes without one
    :param policy: an actor-critic of SB3 or sb3-contrib; its logits and values come in float32
    """
    if autocast is None:
        yield
        return
    actor, critic = (policy.get_submodule(name) for name in ("action_net", "value_net"))
    with ExitStack() as until_the_end:
        for last in (actor, getattr(critic, "linear", critic)):  # a normalised head scales in float32
            until_the_end.enter_context(last.register_forward_hook(_in_float32))
        for name in QUESTIONS:
            lower = th.autocast(policy.device.type, PRECISIONS[autocast])
            setattr(policy, name, lower(getattr(policy, name)))  # hides the method of the class
            until_the_end.callback(delattr, policy, name)
        yield


def _in_float32(_: nn.Module, __: Any, answer: th.Tensor) -> th.Tensor:
    return answer.float()
