"""What somebody may plant in a file: a pickle that leaves a trace where it is read."""

from pathlib import Path
from typing import Any


class Payload:
    """Unpickled, it makes a file.

    :param trace: the file
    """

    def __init__(self, trace: Path) -> None:
        self.trace = trace

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.trace,)
