"""What a run's fingerprint knows of its policy: a hash of the policy's file and of the user's own modules behind it."""

import ast
import hashlib
import sysconfig
from collections.abc import Iterator
from pathlib import Path

from lawn_sb3.experiment.policy_places import locate, module_file
from lawn_sb3.experiment.registry import REPOSITORY

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
    "6b5d9f45f19cabfa": "79eb185cf1e30711",  # foresees_cells, whose trust may be a whole number
}
"""Digests of shipped files that were written anew and still leave the same bytes: today's, and the one it counts as.

Version 0.2 gave the policies new hooks; runs made before it stay valid."""

INSTALLED = {"site-packages", "dist-packages"}
"""Folders of installed packages, those of another environment that this one builds on too."""
_STANDARD_LIBRARY = Path(sysconfig.get_path("stdlib")).resolve()

_DIGESTS: dict[Path, str] = {}
"""What the files of policies held when they were first asked for: an edit after that is not what this process runs."""


def policy_digest(name: str) -> str:
    """Hash of a policy's file and of the user's own modules that it imports; nothing is imported for it.

    :param name: as for :func:`find_policy`
    :return: the hash, as it was when first asked for; of the kit and of installed packages only the policy's own file
        counts
    :raises UserError: if there is no such policy
    """
    place = locate(name)
    if place.path not in _DIGESTS:
        content = b"".join(file.read_bytes() for file in _own_files(place.path, place.module))
        digest = hashlib.sha256(content).hexdigest()[:16]
        _DIGESTS[place.path] = SAME_RESULTS.get(digest, digest)
    return _DIGESTS[place.path]


def _own_files(path: Path, module: str) -> list[Path]:
    """A policy's file, and after it those of the user's own modules that it imports, and that these import."""
    found = [(path, module)]
    for file, name in found:  # grows on the way
        for imported in _imports(file, name):
            own = module_file(imported)
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
                yield base if module_file(inside) is None else inside


def _is_users_own(path: Path) -> bool:
    """Whether a file is a policy's, or anything else but the kit's and what is installed."""
    path = path.resolve()
    if path.is_relative_to(REPOSITORY / "policies"):
        return path.name != "__init__.py"  # text alone
    if INSTALLED & set(path.parts):
        return False
    return not any(path.is_relative_to(folder) for folder in (_STANDARD_LIBRARY, REPOSITORY / "lawn_sb3"))
