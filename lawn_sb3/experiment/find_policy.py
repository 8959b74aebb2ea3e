"""Finding policies and importing them."""

import importlib
import importlib.util
import inspect
import sys
from pathlib import Path
from types import ModuleType

from stable_baselines3.common.policies import BasePolicy

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.policy_digest import policy_digest
from lawn_sb3.experiment.policy_places import locate


def find_policy(name: str) -> type[BasePolicy]:
    """Find a policy and import it.

    :param name: ``NAME`` for ``policies/NAME.py`` or for what a package registered, or ``package.module:Class``
    :return: the class
    :raises UserError: if it cannot be found or imported, or is no policy, saying what and where
    """
    policy_digest(name)  # taken down now
    place = locate(name)
    if place.attribute is None:
        return _from_file(place.module, place.path)
    return _from_module(place.what, place.module, place.attribute)


def _from_module(what: str, module_name: str, class_name: str) -> type[BasePolicy]:
    try:
        module = importlib.import_module(module_name)
    except (Exception, SystemExit) as error:
        raise UserError(f"{what}: module {module_name!r} cannot be imported: {_reason(error)}") from error
    found = getattr(module, class_name, None)
    if found is None:
        raise UserError(f"{what}: module {module_name!r} has no class {class_name!r}")
    if not (inspect.isclass(found) and issubclass(found, BasePolicy)):
        raise UserError(f"{what} is not an SB3 policy class")
    return found


def _reason(error: BaseException) -> str:
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
    except (Exception, SystemExit) as error:
        del sys.modules[module_name]
        raise UserError(f"policy file {str(path)!r} cannot be imported: {_reason(error)}") from error
    return module
