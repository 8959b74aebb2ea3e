"""Finding policies: by the name of a file, by module and class, or as another package registered them."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import sys
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType

from stable_baselines3.common.policies import BasePolicy

from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.registry import REPOSITORY

ENTRY_POINTS = "lawn_sb3.policies"
"""The entry-point group in which other packages register policies: ``NAME = package.module:Class``."""


def find_policy(name: str) -> type[BasePolicy]:
    """Find a policy.

    :param name: ``NAME`` for ``policies/NAME.py`` or for what a package registered, or ``package.module:Class``
    :return: the class
    :raises UserError: if it cannot be found or imported, or is no policy, saying what and where
    """
    if ":" in name:
        module_name, _, class_name = name.partition(":")
        return _from_module(module_name, class_name, f"policy {name!r}")
    files, registered = policy_files(), {point.name: point for point in entry_points(group=ENTRY_POINTS)}
    if name in files and name in registered:
        raise UserError(f"policy {name!r} is both {str(files[name])!r} and {_told(registered[name])}: rename your file")
    if name in registered:
        point = registered[name]
        return _from_module(point.module, point.attr, f"policy {name!r}, {_told(point)}")
    if name not in files:
        raise unknown_name("policy", name, [*files, *registered, "package.module:Class"])
    return _from_file(name, files[name])


def policy_folders() -> list[Path]:
    """Where policies are looked for.

    :return: ``policies/`` in the working directory, then the kit's own
    """
    folders = [Path.cwd() / "policies", REPOSITORY / "policies"]
    return [folder for folder in dict.fromkeys(folders) if folder.is_dir()]


def policy_files() -> dict[str, Path]:
    """The policies that lie in files.

    :return: file by name
    """
    return {path.stem: path for folder in policy_folders() for path in sorted(folder.glob("[!_]*.py"))}


def _told(point: EntryPoint) -> str:
    owner = f" by {point.dist.name!r}" if point.dist is not None else ""
    return f"registered{owner} as {point.value!r}"


def _from_module(module_name: str, class_name: str, what: str) -> type[BasePolicy]:
    try:
        module = importlib.import_module(module_name)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}"
        raise UserError(f"{what}: module {module_name!r} cannot be imported: {reason}") from error
    found = getattr(module, class_name, None)
    if found is None:
        raise UserError(f"{what}: module {module_name!r} has no class {class_name!r}")
    if not (inspect.isclass(found) and issubclass(found, BasePolicy)):
        raise UserError(f"{what} is not an SB3 policy class")
    return found


def _from_file(name: str, path: Path) -> type[BasePolicy]:
    same_name = [folder / f"{name}.py" for folder in policy_folders() if (folder / f"{name}.py").exists()]
    if len({path.read_bytes() for path in same_name}) > 1:
        raise UserError(f"policy {name!r} is both {str(same_name[0])!r} and one of the kit's own: rename your file")
    module = _import_file(f"policies.{name}", path)
    own = [member for _, member in inspect.getmembers(module, inspect.isclass) if member.__module__ == module.__name__]
    found: list[type[BasePolicy]] = [member for member in own if issubclass(member, BasePolicy)]
    if len(found) != 1:
        names = ", ".join(member.__name__ for member in found or own) or "no class"
        raise UserError(
            f"policy file {str(path)!r} must hold one policy class, found {len(found)} ({names}): a policy derives "
            "from lawn_sb3.algos.mappo.CTDEPolicy or another SB3 policy"
        )
    return found[0]


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
