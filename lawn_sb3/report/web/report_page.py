"""A report as a page: its tables to sort, its figures to enlarge, its claims to filter; the texts of the Markdown."""

import re
from collections.abc import Iterable, Iterator, Mapping
from html import escape
from typing import TYPE_CHECKING

import pandas as pd

from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.table import Table
from lawn_sb3.report.web.page import as_page, own

if TYPE_CHECKING:
    from lawn_sb3.report.document import Report

MOST_COLUMNS = 8
"""Of a table; a wider one goes on in another below it, which names its rows again."""
CLAIMS, HEADLINES, BY_VERDICT = "claims", "claims_headlines", "claims_summary"
"""Tables that are one list here: its filters and marks say what the second and the third do."""
LONGEST_FIGURE = 30
"""Signs of a cell; longer ones are sentences."""
REPLAY_FILE = "replay.html"
_CODE = re.compile(r"`([^`]+)`")


def report_page(report: "Report") -> str:
    """Write a report as HTML.

    :param report: the report
    :return: the page; figures and the replay lie beside it
    """
    sections = [section for section in report.sections if section.shown]
    body = "\n".join([_top(report, sections), "<main>", *map(_section, sections), _end(report), "</main>", _ZOOM])
    return as_page(report.title, body, [own("base.css"), own("report.css")], [own("report.js")], None)


_ZOOM = (
    '<dialog id="zoom" aria-label="Figure"><form method="dialog"><button autofocus>Close</button></form>'
    '<img alt=""></dialog>'
)


def _top(report: "Report", sections: Iterable[Section]) -> str:
    names = [f'<li><a href="#{_anchor(section)}">{escape(section.heading)}</a></li>' for section in sections]
    names.append('<li><a href="#run">What was run</a></li>')
    if report.replay is not None:
        names.insert(0, f'<li><a href="{REPLAY_FILE}"><strong>Watch episodes, slot by slot</strong></a></li>')
    missing = "".join(f"<li>{_text(problem)}</li>" for problem in report.problems)
    parts = [
        f"<header><h1>{escape(report.title)}</h1>",
        *(f"<p>{_text(sentence)}</p>" for sentence in report.summary),
        f"<details><summary>Not in this report: {len(report.problems)}</summary><ul>{missing}</ul></details>"
        if missing
        else "",
        f'<nav aria-label="Parts of the report"><ul>{"".join(names)}</ul></nav>',
        "</header>",
    ]
    return "\n".join(part for part in parts if part)


def _section(section: Section) -> str:
    parts = dict(section.shown)
    blocks = [f'<section id="{_anchor(section)}"><h2>{escape(section.heading)}</h2>']
    claims = parts.get(CLAIMS)
    if isinstance(claims, Table):
        headlines, meanings = parts.pop(HEADLINES, None), parts.pop(BY_VERDICT, None)
        blocks.append(_claims(claims, headlines, meanings))
        del parts[CLAIMS]
    blocks += [_table(name, part) if isinstance(part, Table) else _figure(name, part) for name, part in parts.items()]
    return "\n".join([*blocks, "</section>"])


def _figure(name: str, picture: Picture) -> str:
    width, height = picture.figure.get_size_inches() * 100.0
    what = escape(name.replace("_", " "))
    return (
        f'<figure><button class="zoom" aria-label="Enlarge {what}"><img src="{name}.png" alt="{what}" loading="lazy" '
        f'width="{width:.0f}" height="{height:.0f}"></button>'
        f'<figcaption>{_text(picture.caption)} <a href="{name}.pdf">PDF</a></figcaption></figure>'
    )


def _table(name: str, table: Table) -> str:
    parts = "".join(_columns(part) for part in narrowed(table.shown))
    return (
        f'<figure class="table">{parts}<figcaption>{_text(table.caption)} <a href="{name}.csv">CSV</a>, '
        f'<a href="{name}.tex">LaTeX</a></figcaption></figure>'
    )


def narrowed(shown: pd.DataFrame) -> Iterator[pd.DataFrame]:
    """A table as tables of at most ``MOST_COLUMNS`` columns, each of which begins with what names the rows."""
    columns = list(shown.columns)
    if len(columns) <= MOST_COLUMNS:
        yield shown
        return
    names = next((k for k in range(1, MOST_COLUMNS // 2) if not shown.duplicated(columns[:k]).any()), 1)
    wide = MOST_COLUMNS - names
    parts = -(-(len(columns) - names) // wide)
    each = -(-(len(columns) - names) // parts)  # as even as can be
    for at in range(names, len(columns), each):
        yield shown[columns[:names] + columns[at : at + each]]


def _columns(shown: pd.DataFrame) -> str:
    heads = "".join(f'<th scope="col"><button class="sort">{escape(str(name))}</button></th>' for name in shown)
    rows = [
        f'<tr><th scope="row">{_text(str(first))}</th>{"".join(map(_cell, others))}</tr>'
        for first, *others in shown.itertuples(index=False, name=None)
    ]
    return (
        '<div class="scrolls" tabindex="0" role="region" aria-label="Table"><table class="sorts"><thead><tr>'
        f"{heads}</tr></thead><tbody>{''.join(rows)}</tbody></table></div>"
    )


def _cell(shown: object) -> str:
    """One cell: figures, with their intervals, stay in one line."""
    text = str(shown)
    return f"<td{' class=figures' if len(text) <= LONGEST_FIGURE else ''}>{_text(text)}</td>"


def _claims(claims: Table, headlines: Table | Picture | None, by_verdict: Table | Picture | None) -> str:
    """A line for each claim, its verdict first; how it is measured, what came out and why unfold."""
    carrying = set(headlines.numbers["id"]) if isinstance(headlines, Table) else set()
    meanings: dict[str, str] = {}
    if isinstance(by_verdict, Table):
        meanings = dict(zip(by_verdict.shown["Verdict"], by_verdict.shown["Which means"], strict=True))
    counts = claims.numbers["verdict"].value_counts()
    order = [verdict for verdict in meanings or counts.index if verdict in counts]
    buttons = ['<button data-verdict="" aria-pressed="true">all ' + f"{len(claims.numbers)}</button>"]
    buttons += [
        f'<button data-verdict="{escape(verdict)}" aria-pressed="false" title="{escape(meanings.get(verdict, ""))}">'
        f"{escape(verdict)} {counts[verdict]}</button>"
        for verdict in order
    ]
    if carrying:
        buttons.append(
            f'<button data-carrying aria-pressed="false">those that carry the paper {len(carrying)}</button>'
        )
    texts = [{str(name): str(text) for name, text in row.items()} for row in claims.numbers.to_dict("records")]
    lines = [_claim(claim, claim["id"] in carrying) for claim in texts]
    return (
        f'<div class="filters" role="group" aria-label="Claims by verdict">{"".join(buttons)}</div>'
        f'<p class="faint" id="means" aria-live="polite"></p><div class="claims">{"".join(lines)}</div>'
        f'<details><summary class="faint">How claims are judged</summary><p>{_text(claims.caption)}</p></details>'
    )


def _claim(claim: Mapping[str, str], carries: bool) -> str:
    rest = {
        "The paper says": f"{claim['claim']} ({claim['section']})",
        "Measured": claim["measure"],
        "Came out": claim["figure"],
        "Why": claim["why"],
        "Name": claim["id"],
    }
    told = "".join(f"<dt>{what}</dt><dd>{_text(text)}</dd>" for what, text in rest.items() if text)
    return (
        f'<details data-verdict="{escape(claim["verdict"])}"{" data-carrying" if carries else ""}><summary>'
        f'<span class="verdict">{escape(claim["verdict"])}</span> <span class="line">{_text(claim["claim"])}</span>'
        f"</summary><dl>{told}</dl></details>"
    )


def _end(report: "Report") -> str:
    """What was run, and how to run it again."""
    recipe = report.recipe
    rows = [
        {
            "Method": method.label,
            "Key": key,
            "Flown by": method.player or f"{method.algo}, {method.policy}",
            "Env steps": f"{method.env_steps:,}" if method.algo else "–",
        }
        for key, method in recipe.methods.items()
    ]
    seeds = ", ".join(map(str, recipe.seeds))
    cost = f"<p>{_text(report.cost)}</p>" if report.cost else ""
    return (
        '<section id="run"><h2>What was run</h2>'
        f"<p>Scenario <code>{escape(recipe.game().title)}</code>, seeds {seeds}, "
        f"{recipe.evaluation.episodes} test episodes a seed. Made by <code>{escape(report.command)}</code>; each table "
        'is also there as CSV and LaTeX, each figure as PDF, everything in <a href="report.json">report.json</a>, and '
        f'the same as Markdown in <a href="README.md">README.md</a>.</p>{cost}{_columns(pd.DataFrame(rows))}</section>'
    )


def _anchor(section: Section) -> str:
    return re.sub(r"[^a-z0-9]+", "-", section.heading.lower()).strip("-")


def _text(text: str) -> str:
    """A text of the report as HTML: what stands between backticks is code."""
    return _CODE.sub(r"<code>\1</code>", escape(text, quote=False))
