"""How the game's functions are compiled: cached on disk, and never run from a cache older than the source.

Numba looks at the file of the compiled function alone; a change in a function that it calls from another file would
go unnoticed. The cache therefore lies in a folder named after the content of all files of the game.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import ParamSpec, TypeVar, cast

import numba

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

_SOURCES = sorted(Path(__file__).parent.parent.rglob("*.py"))
_DIGEST = hashlib.sha256(b"".join(path.read_bytes() for path in _SOURCES if "njit" in path.read_text())).hexdigest()

if not numba.config.CACHE_DIR:  # type: ignore[attr-defined]
    numba.config.CACHE_DIR = str(Path(__file__).parent / "__pycache__" / f"numba-{_DIGEST[:16]}")  # type: ignore[attr-defined]


def njit(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Compile a function with Numba, keeping its type for the type checker.

    :param function: a function in Numba's subset of Python
    :return: the compiled function
    """
    return cast(Callable[Parameters, Result], numba.njit(cache=True)(function))
