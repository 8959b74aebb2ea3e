"""A report as a folder: tables in three formats, figures in two, pages for a forge and a browser, one JSON file."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.style import save
from lawn_sb3.report.table import Table
from lawn_sb3.report.web.replay_page import replay_page
from lawn_sb3.report.web.report_page import REPLAY_FILE, report_page
from lawn_sb3.results.tracks import Replay
from lawn_sb3.whole_files import write_text

JSON_FILE, PAGE_FILE, WEB_FILE = "report.json", "README.md", "index.html"
ENDINGS = (".md", ".csv", ".tex", ".png", ".pdf")
"""Of the files of tables and figures."""


@dataclass
class Report:
    """All that a report shows, ready to be written.

    :param recipe: the recipe it is about
    :param command: the command that makes it again
    :param sections: what it shows, in the order of the page
    :param main: file name of the table that says most
    :param main_title: what that table shows
    :param problems: one line for each file of a run, or part of the report, that there is not
    :param summary: sentences for the top of the page
    :param replay: some test episodes as every method flew them, if the runs hold their paths
    :param cost: a sentence on the time that the runs took, if they say
    """

    recipe: Recipe
    command: str
    sections: Sequence[Section]
    main: str
    main_title: str
    problems: list[str] = field(default_factory=list)
    summary: list[str] = field(default_factory=list)
    replay: Replay | None = None
    cost: str = ""

    @property
    def title(self) -> str:
        """Heading of the page."""
        return self.recipe.title or self.recipe.name

    @property
    def tables(self) -> dict[str, Table]:
        """Tables by file name."""
        return {name: part for name, part in self._parts() if isinstance(part, Table)}

    @property
    def figures(self) -> dict[str, Picture]:
        """Figures with their captions, by file name."""
        return {name: part for name, part in self._parts() if isinstance(part, Picture)}

    def _parts(self) -> list[tuple[str, Table | Picture]]:
        return [part for section in self.sections for part in section.shown.items()]


def write_report(report: Report, folder: Path) -> None:
    """Write tables, figures, pages and JSON to a folder; what an earlier report had there and this one lacks goes."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, table in report.tables.items():
        table.save(folder, name)
    for name, picture in report.figures.items():
        save(picture.figure, folder, name)
    gone = _names_of_earlier(folder) - {*report.tables, *report.figures}
    for path in folder.iterdir():
        if path.stem in gone and path.suffix in ENDINGS:
            path.unlink()
    write_text(folder / JSON_FILE, json.dumps(for_machines(report), indent=1, ensure_ascii=False) + "\n")
    write_text(folder / PAGE_FILE, page(report))
    write_text(folder / WEB_FILE, report_page(report))
    if report.replay is None:
        (folder / REPLAY_FILE).unlink(missing_ok=True)
    else:
        write_text(folder / REPLAY_FILE, replay_page(report.replay, report.title, report.command))


def _names_of_earlier(folder: Path) -> set[str]:
    """The tables and figures of the report that the folder holds already."""
    try:
        earlier = json.loads((folder / JSON_FILE).read_text(encoding="utf-8"))
        return {*earlier["tables"], *earlier["captions"]}
    except (OSError, ValueError, KeyError, TypeError):  # none, or damaged
        return set()


def for_machines(report: Report) -> dict[str, Any]:
    """The whole report as one object that JSON can hold."""
    recipe = report.recipe
    return {
        "title": report.title,
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
        "captions": {name: picture.caption for name, picture in report.figures.items()},
    }


def page(report: Report) -> str:
    """The report as Markdown."""
    recipe = report.recipe
    seeds = f"seed{'s' if len(recipe.seeds) > 1 else ''} {', '.join(map(str, recipe.seeds))}"
    blocks = [
        f"# {report.title}",
        f"Scenario `{recipe.game().title}`, {seeds}, {recipe.evaluation.episodes} test episodes a seed. All "
        f"tables and figures here are made by `{report.command}`; each table is also there as CSV and LaTeX, each "
        "figure as PDF, and everything in `report.json`.",
        *report.summary,
    ]
    if report.problems:
        blocks += ["**Not in this report:**", "\n".join(f"- {problem}" for problem in report.problems)]
    for section in report.sections:
        if section.shown:
            blocks.append(f"## {section.heading}")
        for name, part in section.shown.items():
            picture = f"![{name.replace('_', ' ')}]({name}.png)"
            blocks.append(part.as_markdown() if isinstance(part, Table) else picture)
            blocks.append(f"*{part.caption} Made by `{report.command}`.*")
    return "\n\n".join(blocks) + "\n"
