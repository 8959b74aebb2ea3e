"""Where a policy is, before anything is imported: a file by its name, a module, or what another package registered."""

import importlib.util
import sys
from collections.abc import Collection
from importlib.machinery import PathFinder
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import NamedTuple

from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.registry import REPOSITORY

ENTRY_POINTS = "lawn_sb3.policies"
"""The entry-point group in which other packages register policies: ``NAME = package.module:Class``."""

OF_KIT = ("lawn_sb3", "stable_baselines3", "sb3_contrib")
"""Packages whose modules hold policies that come with the kit."""


class Place(NamedTuple):
    """Where a policy is, before anything is imported."""

    what: str
    """What messages call it."""
    module: str
    attribute: str | None
    """The class; none for the only one in a file of ``policies/``."""
    path: Path


def _folders() -> list[Path]:
    """``policies/`` in the working directory, then the kit's own."""
    folders = [Path.cwd() / "policies", REPOSITORY / "policies"]
    return [folder for folder in dict.fromkeys(folders) if folder.is_dir()]


def locate(name: str) -> Place:
    """Find out where a policy is.

    :param name: ``NAME`` for ``policies/NAME.py`` or for what a package registered, or ``package.module:Class``
    :return: its place
    :raises UserError: if there is no such file or module, or two have the name
    """
    if ":" in name:
        module, _, attribute = name.partition(":")
        return _module_place(f"policy {name!r}", module, attribute)
    files = {path.stem: path for folder in _folders() for path in sorted(folder.glob("[!_]*.py"))}
    registered = {point.name: point for point in entry_points(group=ENTRY_POINTS)}
    if name in files and name in registered:
        raise UserError(f"policy {name!r} is both {str(files[name])!r} and {_told(registered[name])}: rename your file")
    if name in registered:
        point = registered[name]
        return _module_place(f"policy {name!r}, {_told(point)}", point.module, point.attr)
    if name not in files:
        raise unknown_name("policy", name, [*files, *registered, "package.module:Class"])
    same_name = [folder / f"{name}.py" for folder in _folders() if (folder / f"{name}.py").exists()]
    if len({path.read_bytes() for path in same_name}) > 1:
        raise UserError(f"policy {name!r} is both {str(same_name[0])!r} and one of the kit's own: rename your file")
    return Place(f"policy {name!r}", f"policies.{name}", None, files[name])


def check_trusted(name: str, trusted: Collection[str], where: str) -> None:
    """Refuse a policy that a run's files name and that comes neither with the kit nor with an installed package.

    Importing a policy runs what its file holds, and whoever made the run chose its name.

    :param name: the policy's name
    :param trusted: names that the user vouches for
    :param where: what names it, for the message
    :raises UserError: if it is not one of them either
    """
    if name in trusted or is_installed(name):
        return
    raise UserError(
        f"{where} names the policy {name!r}, which does not come with the kit: it would be imported, and could do "
        f"anything; --trust {name} allows it"
    )


def is_installed(name: str) -> bool:
    """Whether a policy comes with the kit or with an installed package.

    :param name: the policy's name
    :return: true if whoever has these installed has it too
    :raises UserError: if there is none of that name
    """
    registered = {value for point in entry_points(group=ENTRY_POINTS) for value in (point.name, point.value)}
    if ":" in name or name in registered:
        return name in registered or name.partition(".")[0] in OF_KIT
    return locate(name).path.is_relative_to(REPOSITORY / "policies")


def _told(point: EntryPoint) -> str:
    owner = f" by {point.dist.name!r}" if point.dist is not None else ""
    return f"registered{owner} as {point.value!r}"


def _module_place(what: str, module: str, attribute: str) -> Place:
    path = module_file(module)
    if path is None:
        raise UserError(f"{what}: module {module!r} cannot be imported: there is no such module")
    return Place(what, module, attribute, path)


def module_file(module: str) -> Path | None:
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
