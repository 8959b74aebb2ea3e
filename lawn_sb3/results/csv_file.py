"""Reading a CSV file that must be whole, or saying in one line what is wrong with it, where, and what is expected."""

from __future__ import annotations

import io
import math
import reprlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from lawn_sb3.errors import UserError


class Allowed(NamedTuple):
    """The values that a column may hold: finite numbers within bounds, or True and False."""

    low: float = -math.inf
    high: float = math.inf
    whole: bool = False
    flag: bool = False
    gaps: bool = False
    """Whether a value may be missing."""

    def __str__(self) -> str:
        """What is allowed, for an error."""
        if self.flag:
            return "must be True or False"
        kind = "a whole number" if self.whole else "a finite number"
        if math.isinf(self.high):
            return f"must be {kind}" if math.isinf(self.low) else f"must be {kind} of at least {self.low:g}"
        return f"must be {kind} from {self.low:g} to {self.high:g}"


def read_text_columns(path: Path, needed: Iterable[str]) -> pd.DataFrame:
    """Read a file without a look at its values.

    :param path: the file
    :param needed: columns that it must have
    :return: its columns as texts, a gap as the empty text
    :raises UserError: if the file is no CSV, lacks a column, or ends inside a line
    """
    try:
        text = path.read_bytes().decode()
    except OSError as error:
        raise UserError(f"{path.name} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise UserError(f"{path.name} cannot be read: it is no text") from None
    if not text.strip():
        raise UserError(f"{path.name} cannot be read: it is empty")
    try:
        rows = pd.read_csv(io.StringIO(text), dtype=str, keep_default_na=False, skip_blank_lines=False)
    except ValueError as error:  # pandas' parser errors are ValueErrors
        raise UserError(f"{path.name} cannot be read: {str(error).partition(chr(10))[0]}") from None
    missing = [column for column in needed if column not in rows]
    if missing:
        raise UserError(f"{path.name} lacks the columns {', '.join(missing)}")
    if not isinstance(rows.index, pd.RangeIndex):  # pandas takes what goes beyond the heading for row labels
        raise UserError(f"{path.name} has more values in a line than its {len(rows.columns)} columns")
    if not text.endswith("\n"):
        raise UserError(f"{path.name} is cut off: line {len(rows) + 1} has no end")
    return rows.fillna("")


def read_table(path: Path, columns: Mapping[str, Allowed], num_rows: int, key: list[str]) -> pd.DataFrame:
    """Read a table whose columns and rows are known.

    :param path: the file
    :param columns: its columns and what they may hold; it has no others
    :param num_rows: how many rows it has
    :param key: columns that no two rows have alike
    :return: the table, whole numbers as integers
    :raises UserError: if the file is not just that
    """
    texts, name = read_text_columns(path, columns), path.name
    unknown = [column for column in texts if column not in columns]
    if unknown:
        raise UserError(f"{name} holds the unknown columns {reprlib.repr(unknown)}; known: {', '.join(columns)}")
    if len(texts) < num_rows:
        raise UserError(f"{name} is cut off: {len(texts)} of {num_rows} rows")
    if len(texts) > num_rows:
        raise UserError(f"{name} has {len(texts)} rows: must be {num_rows}")
    rows = pd.DataFrame({column: checked_values(texts[column], allowed, name) for column, allowed in columns.items()})
    twice = rows.duplicated(key).to_numpy()
    if twice.any():
        at = int(twice.argmax())
        values = ", ".join(f"{column} {rows[column].iloc[at]}" for column in key)
        raise UserError(f"{name} line {at + 2} repeats {values}: must be there once")
    return rows


def checked_values(texts: pd.Series, allowed: Allowed, name: str) -> pd.Series:
    """Turn the texts of a column into values.

    :param texts: the column as read
    :param allowed: what it may hold
    :param name: the file, for the error
    :return: truth values, integers or floats; NaN for a gap
    :raises UserError: naming the first line with a value that is not allowed
    """
    if allowed.flag:
        wrong = ~texts.isin(["True", "False"]).to_numpy()
    else:
        numbers = pd.to_numeric(texts, errors="coerce").to_numpy(dtype=np.float64)
        wrong = ~(np.isfinite(numbers) & (numbers >= allowed.low) & (numbers <= allowed.high))
        if allowed.whole:
            wrong |= numbers != np.round(numbers)
        if allowed.gaps:
            wrong &= texts.to_numpy() != ""
    if wrong.any():
        at = int(wrong.argmax())
        raise UserError(f"{name} line {at + 2}: {texts.name} = {reprlib.repr(texts.iloc[at])}: {allowed}")
    if allowed.flag:
        return texts == "True"
    return pd.Series(numbers, texts.index, dtype=np.int64 if allowed.whole else np.float64)
