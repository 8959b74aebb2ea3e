"""Writing files so that each is there whole or not at all, also when the disk is full or the writer is ended."""

import errno
import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


@contextmanager
def named(path: Path) -> Iterator[None]:
    """Let errors of the system name what is being written, as the user knows it: a disk that is full names nothing."""
    try:
        yield
    except OSError as error:
        error.filename, error.filename2 = str(path), None
        raise


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Write a file in one go.

    :param path: the file
    :return: where to write; moved into place at the end, and removed on failure
    :raises OSError: if it cannot be written, or what is there is no file: a folder, a device, a pipe
    """
    target = path.resolve()  # what a link points to is written, the link stays
    if target.exists() and not target.is_file():
        raise OSError(errno.EEXIST, "There is something else than a file", str(path))
    part = target.with_name(f"part-{path.name}")
    try:
        with named(path):
            yield part
            part.replace(target)
    finally:
        if part.parent.is_dir():
            part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file in one go."""
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")


def write_json(path: Path, content: dict[str, Any]) -> None:
    """Write a JSON file in one go."""
    write_text(path, json.dumps(content, indent=2) + "\n")
