"""The pages that users read, and what is in them."""

import csv
import re
from pathlib import Path

from lawn_sb3.experiment.registry import REPOSITORY

PATHS = [
    *(REPOSITORY / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *sorted((REPOSITORY / "docs").glob("*.md")),
    *sorted((REPOSITORY / "docs" / "trainers").glob("*.md")),
]
PAGES = {path.relative_to(REPOSITORY).as_posix(): path.read_text(encoding="utf-8") for path in PATHS}
"""Texts by path in the repository."""


def blocks(page: str, language: str) -> list[str]:
    """The code blocks of a page in one language; those without one have the empty language."""
    found = re.findall(r"^```([^\n]*)\n(.*?)^```$", PAGES[page], flags=re.DOTALL | re.MULTILINE)
    return [code for info, code in found if info == language]


def prose(page: str) -> str:
    """A page without its code blocks, on one line."""
    text = re.sub(r"^```.*?^```$", "", PAGES[page], flags=re.DOTALL | re.MULTILINE)
    return " ".join(text.split())


def table_rows(text: str) -> list[list[str]]:
    """The cells of all Markdown tables in a text, without headings and rules."""
    lines = [line.strip() for line in text.splitlines()]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]
    return [row for row in rows if not set("".join(row)) <= set(":-")]


def reference(name: str) -> Path:
    """A file of the reports kept with the code, such as ``paper/table2.md``."""
    recipe, file = name.split("/")
    return REPOSITORY / "runs" / "reference" / recipe / "report" / file


def kept(name: str, quantity: str, **only: str) -> dict[str, float]:
    """A column of a kept report's table, by its first column or by method; of rows with certain values alone."""
    with reference(f"{name}.csv").open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if all(row[key] == value for key, value in only.items())]
    return {row.get("key") or next(iter(row.values())): float(row[quantity]) for row in rows if row[quantity]}


def says(page: str, *sentences: str) -> None:
    """Check that a page has all of the sentences, emphasis aside."""
    text = prose(page).replace("**", "")
    assert [sentence for sentence in sentences if sentence not in text] == []
