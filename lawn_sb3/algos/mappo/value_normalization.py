"""Value normalisation that changes the critic's targets and nothing else (Section IV-B, Algorithm 1 line 9).

The critic learns in normalised units; whoever else asks it for a value gets one in reward units, so generalised
advantage estimation never sees the normalisation. When the statistics change, the last layer is rescaled so that no
value in reward units changes with them.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import torch as th
from numpy.typing import NDArray
from sb3_contrib.common.maskable.buffers import MaskableRolloutBuffer
from sb3_contrib.common.recurrent.buffers import RecurrentRolloutBuffer
from stable_baselines3.common.buffers import RolloutBuffer
from torch import nn

CONSTANT = 1e-6
"""Returns whose relative spread is below this differ by rounding alone."""


class NormalizedValueHead(nn.Module):
    """The last layer of a critic, answering in reward units, or in normalised units while it is trained.

    As it is made, it changes nothing: mean 0, standard deviation 1. After :meth:`forget` the standard deviation is 0
    until the first statistics: every value is 0 in reward units, whatever the scale of the rewards.

    :param linear: the critic's last layer
    """

    mean: th.Tensor
    std: th.Tensor

    def __init__(self, linear: nn.Linear) -> None:
        super().__init__()
        self.linear = linear
        self.register_buffer("mean", th.zeros((), dtype=th.float64))
        self.register_buffer("std", th.ones((), dtype=th.float64))
        self._in_normalized_units = False

    def forward(self, features: th.Tensor) -> th.Tensor:
        """Values [B, 1] of features [B, F]: in reward units, or normalised inside :meth:`normalized_units`."""
        values: th.Tensor = self.linear(features)
        if self._in_normalized_units:
            return values
        return (values * self.std + self.mean).to(values.dtype)

    @contextmanager
    def normalized_units(self) -> Iterator[None]:
        """Answer in normalised units for the duration of a ``with`` block."""
        self._in_normalized_units = True
        try:
            yield
        finally:
            self._in_normalized_units = False

    def normalize(self, values: th.Tensor) -> th.Tensor:
        """Convert values from reward units to normalised units."""
        return (values - self.mean.item()) / (self.std.item() or 1.0)

    def forget(self) -> None:
        """Start without statistics."""
        self.mean.zero_()
        self.std.zero_()

    @th.no_grad()
    def update(self, returns: NDArray[np.float32]) -> None:
        """Take mean and standard deviation from the returns of a rollout, in reward units."""
        mean, std = float(returns.mean(dtype=np.float64)), float(returns.std(dtype=np.float64))
        if std <= CONSTANT * max(abs(mean), self.std.item()):  # says nothing about scale: keep the old one
            std = self.std.item()
        old_mean, old_std = self.mean.item(), self.std.item()
        self.mean.fill_(mean)
        self.std.fill_(std)
        if old_std > 0.0:
            self.linear.weight.mul_(old_std / std)
            self.linear.bias.mul_(old_std).add_(old_mean - mean).div_(std)


class NormalizedRolloutBuffer(RolloutBuffer):
    """SB3's rollout buffer, handing out returns and old values in normalised units; advantages keep reward units."""

    value_head: NormalizedValueHead | None = None

    def _get_samples(self, *args: Any) -> Any:
        samples: Any = super()._get_samples(*args)
        if self.value_head is None:
            return samples
        normalize = self.value_head.normalize
        return samples._replace(returns=normalize(samples.returns), old_values=normalize(samples.old_values))


class NoSingleRows:
    """Leaves out minibatches of one row, as the last may be: sb3-contrib would divide by the spread of that row."""

    def get(self, batch_size: int | None = None) -> Any:
        """Hand out minibatches of at least two rows."""
        for samples in super().get(batch_size):  # type: ignore[misc]
            rows = samples.mask.sum() if hasattr(samples, "mask") else len(samples.advantages)
            if rows > 1:
                yield samples


class NormalizedMaskableBuffer(NoSingleRows, NormalizedRolloutBuffer, MaskableRolloutBuffer):
    """The same for sb3-contrib's buffer that also keeps action masks."""


class NormalizedRecurrentBuffer(NoSingleRows, NormalizedRolloutBuffer, RecurrentRolloutBuffer):
    """The same for sb3-contrib's buffer that also keeps the states of an LSTM."""
