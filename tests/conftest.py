"""Settings that all tests share."""

from __future__ import annotations

from hypothesis import settings

# The first example of a test may have to wait for Numba to compile.
settings.register_profile("kit", deadline=None)
settings.load_profile("kit")
