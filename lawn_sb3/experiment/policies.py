"""Finding policies: by the name of a file, by module and class, or as another package registered them."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import sys
import sysconfig
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType

from stable_baselines3.common.policies import BasePolicy

from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.registry import REPOSITORY

ENTRY_POINTS = "lawn_sb3.policies"
"""The entry-point group in which other packages register policies: ``NAME = package.module:Class``."""


_DIGESTS: dict[type[BasePolicy], str] = {}
"""What the files of policies held when they were imported: one that is edited later is not what this process runs."""


def policy_digest(policy: type[BasePolicy]) -> str:
    """Hash of the files that hold a policy and what it derives from, as they were when it was found.

    :param policy: a class that :func:`find_policy` returned
    :return: the hash; files of the kit itself and of installed packages do not count, but for the policy's own
    """
    if policy not in _DIGESTS:
        files = [inspect.getfile(policy)]
        files += [inspect.getfile(base) for base in policy.__mro__[1:] if _is_users_own(base)]
        content = b"".join(Path(file).read_bytes() for file in dict.fromkeys(files))
        _DIGESTS[policy] = hashlib.sha256(content).hexdigest()[:16]
    return _DIGESTS[policy]


def _is_users_own(base: type) -> bool:
    """Whether a class lies in a file of the working folder or of ``policies/``, not of the kit or its environment."""
    if base.__module__ == "builtins":
        return False
    path = Path(inspect.getfile(base)).resolve()
    installed = [Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "purelib", "platlib")]
    near = any(path.is_relative_to(folder) for folder in (Path.cwd(), REPOSITORY))
    return near and not any(path.is_relative_to(folder) for folder in (*installed, REPOSITORY / "lawn_sb3"))


def find_policy(name: str) -> type[BasePolicy]:
    """Find a policy.

    :param name: ``NAME`` for ``policies/NAME.py`` or for what a package registered, or ``package.module:Class``
    :return: the class
    :raises UserError: if it cannot be found or imported, or is no policy, saying what and where
    """
    policy = _find(name)
    policy_digest(policy)  # taken down now
    return policy


def _find(name: str) -> type[BasePolicy]:
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
    if str(Path.cwd()) not in sys.path:  # the command line knows modules beside the user too, as Python does
        sys.path.append(str(Path.cwd()))
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
