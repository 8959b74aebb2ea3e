"""How functions are compiled: cached on disk, and never run from a cache older than the source.

Numba checks only the file of the compiled function; a change in a function that it calls from another file would go
unnoticed. The cache folder is therefore named after the content of all files with compiled functions.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar, cast

import numba

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

_SOURCES = sorted(Path(__file__).parent.parent.rglob("*.py"))
_COMPILED = (path.read_bytes() for path in _SOURCES if b"njit" in path.read_bytes())
_DIGEST = hashlib.sha256(b"".join(_COMPILED)).hexdigest()

if not numba.config.CACHE_DIR:  # type: ignore[attr-defined]
    numba.config.CACHE_DIR = str(Path(__file__).parent / "__pycache__" / f"numba-{_DIGEST[:16]}")  # type: ignore[attr-defined]


def njit(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Compile a function with Numba; the type checker still sees its type."""
    return cast(Callable[Parameters, Result], numba.njit(cache=True)(function))
