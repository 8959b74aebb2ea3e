"""A report as a folder: tables in three formats, figures in two, a page for a forge and one JSON file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.report.style import save
from lawn_sb3.report.table import Table
from lawn_sb3.whole_files import write_text


@dataclass
class Report:
    """All that a report shows, ready to be written.

    :param recipe: the recipe it is about
    :param command: the command that makes it again
    :param sections: headings of the page, with the names of the tables and figures under each
    :param problems: one line for each file of a run that could not be used
    :param summary: sentences for the top of the page
    :param tables: tables by file name
    :param figures: figures with their captions, by file name
    """

    recipe: Recipe
    command: str
    sections: Mapping[str, tuple[str, ...]]
    problems: list[str]
    summary: list[str] = field(default_factory=list)
    tables: dict[str, Table] = field(default_factory=dict)
    figures: dict[str, tuple[Figure, str]] = field(default_factory=dict)


def write_report(report: Report, folder: Path) -> None:
    """Write tables, figures, page and JSON; tables and figures of an earlier report that this one lacks are removed.

    :param report: the report
    :param folder: where to
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, table in report.tables.items():
        table.save(folder, name)
    for name, (figure, _) in report.figures.items():
        save(figure, folder, name)
    write_text(folder / "report.json", json.dumps(for_machines(report), indent=1, ensure_ascii=False) + "\n")
    write_text(folder / "README.md", page(report))
    made = {*report.tables, *report.figures}
    for name in {name for names in report.sections.values() for name in names} - made:
        for ending in ("md", "csv", "tex", "png", "pdf"):
            (folder / f"{name}.{ending}").unlink(missing_ok=True)


def for_machines(report: Report) -> dict[str, Any]:
    """The whole report as one object.

    :param report: the report
    :return: what JSON can hold
    """
    recipe = report.recipe
    return {
        "title": recipe.title or recipe.name,
        "command": report.command,
        "scenario": recipe.game().model_dump(mode="json"),
        "seeds": list(recipe.seeds),
        "evaluation": recipe.evaluation.model_dump(mode="json"),
        "problems": report.problems,
        "summary": report.summary,
        "tables": {
            name: json.loads(table.numbers.to_json(orient="records", double_precision=6))
            for name, table in report.tables.items()
        },
        "captions": {name: caption for name, (_, caption) in report.figures.items()},
    }


def page(report: Report) -> str:
    """The report as Markdown.

    :param report: the report
    :return: the page
    """
    recipe = report.recipe
    seeds = ", ".join(map(str, recipe.seeds))
    parts = [
        f"# {recipe.title or recipe.name}",
        f"Scenario `{recipe.game().title}`, seeds {seeds}, {recipe.evaluation.episodes} test episodes a seed. "
        f"All tables and figures here are made by `{report.command}`; each table is also there as CSV and LaTeX, each "
        "figure as PDF, and everything in `report.json`.",
        *report.summary,
    ]
    if report.problems:
        parts += ["**Not in this report:**", "\n".join(f"- {problem}" for problem in report.problems)]
    for heading, names in report.sections.items():
        shown = [text for name in names for text in _shown(report, name)]
        parts += [f"## {heading}", *shown] if shown else []
    return "\n\n".join(parts) + "\n"


def _shown(report: Report, name: str) -> list[str]:
    """A table or figure with its caption; nothing if the runs do not give it."""
    made_by = f"Made by `{report.command}`."
    if name in report.tables:
        table = report.tables[name]
        return [table.as_markdown(), f"*{table.caption} {made_by}*"]
    if name in report.figures:
        caption = report.figures[name][1]
        return [f"![{name.replace('_', ' ')}]({name}.png)", f"*{caption} {made_by}*"]
    return []
