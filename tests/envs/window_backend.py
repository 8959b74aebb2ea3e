"""A backend of matplotlib's whose windows nobody sees: it keeps what they show."""

from typing import Any, ClassVar

import numpy as np
from matplotlib.backend_bases import FigureManagerBase
from matplotlib.backends.backend_agg import FigureCanvasAgg

NAME = f"module://{__name__}"


class FigureManager(FigureManagerBase):
    """Windows that are open, and how often one was opened."""

    opened: ClassVar[list[Any]] = []
    is_open = False

    def show(self) -> None:
        self.is_open = True
        self.opened.append(self)

    def destroy(self) -> None:
        self.is_open = False


class FigureCanvas(FigureCanvasAgg):
    """Keeps the pictures that were waited for."""

    manager_class = FigureManager
    shown: ClassVar[list[tuple[float, Any]]] = []

    def start_event_loop(self, timeout: float = 0) -> None:
        self.draw()  # type: ignore[no-untyped-call]
        self.shown.append((timeout, np.asarray(self.buffer_rgba())[..., :3].copy()))  # type: ignore[no-untyped-call]
