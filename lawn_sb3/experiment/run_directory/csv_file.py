"""One CSV file: its columns, writing it, and reading it back whole or saying in one line what is wrong and where."""

import io
import reprlib
import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd
import pandera.pandas as pa

from lawn_sb3.errors import UserError, first_line
from lawn_sb3.whole_files import write_text

MOST = sys.float_info.max
Columns = dict[str, pa.Column]
"""Columns by name, with description, unit (as title) and bounds."""


def number(
    about: str, unit: str = "", low: float = -MOST, high: float = MOST, *, whole: bool = False, gaps: bool = False
) -> pa.Column:
    """A column of finite numbers.

    :param about: what it holds
    :param unit: its unit
    :param low: the least number allowed
    :param high: the greatest
    :param whole: whether they are whole numbers
    :param gaps: whether a value may be missing
    :return: the column; its check says what is allowed
    """

    def parse(texts: pd.Series) -> pd.Series:
        numbers = pd.to_numeric(texts, errors="coerce").to_numpy(np.float64, copy=True)
        numbers[~np.isfinite(numbers) | (whole & (numbers != np.round(numbers)))] = np.inf  # out of all bounds
        numbers[gaps & (texts.to_numpy() == "")] = np.nan
        return pd.Series(numbers, texts.index)

    allowed = "must be a whole number" if whole else "must be a finite number"
    if low > -MOST:
        allowed += f" from {low:g} to {high:g}" if high < MOST else f" of at least {low:g}"
    return pa.Column(
        "int64" if whole else "float64",
        pa.Check.in_range(low, high, error=allowed),
        pa.Parser(parse),
        nullable=gaps,
        coerce=True,
        title=unit,
        description=about,
    )


def whole(about: str, unit: str = "", low: float = -MOST, high: float = MOST) -> pa.Column:
    """A column of whole numbers."""
    return number(about, unit, low, high, whole=True)


def flag(about: str) -> pa.Column:
    """A column of truth values."""

    def parse(texts: pd.Series) -> pd.Series:
        flags = texts.map({"True": True, "False": False})
        return flags if flags.hasnans else flags.astype(bool)  # where there are none, pandas cannot tell their type

    check = pa.Check.isin([True, False], error="must be True or False")
    return pa.Column("bool", check, pa.Parser(parse), description=about)


def write_rows(path: Path, rows: pd.DataFrame) -> None:
    """Write a table in one go."""
    write_text(path, rows_as_text(rows))


def rows_as_text(rows: pd.DataFrame) -> str:
    """A table as CSV with nine digits."""
    return rows.to_csv(index=False, float_format="%.9g", lineterminator="\n")


def read_table(path: Path, columns: Columns, num_rows: int, key: list[str]) -> pd.DataFrame:
    """Read a table whose columns and rows are known.

    :param path: the file
    :param columns: its columns; it has no others
    :param num_rows: how many rows it has
    :param key: columns that no two rows have alike
    :return: the table
    :raises UserError: if the file is not just that
    """
    texts, name = read_texts(path, columns), path.name
    unknown = [column for column in texts if column not in columns]
    if unknown:
        raise UserError(f"{name} holds the unknown columns {reprlib.repr(unknown)}; known: {', '.join(columns)}")
    if len(texts) < num_rows:
        raise UserError(f"{name} is cut off: {len(texts)} of {num_rows} rows")
    if len(texts) > num_rows:
        raise UserError(f"{name} has {len(texts)} rows: must be {num_rows}")
    rows = checked(texts[[*columns]], columns, name)
    twice = rows.duplicated(key).to_numpy()
    if twice.any():
        at = int(twice.argmax())
        values = ", ".join(f"{column} {rows[column].iloc[at]}" for column in key)
        raise UserError(f"{name} line {at + 2} repeats {values}: must be there once")
    return rows


def read_texts(path: Path, needed: Iterable[str]) -> pd.DataFrame:
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
        raise UserError(f"{path.name} cannot be read: {first_line(error)}") from None
    missing = [column for column in needed if column not in rows]
    if missing:
        raise UserError(f"{path.name} lacks the columns {', '.join(missing)}")
    if not isinstance(rows.index, pd.RangeIndex):  # pandas takes what goes beyond the heading for row labels
        raise UserError(f"{path.name} has more values in a line than its {len(rows.columns)} columns")
    if not text.endswith("\n"):
        raise UserError(f"{path.name} is cut off: line {len(rows) + 1} has no end")
    return rows.fillna("")


def checked(texts: pd.DataFrame, columns: Columns, name: str) -> pd.DataFrame:
    """Turn texts into values.

    :param texts: the columns as read
    :param columns: what they may hold
    :param name: the file, for the error
    :return: truth values, integers or floats; NaN for a gap
    :raises UserError: naming the first column with a value that is not allowed, and its first such line
    """
    try:
        return pa.DataFrameSchema(columns).validate(texts, lazy=True)
    except pa.errors.SchemaErrors as errors:
        wrong = errors.failure_cases.dropna(subset="index").groupby("column")["index"].min()
    column = next(column for column in columns if column in wrong)
    at, allowed = int(wrong[column]), columns[column].checks[0].error
    raise UserError(f"{name} line {at + 2}: {column} = {reprlib.repr(texts[column].iloc[at])}: {allowed}")
