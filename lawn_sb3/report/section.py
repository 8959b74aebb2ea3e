"""A section of a report: its heading, and the tables and figures under it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from matplotlib.figure import Figure

from lawn_sb3.report.table import Table


class Picture(NamedTuple):
    """A figure and what stands below it."""

    figure: Figure
    caption: str


@dataclass(frozen=True)
class Section:
    """What one file of :mod:`lawn_sb3.report.sections` gives.

    :param heading: what stands above it
    :param parts: tables and figures by file name, in the order of the page; what is None, or a table without rows, is
        left out
    :param summary: sentences for the top of the page
    :param problems: one line for each thing that could not be shown, for the top of the page
    """

    heading: str
    parts: Mapping[str, Table | Picture | None]
    summary: tuple[str, ...] = ()
    problems: tuple[str, ...] = ()

    @property
    def shown(self) -> dict[str, Table | Picture]:
        """The parts that hold something."""
        return {
            name: part
            for name, part in self.parts.items()
            if part is not None and not (isinstance(part, Table) and part.shown.empty)
        }
