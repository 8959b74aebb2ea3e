"""How a command ends before it is done: in order, by Ctrl-C and by SIGTERM, with a line and the status of each."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class Terminated(KeyboardInterrupt):
    """An interrupt that came as SIGTERM."""


def status_of(interrupt: KeyboardInterrupt) -> int:
    """The exit status that says what ended a command."""
    return 128 + (signal.SIGTERM if isinstance(interrupt, Terminated) else signal.SIGINT)


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
    for heeded in (signal.SIGTERM, signal.SIGINT):
        signal.signal(heeded, signal.SIG_IGN)  # ending takes two seconds; some send a signal twice
    raise Terminated if number == signal.SIGTERM else KeyboardInterrupt
