"""Settings that all tests share."""

from __future__ import annotations

import pytest
import torch as th
from hypothesis import settings

# The first example of a test may have to wait for Numba to compile.
settings.register_profile("kit", deadline=None)
settings.load_profile("kit")


@pytest.fixture(scope="session", autouse=True)
def _one_torch_thread() -> None:
    """Small networks are fastest on one thread, and with one alone the same seed gives the same numbers."""
    th.set_num_threads(1)
