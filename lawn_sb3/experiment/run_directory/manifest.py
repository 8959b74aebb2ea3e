"""``manifest.json``: what vouches for a run's files. It says how the run was made, and the SHA-256 of each file."""

import hashlib
import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import yaml

from lawn_sb3.errors import UserError, first_line
from lawn_sb3.experiment.run_directory.files import (
    CONFIG_FILE,
    FINISHED_FILE,
    LOCK_FILE,
    LOG_FILE,
    MANIFEST_FILE,
    PROVENANCE_FILE,
    RESULT_FILES,
    TENSORS_FILE,
    WEIGHTS_FILE,
)
from lawn_sb3.whole_files import write_json

LATE = "as they were kept; whether that is how the run left them is not known"
"""What a manifest says of files that it did not see as the run ended."""
NOT_VOUCHED_FOR = {MANIFEST_FILE, FINISHED_FILE, LOCK_FILE, LOG_FILE}
"""Files that belong to no result, or are written after it."""


def write_manifest(folder: Path, made: Mapping[str, Any]) -> None:
    """Vouch for all files of a folder as they are now.

    :param folder: the run's directory
    :param made: how it was made: configuration, command, commit, versions and hardware
    """
    names = sorted(path.name for path in folder.iterdir() if path.is_file() and path.name not in NOT_VOUCHED_FOR)
    _write(folder, {"made": dict(made), "files": {name: _sha256(folder / name) for name in names}})


def vouch_for(folder: Path, name: str) -> None:
    """Vouch for one file more of a run, as it is now; a run without a manifest stays without one."""
    manifest = read_manifest(folder)
    if manifest is not None:
        manifest["files"][name] = _sha256(folder / name)
        _write(folder, manifest)


def keep_manifest(folder: Path, source: Path) -> None:
    """Give a copy of some files of a run a manifest: how it was made stays as the run's own says, if it has one."""
    manifest = read_manifest(source)
    if manifest is not None:
        write_manifest(folder, manifest["made"])
    else:
        vouch_late(folder)


def vouch_late(folder: Path) -> None:
    """Vouch for all files of a run that was made without a manifest, as they are now; the manifest says so.

    :param folder: the run's directory
    :raises UserError: if it does not say how it was made
    """
    try:
        record = json.loads((folder / PROVENANCE_FILE).read_text(encoding="utf-8"))
        configuration = yaml.safe_load((folder / CONFIG_FILE).read_text(encoding="utf-8"))
        write_manifest(folder, {**record, "configuration": configuration, "vouched_for": LATE})
    except (OSError, ValueError, TypeError, yaml.YAMLError) as error:
        raise UserError(f"{str(folder)!r} does not say how it was made: {first_line(error)}") from None


def read_manifest(folder: Path) -> dict[str, Any] | None:
    """Read what a run says of its files.

    :param folder: the run's directory
    :return: ``made`` and ``files``; none if it has no manifest
    :raises UserError: if the manifest is damaged
    """
    try:
        content = json.loads((folder / MANIFEST_FILE).read_text(encoding="utf-8"))
        if content.pop("sha256") != _digest(content) or not isinstance(content["files"], dict):
            raise ValueError
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise UserError(f"{str(folder / MANIFEST_FILE)!r} is damaged: nothing vouches for the run's files") from None
    manifest: dict[str, Any] = content
    return manifest


def altered_files(folder: Path) -> list[str]:
    """Files of a run that are not what its manifest says, are missing, or are results that it does not know.

    :param folder: the run's directory
    :return: their names; none of a run that has no manifest
    :raises UserError: if the manifest is damaged
    """
    manifest = read_manifest(folder)
    if manifest is None:
        return []
    files: Mapping[str, str] = manifest["files"]
    known = (*RESULT_FILES, WEIGHTS_FILE, TENSORS_FILE)
    results: Collection[str] = [name for name in known if (folder / name).exists()]
    altered = [name for name, digest in files.items() if not _is(folder / name, digest)]
    return altered + [name for name in results if name not in files]


def check_unaltered(folder: Path) -> None:
    """Refuse a run whose files are not what it left."""
    if altered := altered_files(folder):
        raise UserError(f"{str(folder)!r}: {', '.join(altered)} not as the run left it, by its {MANIFEST_FILE}")


def _write(folder: Path, manifest: dict[str, Any]) -> None:
    write_json(folder / MANIFEST_FILE, {"sha256": _digest(manifest), **manifest})


def _digest(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _is(path: Path, digest: str) -> bool:
    try:
        return _sha256(path) == digest
    except OSError:
        return False
