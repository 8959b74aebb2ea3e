"""What all commands share: options, how figures and tables are printed, and how a command ends."""

import json
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn
from rich.table import Table

from lawn_sb3.cli.ending import interrupted_status
from lawn_sb3.experiment.reproduce import QUIET_SECONDS
from lawn_sb3.scenario import PRESETS

if TYPE_CHECKING:
    import pandas as pd

    from lawn_sb3.experiment.plan_episodes import Advance

messages = Console(stderr=True, emoji=False)

UNITS = {"_mbps": "Mbps", "_slots": "slots", "_percent": "%"}
"""How names of figures end, and the unit that says."""
LONGEST_FIGURE = 40
"""Characters of a cell; a column with longer ones holds sentences."""

PICTURES = (".png", ".pdf", ".svg")
"""Endings of pictures."""
PAPER_RECIPE = Path("runs/paper.yaml")
ABLATION_RECIPE = Path("runs/ablation.yaml")
ScenarioName = Annotated[str, typer.Option(help=f"{', '.join(PRESETS)}, or the path of a YAML file")]
Changes = Annotated[list[str], typer.Option("--set", help="change a constant of the scenario: key=value; repeatable")]
Trusted = Annotated[
    list[str],
    typer.Option("--trust", help="policy of yours that a run may name; importing it runs its file; repeatable"),
]
AsJson = Annotated[bool, typer.Option("--json", help="print one JSON object on standard output and nothing else")]
RecipePath = Annotated[Path, typer.Argument(help="the recipe")]
Jobs = Annotated[
    int | None,
    typer.Option(min=1, help="runs side by side, one core each; default: 2, or all that a cluster has room for"),
]
BackendName = Annotated[str, typer.Option("--backend", help="who does the work: local, this machine; ray, a cluster")]
Address = Annotated[
    str | None, typer.Option(help="of the cluster: HOST:PORT; default: RAY_ADDRESS, or one that runs on this machine")
]


def say(text: str, style: str | None = None) -> None:
    """Tell the user something, beside the results on standard output.

    :param text: one line, shown as it is
    :param style: a style of Rich
    """
    messages.print(text, style=style, markup=False, highlight=False, soft_wrap=True)


def wide_console() -> Console:
    """Standard output, wide enough for a whole table where there is no terminal to fit."""
    return Console(width=None if sys.stdout.isatty() else 190)


def print_table(shown: "pd.DataFrame", title: str) -> None:
    """Print a table of texts.

    :param shown: cells and headings
    :param title: what it shows
    """
    table = Table(title=title)
    for number, heading in enumerate(shown.columns):
        is_text = number == 0 or shown[heading].astype(str).str.len().max() > LONGEST_FIGURE
        table.add_column(str(heading), justify="left" if is_text else "right")
    for row in shown.itertuples(index=False):
        table.add_row(*(escape(str(cell)) for cell in row))
    wide_console().print(table)


def print_figures(
    figures: dict[str, Any], as_json: bool, title: str, errors: Mapping[str, float] = MappingProxyType({})
) -> None:
    """Print named figures, with their units and how far they may be off.

    :param figures: names, which end in the unit, and values
    :param as_json: one JSON object instead of a table
    :param title: what the table shows
    :param errors: standard errors, by name; the table shows 95 % intervals
    """
    if as_json:
        print(json.dumps(figures | ({"standard_errors": dict(errors)} if errors else {})))
        return
    table = Table(title=title)
    for heading in ("figure", "value", *(["95 % interval"] if errors else []), "unit"):
        table.add_column(heading, justify="left" if heading in ("figure", "unit") else "right")
    for key, value in figures.items():
        name, unit = next(
            ((key.removesuffix(end), unit) for end, unit in UNITS.items() if key.endswith(end)), (key, "")
        )
        shown = f"{value:,.3f}" if isinstance(value, float) else str(value)
        interval = [f"± {1.96 * errors[key]:,.3f}" if key in errors else ""] if errors else []
        table.add_row(name, shown, *interval, unit)
    Console().print(table)


@contextmanager
def interruptible() -> Iterator[None]:
    """Long work that keeps what it has when it is interrupted."""
    try:
        yield
    except KeyboardInterrupt:
        fail(
            "interrupted; finished runs and checkpoints are kept, the same command goes on from there",
            interrupted_status(),
        )


def fail(message: str, status: int) -> NoReturn:
    """End the command.

    :param message: one line
    :param status: exit status
    """
    say(f"lawn-sb3: {message}", "red")
    sys.exit(status)


@contextmanager
def progress(unit: str) -> "Iterator[Advance]":
    """Show a bar for each thing that is done; where no bar can be drawn, a line now and then.

    :param unit: what is counted, such as ``games``
    :return: a function to call after each with what is being done, and how many there are
    """
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn(f"{unit}, left:")
    bars = Progress(*columns, TimeRemainingColumn(), console=messages, disable=not messages.is_terminal)
    tasks: dict[str, TaskID] = {}
    last_line = began = time.monotonic()

    def advance(what: str, total: int) -> None:
        nonlocal last_line, began
        if what not in tasks:
            tasks[what] = bars.add_task(what, total=total)
            began = time.monotonic()
        bars.advance(tasks[what])
        if bars.disable and time.monotonic() - last_line > QUIET_SECONDS:
            last_line = time.monotonic()
            done = int(bars.tasks[tasks[what]].completed)
            left = (last_line - began) * (total - done) / max(done - 1, 1)  # it began as the first was done
            say(f"{what}: {done} of {total} {unit}, about {left / 60:.0f} min left")

    with bars:
        yield advance
