"""Which classes a file may name: those of networks, optimisers and buffers, from where nobody can slip one in."""

import importlib
import importlib.util
import inspect
import sys
from importlib.metadata import entry_points
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import torch as th
from stable_baselines3.common.buffers import BaseBuffer
from torch import nn

import lawn_sb3

HARMLESS = (nn.Module, th.optim.Optimizer, BaseBuffer)
"""What a class has to derive from."""
SHIPPED = ("torch", "stable_baselines3", "sb3_contrib", "lawn_sb3")
"""Packages whose modules are imported for it; of others, what is imported already, is shipped or registered counts."""
POLICIES = Path(lawn_sb3.__file__).parents[1] / "policies"


def name_of(found: type) -> str:
    """The name by which :func:`find_class` finds a class."""
    return f"{found.__module__}:{found.__qualname__}"


def find_class(name: str) -> type:
    """Find a class that a file names.

    :param name: ``module:Class``
    :return: the class
    :raises ValueError: if it is none that a file may name
    """
    module = name.partition(":")[0]
    if module not in sys.modules and not _import(module, name):
        raise ValueError(
            f"{name!r} is neither shipped nor registered, and is not imported because a file names it: import it first"
        )
    try:
        found: Any = resolve_name(name)
    except (ImportError, AttributeError, ValueError):
        found = None
    if not (inspect.isclass(found) and issubclass(found, HARMLESS)):
        raise ValueError(f"{name!r} is no class of a network, optimiser or buffer")
    return found


def _import(module: str, name: str) -> bool:
    """Import a module if it is one that a file may name; whether it is there now."""
    package, _, own = module.partition(".")
    registered = {point.value for point in entry_points(group="lawn_sb3.policies")}
    if package in SHIPPED or name in registered:
        try:
            importlib.import_module(module)
        except ImportError:
            return False
        return True
    path = POLICIES / f"{own}.py"
    if package != "policies" or not own.isidentifier() or not path.exists():
        return False
    spec = importlib.util.spec_from_file_location(module, path)
    assert spec is not None
    assert spec.loader is not None
    sys.modules[module] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[module])
    return True
