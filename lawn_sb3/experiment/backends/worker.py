"""A process that does jobs, one after the other, and ends with the process that started it."""

import ctypes
import multiprocessing
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from lawn_sb3.errors import Notice, said
from lawn_sb3.experiment.backends.job import Progress

SET_PARENT_DEATH_SIGNAL = 1
"""Linux, ``prctl``: which signal a process gets when its parent ends."""
ONE_THREAD = {"OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""The environment of a process that does jobs: Numba and BLAS read their number of threads when it starts."""
REPORT_SECONDS = 0.2
"""The least time between two reports of progress."""


def serve(pipe: Connection) -> None:
    """Do the jobs that come through a pipe until it is closed.

    :param pipe: work comes in; out go ``("progressed", env_steps)`` and ``("noted", text)``, and in the end
        ``("finished", value)`` or ``("failed", reason)``
    """
    end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what an interrupt ends
    signal.signal(signal.SIGTERM, _end)
    tell_notices(lambda text: pipe.send(("noted", text)))
    while True:
        try:
            work = pipe.recv()
        except EOFError:
            return
        pipe.send(answer(work, lambda env_steps: pipe.send(("progressed", env_steps))))


def answer(work: Callable[[Progress], Any], tell: Progress) -> tuple[str, Any]:
    """Do one job, and say what became of it.

    :param work: what does it
    :param tell: called now and then with the env steps done so far
    :return: ``("finished", value)`` or ``("failed", reason)``
    """
    last = 0.0

    def report(env_steps: int) -> None:
        nonlocal last
        if time.monotonic() - last > REPORT_SECONDS:
            last = time.monotonic()
            tell(env_steps)

    try:
        return "finished", work(report)
    except Exception as error:  # of whatever kind: it is this job's alone
        return "failed", said(error)


def tell_notices(tell: Callable[[str], None]) -> None:
    """Tell the user of each :class:`lawn_sb3.errors.Notice` in one line; other warnings stay as they are.

    :param tell: called with the line
    """
    others = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if issubclass(category, Notice):
            tell(str(message))
        else:
            others(message, category, *where, **more)

    warnings.simplefilter("always", Notice)
    warnings.showwarning = show


def end_with_parent() -> None:
    """Make this process end as soon as the one that started it does, however that ended.

    Linux ends it at once, also in the midst of compiled code; elsewhere a thread does that waits for the parent.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(SET_PARENT_DEATH_SIGNAL, signal.SIGKILL)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_outlive, args=(parent,), daemon=True).start()


def _outlive(parent: BaseProcess) -> None:
    parent.join()
    os._exit(1)


def _end(*_: Any) -> None:
    """End in order: what was begun to be written is removed on the way out."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    sys.exit(128 + signal.SIGTERM)
