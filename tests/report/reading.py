"""Tables and figures read back."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.lines import Line2D

from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.table import Table


def rows_by(frame: pd.DataFrame, *columns: str) -> dict[Any, dict[Any, Any]]:
    """The rows of a table by the values of some of its columns, which no two rows share."""
    rows: dict[Any, dict[Any, Any]] = frame.set_index(list(columns)).to_dict("index")
    return {key[0] if len(columns) == 1 and isinstance(key, tuple) else key: row for key, row in rows.items()}


def numbers_of(table: Table) -> dict[Any, dict[Any, Any]]:
    return rows_by(table.numbers, "key")


def shown_of(table: Table) -> dict[Any, dict[Any, Any]]:
    return rows_by(table.shown, "Method")


def interval_in(row: Mapping[Any, Any], name: str) -> list[float]:
    """The interval that lies in three columns of a row: value, low and high."""
    return [row[name], row[f"{name}_low"], row[f"{name}_high"]]


def points_of(line: Line2D) -> list[list[float]]:
    points: list[list[float]] = np.asarray(line.get_xydata()).tolist()
    return points


def table_in(section: Section | None, name: str) -> Table:
    assert section is not None
    part = section.shown[name]
    assert isinstance(part, Table)
    return part


def picture_in(section: Section | None, name: str) -> Picture:
    assert section is not None
    part = section.shown[name]
    assert isinstance(part, Picture)
    return part
