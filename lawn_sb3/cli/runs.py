"""Commands about runs at hand: runs, compare."""

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lawn_sb3.cli.console import PICTURES, AsJson, Trusted, print_table, say
from lawn_sb3.errors import UserError

if TYPE_CHECKING:
    from lawn_sb3.results.at_hand import Listed

app = typer.Typer()

AGES = (("d", 86_400), ("h", 3_600), ("min", 60))


@app.command("runs")
def runs_command(
    folder: Annotated[Path, typer.Argument(help="where to look, also in the folders below it")] = Path("runs"),
    trusted: Trusted = [],  # noqa: B006
    as_json: AsJson = False,
) -> None:
    """List runs: who flew what, how far each is, and what came out on its test missions."""
    if not folder.is_dir():
        raise UserError(f"{str(folder)!r} is no folder")

    from lawn_sb3.results.at_hand import runs_below

    show_runs(list(runs_below(folder, trusted)), folder, as_json)


def show_runs(listed: "list[Listed]", folder: Path, as_json: bool = False) -> None:
    """Print a list of runs.

    :param listed: the runs
    :param folder: where they are
    :param as_json: one JSON object instead of a table
    """
    if as_json:
        print(json.dumps({"runs": [one._asdict() for one in listed]}))
        return
    if not listed:
        say(f"no runs in {folder}")
        return

    import pandas as pd

    rows = [
        {
            "run": Path(one.run).relative_to(folder).as_posix(),
            "method": one.method,
            "flown by": one.flown_by,
            "game": one.game,
            "seed": "" if one.seed is None else str(one.seed),
            "state": one.state,
            "J̄": _number(one.reward, 2),
            "U (Mbps)": _number(one.utility_mbps, 1),
            "success (%)": _number(one.success_percent, 1),
            "age": _age(one.began),
        }
        for one in listed
    ]
    print_table(pd.DataFrame(rows), f"{len(listed)} run{'' if len(listed) == 1 else 's'} in {folder}")


def _number(value: float | None, decimals: int) -> str:
    return "" if value is None else f"{value:.{decimals}f}"


def _age(began: str | None) -> str:
    """How long ago that was, in the largest unit that there is one of."""
    if began is None:
        return ""
    try:
        seconds = (datetime.now(UTC) - datetime.fromisoformat(began)).total_seconds()
    except (ValueError, TypeError):  # not a time, or one without its zone
        return ""
    return next((f"{seconds // size:.0f} {unit}" for unit, size in AGES if seconds >= size), "now")


@app.command()
def compare(
    runs: Annotated[
        list[Path],
        typer.Argument(help="finished runs, or folders of runs that differ in their seeds; the first is the base"),
    ],
    figure: Annotated[Path | None, typer.Option(help="also draw them to this .png, .pdf or .svg")] = None,
    trusted: Trusted = [],  # noqa: B006
    as_json: AsJson = False,
) -> None:
    """Compare runs that flew the same test missions: means, intervals, and differences to the first."""
    if len(runs) < 2:
        raise UserError("name at least two runs: the others are compared with the first")
    if len(set(runs)) < len(runs):
        raise UserError("each run can be named once")
    if figure is not None and figure.suffix not in PICTURES:
        raise UserError(f"--figure {str(figure)!r}: a file that ends in {', '.join(PICTURES)}")
    for run in runs:
        if not run.is_dir():
            raise UserError(f"{str(run)!r} is no folder")

    from lawn_sb3.report.comparison import comparison_figure, comparison_table
    from lawn_sb3.results.at_hand import contestants

    compared = contestants(runs, trusted)
    table = comparison_table(compared)
    if figure is not None:
        from lawn_sb3.report.style import save

        save(comparison_figure(compared), figure.parent, figure.stem, (figure.suffix,))
    if as_json:
        print(json.dumps({"rows": json.loads(table.numbers.to_json(orient="records")), "caption": table.caption}))
        return
    print_table(table.shown, "The same test missions")
    say(table.caption)
    if figure is not None:
        say(f"figure: {figure}")
