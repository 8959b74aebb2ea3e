"""One writer at a time in a folder: whoever comes second is told who the first one is, and touches nothing.

The lock is the system's own, so that it goes when its holder ends, however that ended. On a shared file system that
knows no locks, the file itself is the lock; whoever finds one there of a process that has ended on the same host takes
it over.
"""

import json
import os
import socket
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path

from filelock import FileLock, Timeout

from lawn_sb3.errors import HeldError
from lawn_sb3.experiment.run_directory.files import LOCK_FILE

PATIENCE_SECONDS = 3.0
"""How long a writer that was ended may take to let go: its processes have two seconds."""


@contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Be the only one who writes in a folder; it is made if it is not there.

    :param folder: a run's directory, or that of all runs of a recipe
    :raises HeldError: naming who else writes there
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / LOCK_FILE
    lock = FileLock(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # that the file itself is the lock
            lock.acquire(timeout=PATIENCE_SECONDS)
    except Timeout:
        raise HeldError(f"{str(folder)!r} is being written by {_holder(path)}: wait for it, or end it") from None
    try:
        if isinstance(lock, FileLock):  # else it is a SoftFileLock by now, whose file has its own content
            since = datetime.now(UTC).isoformat(timespec="seconds")
            path.write_text(json.dumps({"host": socket.gethostname(), "pid": os.getpid(), "since": since}), "utf-8")
        remove_parts(folder)
        yield
    finally:
        if isinstance(lock, FileLock):
            path.unlink(missing_ok=True)  # while it is held: whoever waits for it finds that this is no file any more
        lock.release()


def who_writes(folder: Path) -> str | None:
    """Who writes in a folder now, by the file that they hold; the folder is left as it is.

    :param folder: a run's directory
    :return: process, host and time; none if nobody does, or who did was ended
    """
    path = folder / LOCK_FILE
    if not path.exists():
        return None
    try:
        holder = json.loads(path.read_text(encoding="utf-8"))
        if holder["host"] == socket.gethostname():
            os.kill(int(holder["pid"]), 0)  # signal 0 asks whether there is such a process
    except ProcessLookupError:
        return None
    except (OSError, ValueError, KeyError, TypeError):  # somebody else's process, or a lock that says less
        return _holder(path)
    return _holder(path)


def remove_parts(folder: Path) -> None:
    """Remove what a writer left that was ended in the midst of a file."""
    for left in folder.glob("part-*"):
        if left.is_file():
            left.unlink(missing_ok=True)


def _holder(path: Path) -> str:
    """Who holds a lock, as far as its file says."""
    try:
        text = path.read_text(encoding="utf-8")
        holder = json.loads(text)
        return f"process {holder['pid']} on {holder['host']} since {holder['since']}"
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"
