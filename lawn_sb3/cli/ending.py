"""How a command ends before it is done: in order, by Ctrl-C and by SIGTERM, with a line and the status of each."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_came = signal.SIGINT
"""The signal that ended what ran; whoever passes an interrupt on may raise another one in its place."""


def interrupted_status() -> int:
    """The exit status that says which signal ended a command."""
    return 128 + _came


@contextmanager
def ending_in_order() -> Iterator[None]:
    """Make SIGTERM end what runs as Ctrl-C does; what was started with Ctrl-C ignored goes on ignoring it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heeded = [signal.SIGTERM]
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        heeded.append(signal.SIGINT)
    before = {number: signal.signal(number, _end) for number in heeded}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _end(number: int, frame: FrameType | None) -> None:
    global _came
    for heeded in (signal.SIGTERM, signal.SIGINT):
        signal.signal(heeded, signal.SIG_IGN)  # ending takes two seconds; some send a signal twice
    _came = signal.Signals(number)
    raise KeyboardInterrupt
