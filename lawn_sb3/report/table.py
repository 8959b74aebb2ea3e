"""One table in every form it is needed in: numbers for machines, Markdown for a forge, LaTeX for a paper."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from lawn_sb3.results.markdown import markdown_table
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
    "‡": r"$^\ddagger$",
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
        """The table for a forge, without its caption."""
        shown = self.shown.map(lambda text: text.replace("|", "\\|"))
        return markdown_table(shown)

    def as_csv(self) -> str:
        """The numbers for machines, with six digits."""
        return self.numbers.to_csv(index=False, float_format="%.6g", lineterminator="\n")

    def as_latex(self) -> str:
        """The table for a paper, with booktabs' rules and its caption; with many rows one that runs over pages."""
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
        """Write the table in all its forms, under a file name without ending."""
        write_text(folder / f"{name}.md", self.as_markdown() + "\n")
        write_text(folder / f"{name}.csv", self.as_csv())
        write_text(folder / f"{name}.tex", self.as_latex())


class Row:
    """A row of a table in the making.

    :param numbers: its columns for machines
    :param cells: what a reader sees, by heading
    """

    def __init__(self, numbers: Mapping[str, object], cells: Mapping[str, str]) -> None:
        self.numbers, self.cells = dict(numbers), dict(cells)

    def add(self, name: str, heading: str, found: Interval, decimals: int, after: str = "") -> None:
        """Add an interval: ``NAME, NAME_low, NAME_high`` for machines, its text and what is to stand after it."""
        self.numbers |= interval_columns({name: found})
        self.cells[heading] = found.text(decimals) + after


def row_of(results: Results, method: str, **numbers: object) -> Row:
    """Begin the row of a method, by its key in the recipe; ``numbers`` come behind its name."""
    label = results.recipe.methods[method].label
    return Row({"method": label, "key": method, **numbers}, {"Method": label})


def table_of(rows: Iterable[Row], caption: str) -> Table:
    """Make a table of its rows."""
    rows = list(rows)
    return Table(pd.DataFrame([row.numbers for row in rows]), pd.DataFrame([row.cells for row in rows]), caption)


def sample_text(seeds: int, episodes: int | str) -> str:
    """The sample behind a figure, such as ``5 × 200``: seeds by test episodes, where these differ all of them."""
    return f"{seeds} × {episodes}"


def sample_of(results: Results, method: str) -> str:
    """The sample behind all of a method's evaluations; the method by its key in the recipe."""
    return sample_text(len(results.seeds(method)), results.recipe.evaluation.episodes)


def latex_text(text: str) -> str:
    """A text such that LaTeX prints it as it is; formulas between ``$`` and ``$`` are not known here."""
    return _SIGNS.sub(lambda sign: IN_LATEX[sign.group()], text)


def interval_columns(figures: Mapping[str, Interval]) -> dict[str, float]:
    """Intervals as columns for machines: ``NAME, NAME_low, NAME_high`` of each."""
    columns: dict[str, float] = {}
    for name, found in figures.items():
        columns |= {name: found.value, f"{name}_low": found.low, f"{name}_high": found.high}
    return columns


def interval_of(row: pd.Series, name: str) -> Interval:
    """The interval that lies in such columns of a row."""
    return Interval(*(float(row[column]) for column in (name, f"{name}_low", f"{name}_high")))
