"""One table in every form it is needed in: numbers for machines, Markdown for a forge, LaTeX for a paper."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import Interval
from lawn_sb3.whole_files import write_text

IN_LATEX = {
    "\\": r"\textbackslash{}",
    **{sign: f"\\{sign}" for sign in "&%$#_{}"},
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "J̄": r"$\bar{J}$",
    "R̂": r"$\hat{R}$",
    "T̄": r"$\bar{T}$",
    "T_min": r"$T^{\min}$",
    "±": r"$\pm$",
    "×": r"$\times$",
    "≠": r"$\neq$",
    "≤": r"$\leq$",
    "≥": r"$\geq$",
    "<": r"$<$",
    ">": r"$>$",
    "−": r"$-$",
    "–": "--",
    "Δ": r"$\Delta$",
    "†": r"$^\dagger$",
}
"""Signs that LaTeX reads otherwise, or does not know."""
LONGEST = 50
"""Characters of a cell beyond which its column wraps in LaTeX."""
MOST_ROWS = 30
"""Rows that still fit on one page."""
_SIGNS = re.compile("|".join(re.escape(sign) for sign in sorted(IN_LATEX, key=len, reverse=True)))


class Table(NamedTuple):
    """A table and what it shows."""

    numbers: pd.DataFrame
    """Everything it holds, unrounded, for machines."""
    shown: pd.DataFrame
    """What a reader sees: every cell and heading a text."""
    caption: str
    """What it shows, over how many seeds and episodes."""
    latex: pd.DataFrame | None = None
    """Cells and headings in LaTeX, where they hold formulas; otherwise LaTeX is made from those shown."""

    def as_markdown(self) -> str:
        """Write the table for a forge.

        :return: a Markdown table without its caption
        """
        shown = self.shown.map(lambda text: text.replace("|", "\\|"))
        return str(shown.to_markdown(index=False, disable_numparse=True))

    def as_csv(self) -> str:
        """Write the numbers for machines.

        :return: CSV text with six digits
        """
        return self.numbers.to_csv(index=False, float_format="%.6g", lineterminator="\n")

    def as_latex(self) -> str:
        """Write the table for a paper, with booktabs' rules.

        :return: a LaTeX table with its caption; one of many rows is a ``longtable``, which runs over pages
        """
        cells = self.shown.map(latex_text).rename(columns=latex_text) if self.latex is None else self.latex
        wide = [bool(cells[column].str.len().max() > LONGEST) for column in cells]
        share = min(0.3, 0.8 / max(sum(wide), 1))
        widths = [f"p{{{share:.2g}\\linewidth}}" if wraps else "l" for wraps in wide]
        if len(cells) > MOST_ROWS:
            return cells.to_latex(
                index=False,
                escape=False,
                longtable=True,
                column_format="".join(widths),
                caption=latex_text(self.caption),
            )
        body = cells.to_latex(index=False, escape=False, column_format="".join(widths))
        return f"\\begin{{table}}[t]\n\\centering\n\\caption{{{latex_text(self.caption)}}}\n{body}\\end{{table}}\n"

    def save(self, folder: Path, name: str) -> None:
        """Write the table in all its forms.

        :param folder: where to
        :param name: file name without ending
        """
        write_text(folder / f"{name}.md", self.as_markdown() + "\n")
        write_text(folder / f"{name}.csv", self.as_csv())
        write_text(folder / f"{name}.tex", self.as_latex())


def table_of(rows: Iterable[tuple[Mapping[str, object], Mapping[str, str]]], caption: str) -> Table:
    """Make a table row by row.

    :param rows: for each the numbers of its columns, and what a reader sees
    :param caption: what it shows
    :return: the table
    """
    rows = list(rows)
    return Table(pd.DataFrame([numbers for numbers, _ in rows]), pd.DataFrame([shown for _, shown in rows]), caption)


def sample_text(seeds: int, episodes: int) -> str:
    """The sample behind a figure, such as ``5 × 200``: seeds by test episodes."""
    return f"{seeds} × {episodes}"


def sample_of(results: Results, method: str) -> str:
    """The sample behind all of a method's evaluations; the method by its key in the recipe."""
    return sample_text(len(results.seeds(method)), results.recipe.evaluation.episodes)


def latex_text(text: str) -> str:
    """Write a text so that LaTeX prints it as it is.

    :param text: any text; formulas between ``$`` and ``$`` are not known here
    :return: LaTeX
    """
    return _SIGNS.sub(lambda sign: IN_LATEX[sign.group()], text)


def interval_columns(figures: Mapping[str, Interval]) -> dict[str, float]:
    """Spread intervals over columns of a row.

    :param figures: the intervals by name
    :return: ``NAME, NAME_low, NAME_high`` of each
    """
    columns: dict[str, float] = {}
    for name, interval in figures.items():
        columns |= {name: interval.value, f"{name}_low": interval.low, f"{name}_high": interval.high}
    return columns


def interval_texts(numbers: pd.DataFrame, name: str, decimals: int) -> list[str]:
    """Write the intervals of a column for reading.

    :param numbers: a table with the columns ``NAME, NAME_low, NAME_high``
    :param name: the name
    :param decimals: digits after the point
    :return: such as ``3.43 [3.41, 3.45]``
    """
    return [interval_of(row, name).text(decimals) for _, row in numbers.iterrows()]


def interval_of(row: pd.Series, name: str) -> Interval:
    """The interval that :func:`interval_columns` spread over a row."""
    return Interval(*(float(row[column]) for column in (name, f"{name}_low", f"{name}_high")))
