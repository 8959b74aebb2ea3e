"""What a name stands for: algorithms, policies and players without training."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.policies import BasePolicy

import lawn_sb3
from lawn_sb3.algos.iql import IQL
from lawn_sb3.algos.mappo import MAPPO
from lawn_sb3.algos.qmix import QMIX
from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.game.player import Player, RandomPlayer
from lawn_sb3.planning import ShortestPathPlayer

ALGORITHMS: dict[str, type[BaseAlgorithm]] = {"mappo": MAPPO, "iql": IQL, "qmix": QMIX}
DEFAULT_POLICIES: dict[str, str] = {"mappo": "centralized_critic", "iql": "local_q", "qmix": "monotonic_mixer"}
PLAYERS: dict[str, Callable[[], Player]] = {"random": RandomPlayer, "shortest-path": ShortestPathPlayer}

REPOSITORY = Path(lawn_sb3.__file__).parents[1]


def find_algorithm(name: str) -> type[BaseAlgorithm]:
    """Find an algorithm.

    :param name: its name, such as ``mappo``
    :return: the class
    :raises UserError: if there is none of that name
    """
    if name not in ALGORITHMS:
        raise unknown_name("algorithm", name, ALGORITHMS)
    return ALGORITHMS[name]


def find_player(name: str) -> Player:
    """Find a player that needs no training.

    :param name: its name, such as ``random``
    :return: a new player
    :raises UserError: if there is none of that name
    """
    if name not in PLAYERS:
        raise unknown_name("player", name, PLAYERS)
    return PLAYERS[name]()


def policy_folders() -> list[Path]:
    """Where policies are looked for.

    :return: ``policies/`` in the working directory, then the kit's own
    """
    folders = [Path.cwd() / "policies", REPOSITORY / "policies"]
    return [folder for folder in dict.fromkeys(folders) if folder.is_dir()]


def find_policy(name: str) -> type[BasePolicy]:
    """Find a policy.

    :param name: ``NAME`` for ``policies/NAME.py``, or ``package.module:Class``
    :return: the class
    :raises UserError: if it cannot be found or imported, saying what and where
    """
    module_name, colon, class_name = name.partition(":")
    if colon:
        found = getattr(_import(module_name), class_name, None)
        if found is None:
            raise UserError(f"policy {name!r}: module {module_name!r} has no class {class_name!r}")
        classes = [found]
    else:
        files = {path.stem: path for folder in policy_folders() for path in folder.glob("[!_]*.py")}
        if name not in files:
            raise unknown_name("policy", name, [*files, "package.module:Class"])
        same_name = [folder / f"{name}.py" for folder in policy_folders() if (folder / f"{name}.py").exists()]
        if len({path.read_bytes() for path in same_name}) > 1:
            raise UserError(f"policy {name!r} is both {str(same_name[0])!r} and one of the kit's own: rename your file")
        module = _import_file(f"policies.{name}", files[name])
        classes = [
            member
            for _, member in inspect.getmembers(module, inspect.isclass)
            if issubclass(member, BasePolicy) and member.__module__ == module.__name__
        ]
        if len(classes) != 1:
            raise UserError(f"policy file {str(files[name])!r} must hold one policy class, found {len(classes)}")
    if not (inspect.isclass(classes[0]) and issubclass(classes[0], BasePolicy)):
        raise UserError(f"policy {name!r} is not an SB3 policy class")
    policy: type[BasePolicy] = classes[0]
    return policy


def _import(module_name: str) -> ModuleType:
    try:
        return importlib.import_module(module_name)
    except Exception as error:
        raise UserError(f"policy module {module_name!r} cannot be imported: {type(error).__name__}: {error}") from error


def _import_file(module_name: str, path: Path) -> ModuleType:
    """Import a file under a name of its own, so that models saved with its class can be loaded again."""
    known = sys.modules.get(module_name)
    if known is not None and known.__file__ == str(path):
        return known
    spec = importlib.util.spec_from_file_location(module_name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[module_name]
        raise UserError(f"policy file {str(path)!r} cannot be imported: {type(error).__name__}: {error}") from error
    return module
