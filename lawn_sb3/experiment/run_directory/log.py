"""``worker.log``: what a run prints while others run beside it, whatever part of the process prints it."""

import faulthandler
import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def logged(path: Path) -> Iterator[None]:
    """Let all that this process prints go to a file, tracebacks of failures and crashes included.

    :param path: the file; it is appended to, and removed if it stays empty
    """
    kept = [os.dup(number) for number in (1, 2)]
    with path.open("ab") as file:
        for number in (1, 2):
            os.dup2(file.fileno(), number)
    faulthandler.enable(file=2)
    try:
        yield
    except Exception:
        traceback.print_exc()
        raise
    finally:
        faulthandler.disable()
        for stream, number, before in zip((sys.stdout, sys.stderr), (1, 2), kept, strict=True):
            stream.flush()
            os.dup2(before, number)
            os.close(before)
        if path.stat().st_size == 0:
            path.unlink()
