"""Finding policies: by the name of a file, by module and class, or as another package registered them."""

from __future__ import annotations

import ast
import hashlib
import importlib
import importlib.util
import inspect
import sys
import sysconfig
from collections.abc import Iterator
from importlib.machinery import PathFinder
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from stable_baselines3.common.policies import BasePolicy

from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.registry import REPOSITORY

ENTRY_POINTS = "lawn_sb3.policies"
"""The entry-point group in which other packages register policies: ``NAME = package.module:Class``."""

SAME_RESULTS = {
    "4535044070047070": "ffbe78bc5144d441",  # centralized_critic
    "6af6655281a9f8f1": "99a188bc3dd1aec6",  # congestion_blind
    "a12de9cf4af967cc": "b73b206e0b1ad0e9",  # local_critic
    "9e2aa43065bdf43f": "509b824075f9df9d",  # masked
    "b2eb2e2a567d412a": "76553bd88d263762",  # recurrent
    "f8f352f99ef24c80": "34dc7cae15122255",  # relative
    "19d931262927cde6": "b90714e59071a68b",  # separate_actors
    "07c170e5fc5bacf9": "57ee49afabab8eab",  # set_critic
    "26cc0f3c3069869e": "c722356090109cf4",  # state_critic
    "b87e8376de149be0": "1334e2d5a961ad95",  # in_time_mixer, whose monotonic_mixer did not count before
}
"""Digests of shipped files that were written anew and still leave the same bytes: today's, and the one it counts as.

Version 0.2 gave the policies new hooks; runs made before it stay valid."""

_DIGESTS: dict[Path, str] = {}
"""What the files of policies held when they were first asked for: an edit after that is not what this process runs."""


class _Place(NamedTuple):
    """Where a policy is, before anything is imported."""

    what: str
    """What messages call it."""
    module: str
    attribute: str | None
    """The class; none for the only one in a file of ``policies/``."""
    path: Path


def find_policy(name: str) -> type[BasePolicy]:
    """Find a policy and import it.

    :param name: ``NAME`` for ``policies/NAME.py`` or for what a package registered, or ``package.module:Class``
    :return: the class
    :raises UserError: if it cannot be found or imported, or is no policy, saying what and where
    """
    policy_digest(name)  # taken down now
    place = _locate(name)
    if place.attribute is None:
        return _from_file(place.module, place.path)
    return _from_module(place.what, place.module, place.attribute)


def policy_digest(name: str) -> str:
    """Hash of a policy's file and of the user's own modules that it imports; nothing is imported for it.

    :param name: as for :func:`find_policy`
    :return: the hash, as it was when first asked for; of the kit and of installed packages only the policy's own file
        counts
    :raises UserError: if there is no such policy
    """
    place = _locate(name)
    if place.path not in _DIGESTS:
        content = b"".join(file.read_bytes() for file in _own_files(place.path, place.module))
        digest = hashlib.sha256(content).hexdigest()[:16]
        _DIGESTS[place.path] = SAME_RESULTS.get(digest, digest)
    return _DIGESTS[place.path]


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


def _locate(name: str) -> _Place:
    if ":" in name:
        module, _, attribute = name.partition(":")
        return _module_place(f"policy {name!r}", module, attribute)
    files, registered = policy_files(), {point.name: point for point in entry_points(group=ENTRY_POINTS)}
    if name in files and name in registered:
        raise UserError(f"policy {name!r} is both {str(files[name])!r} and {_told(registered[name])}: rename your file")
    if name in registered:
        point = registered[name]
        return _module_place(f"policy {name!r}, {_told(point)}", point.module, point.attr)
    if name not in files:
        raise unknown_name("policy", name, [*files, *registered, "package.module:Class"])
    same_name = [folder / f"{name}.py" for folder in policy_folders() if (folder / f"{name}.py").exists()]
    if len({path.read_bytes() for path in same_name}) > 1:
        raise UserError(f"policy {name!r} is both {str(same_name[0])!r} and one of the kit's own: rename your file")
    return _Place(f"policy {name!r}", f"policies.{name}", None, files[name])


def _told(point: EntryPoint) -> str:
    owner = f" by {point.dist.name!r}" if point.dist is not None else ""
    return f"registered{owner} as {point.value!r}"


def _module_place(what: str, module: str, attribute: str) -> _Place:
    path = _module_file(module)
    if path is None:
        raise UserError(f"{what}: module {module!r} cannot be imported: there is no such module")
    return _Place(what, module, attribute, path)


def _module_file(module: str) -> Path | None:
    """The file that Python would import a module from, found without importing it or its packages."""
    if str(Path.cwd()) not in sys.path:  # the command line knows modules beside the user too, as Python does
        sys.path.append(str(Path.cwd()))
    top, *below = module.split(".")
    try:
        spec = importlib.util.find_spec(top)
    except ValueError:  # a module that was not imported from anywhere, such as __main__
        return None
    for name in below:
        if spec is None or spec.submodule_search_locations is None:
            return None
        spec = PathFinder.find_spec(f"{spec.name}.{name}", spec.submodule_search_locations)
    return Path(spec.origin) if spec is not None and spec.has_location and spec.origin is not None else None


def _own_files(path: Path, module: str) -> list[Path]:
    """A policy's file, and after it those of the user's own modules that it imports, and that these import."""
    found = [(path, module)]
    for file, name in found:  # grows on the way
        for imported in _imports(file, name):
            own = _module_file(imported)
            if own is not None and _is_users_own(own) and own not in dict(found):
                found.append((own, imported))
    return [file for file, _ in found]


def _imports(path: Path, module: str) -> Iterator[str]:
    """Modules that the import statements of a file run, anywhere in it: those that they name, and their packages."""
    for name in _named(path, module):
        parts = name.split(".")
        yield from (".".join(parts[:end]) for end in range(1, len(parts) + 1))


def _named(path: Path, module: str) -> Iterator[str]:
    """Modules that the import statements of a file name."""
    try:
        tree = ast.parse(path.read_bytes())
    except (SyntaxError, ValueError):  # whoever imports it is told
        return
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) + 1 - node.level] if node.level else []
            base = ".".join(filter(None, [*above, node.module]))
            for alias in node.names:  # a module in a package, or something that the package itself holds
                inside = f"{base}.{alias.name}"
                yield base if _module_file(inside) is None else inside


def _is_users_own(path: Path) -> bool:
    """Whether a file is a policy's, or anything else but the kit's and what is installed."""
    path = path.resolve()
    if path.is_relative_to(REPOSITORY / "policies"):
        return path.name != "__init__.py"  # text alone
    installed = [Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "purelib", "platlib")]
    return not any(path.is_relative_to(folder) for folder in (*installed, REPOSITORY / "lawn_sb3"))


def _from_module(what: str, module_name: str, class_name: str) -> type[BasePolicy]:
    try:
        module = importlib.import_module(module_name)
    except Exception as error:
        raise UserError(f"{what}: module {module_name!r} cannot be imported: {_reason(error)}") from error
    found = getattr(module, class_name, None)
    if found is None:
        raise UserError(f"{what}: module {module_name!r} has no class {class_name!r}")
    if not (inspect.isclass(found) and issubclass(found, BasePolicy)):
        raise UserError(f"{what} is not an SB3 policy class")
    return found


def _reason(error: Exception) -> str:
    """What an import failed of, in one line."""
    return f"{type(error).__name__}: {next(iter(str(error).splitlines()), '')}"


def _from_file(module_name: str, path: Path) -> type[BasePolicy]:
    module = _import_file(module_name, path)
    own = [member for _, member in inspect.getmembers(module, inspect.isclass) if member.__module__ == module.__name__]
    found: list[type[BasePolicy]] = [member for member in own if issubclass(member, BasePolicy)]
    if len(found) != 1:
        names = ", ".join(member.__name__ for member in found or own) or "no class"
        raise UserError(
            f"policy file {str(path)!r} must hold one policy class, found {len(found)} (its classes: {names}); a "
            "policy derives from lawn_sb3.algos.mappo.CTDEPolicy, or from another base that policies/__init__.py names"
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
        raise UserError(f"policy file {str(path)!r} cannot be imported: {_reason(error)}") from error
    return module
