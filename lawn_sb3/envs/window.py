"""A window of matplotlib's in which a game is watched, or the terminal where there is none."""

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.envs.rendering import DPI, SIZE_INCHES
from lawn_sb3.errors import Notice


class Window:
    """Shows one picture after the other for people; opened by the first.

    Where matplotlib has no window to show, the texts are printed instead, after one line that says what is missing.

    :param frames_per_second: how many pictures are shown in a second; each is waited for
    """

    def __init__(self, frames_per_second: float) -> None:
        self.frames_per_second = frames_per_second
        self._figure: Any = None
        self._picture: Any = None
        self._is_there = True

    def show(self, draw: Callable[[], NDArray[np.uint8]], write: Callable[[], str]) -> None:
        """Show the next picture.

        :param draw: makes the picture [height, width, 3]
        :param write: makes the same as text, for where there is no window
        """
        if self._is_there and self._figure is None:
            self._open()
        if not self._is_there:
            print(write(), end="\n\n", flush=True)
            return
        picture = draw()
        if self._picture is None:
            axes = self._figure.add_axes((0.0, 0.0, 1.0, 1.0))
            axes.set_axis_off()
            self._picture = axes.imshow(picture)
            self._figure.show()
        self._picture.set_data(picture)
        canvas = self._figure.canvas
        canvas.draw_idle()
        canvas.flush_events()
        canvas.start_event_loop(1.0 / self.frames_per_second)

    def _open(self) -> None:
        from matplotlib import pyplot as plt  # here: it looks for a display
        from matplotlib.backends.registry import BackendFilter, backend_registry

        try:
            named = plt.get_backend()
            missing = named.lower() in backend_registry.list_builtin(BackendFilter.NON_INTERACTIVE)  # type: ignore[no-untyped-call]
            if not missing:
                self._figure = plt.figure(figsize=SIZE_INCHES, dpi=DPI)
                self._figure.canvas.manager.set_window_title("lawn-sb3")
        except ImportError as error:  # a window was asked for, and there is no display or no toolkit
            named, missing = str(error), True
        if missing:
            self._is_there = False
            warnings.warn(
                f"no window for render_mode 'human', so the game is printed as text: matplotlib has {named}; "
                "with a display, MPLBACKEND=TkAgg or QtAgg opens one",
                Notice,
                stacklevel=5,  # whoever called reset()
            )

    def close(self) -> None:
        """Close the window, if it is open; the next picture opens another."""
        if self._figure is not None:
            from matplotlib import pyplot as plt

            plt.close(self._figure)
            self._figure = self._picture = None
