"""One writer at a time in a folder: whoever comes second is told who the first one is, and touches nothing.

The lock is the system's own, so that it goes when its holder ends, however that ended. On a shared file system that
knows no locks, the file itself is the lock; whoever finds one there of a process that has ended on the same host takes
it over. A writer whose machine has ended may hold its lock for a while, or for ever: it is taken over once somebody has
said so.
"""

import json
import os
import socket
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple, Self

from filelock import BaseFileLock, FileLock, Timeout

from lawn_sb3.errors import HeldError
from lawn_sb3.experiment.run_directory.files import LOCK_FILE
from lawn_sb3.whole_files import named

PATIENCE_SECONDS = 3.0
"""How long a writer that was ended may take to let go: its processes have two seconds."""
LEASE_SECONDS = 120.0
"""How long the lock of a writer who has ended is waited for before it is taken over.

Servers of NFS keep the locks of a machine that is gone for one lease, 90 s as a rule. A machine that is only cut off
from its Ray cluster ends its processes within 60 s."""


class Writer(NamedTuple):
    """Who writes, or wrote, in a folder."""

    host: str
    pid: int

    @classmethod
    def here(cls) -> Self:
        """Take this process."""
        return cls(socket.gethostname(), os.getpid())


ENDED: set[Writer] = set()
"""Writers who are known to have ended, though a shared file system may not know it: they lose their locks."""


@contextmanager
def only_writer(folder: Path) -> Iterator[None]:
    """Be the only one who writes in a folder; it is made if it is not there.

    :param folder: a run's directory, or that of all runs of a recipe
    :raises HeldError: naming who else writes there
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / LOCK_FILE
    lock = FileLock(path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # that the file itself is the lock
        _acquire(lock, path)
    try:
        if isinstance(lock, FileLock):  # else it is a SoftFileLock by now, whose file has its own content
            since = datetime.now(UTC).isoformat(timespec="seconds")
            with named(path):
                path.write_text(json.dumps({**Writer.here()._asdict(), "since": since}), "utf-8")
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
    writer, told = _holder(path)
    try:
        if writer is not None and writer.host == Writer.here().host:
            os.kill(writer.pid, 0)  # signal 0 asks whether there is such a process
    except ProcessLookupError:
        return None
    except OSError:  # somebody else's process
        return told
    return told


def remove_parts(folder: Path) -> None:
    """Remove what a writer left that was ended in the midst of a file."""
    for left in folder.glob("part-*"):
        if left.is_file():
            left.unlink(missing_ok=True)


def _acquire(lock: BaseFileLock, path: Path) -> None:
    """Get a lock, that of a writer who is known to have ended too.

    :raises HeldError: naming who has it
    """
    for seconds in (PATIENCE_SECONDS, LEASE_SECONDS, PATIENCE_SECONDS):
        try:
            lock.acquire(timeout=seconds)
            return
        except Timeout:
            writer, told = _holder(path)
            if writer not in ENDED:
                raise HeldError(f"{str(path.parent)!r} is being written by {told}: wait for it, or end it") from None
            if seconds == LEASE_SECONDS:
                path.unlink(missing_ok=True)  # a lock of a file that has no name any more is nobody's


def _holder(path: Path) -> tuple[Writer | None, str]:
    """Who holds a lock, as far as its file says, and the words for that."""
    try:
        text = path.read_text(encoding="utf-8")
        if text.startswith("{"):
            content = json.loads(text)
            writer, since = Writer(content["host"], int(content["pid"])), f" since {content['since']}"
        else:  # of a SoftFileLock; after a question mark stands the host's name space of processes
            pid, host, *_ = text.split("\n")
            writer, since = Writer(host.partition("?")[0], int(pid)), ""
    except (OSError, ValueError, KeyError, TypeError):
        return None, "another process"
    return writer, f"process {writer.pid} on {writer.host}{since}"
