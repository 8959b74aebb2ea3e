"""The command about planners: plan."""

from __future__ import annotations

import inspect
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

from lawn_sb3.cli.console import AsJson, Changes, ScenarioName, fail, messages, print_figures, say
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import write_rows
from lawn_sb3.experiment.plans import Advance, plan_episodes
from lawn_sb3.experiment.registry import PLANNERS
from lawn_sb3.experiment.reproduce import QUIET_SECONDS
from lawn_sb3.planning.flight import ANY_SLACK
from lawn_sb3.scenario import load_scenario

app = typer.Typer()


@app.command()
def plan(
    player: Annotated[str, typer.Option(help=f"planner: {', '.join(PLANNERS)}")],
    scenario: ScenarioName = "paper",
    changes: Changes = [],  # noqa: B006
    episodes: Annotated[int, typer.Option(min=1, help="joint episodes")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="picks the missions: the same for every player")] = 20_000,
    slack: Annotated[
        int | None,
        typer.Option(
            min=0,
            max=ANY_SLACK,
            help="slots beyond T_min a flight may take; default: forecast and mean-field 0, others 5",
        ),
    ] = None,
    starts: Annotated[
        int | None, typer.Option(min=1, help="starts of the search for equilibria and welfare; default: 16")
    ] = None,
    regret: Annotated[bool, typer.Option(help="also work out what each UAV could gain by deviating alone")] = True,
    rows_file: Annotated[
        Path | None, typer.Option("--rows", help="also write the raw rows, one an episode and UAV, with best responses")
    ] = None,
    paths_file: Annotated[
        Path | None, typer.Option("--paths", help="also write where every UAV was in every slot, in voxels")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Let a planner that knows the game fly some joint episodes and print the means: rates in Mbps, times in slots.

    Beside the figures of evaluate: the bound (every UAV alone) and the share of it, fairness over the UAVs of an
    episode, regret (mean of a UAV; largest of an episode), and how the searches for equilibria ended.
    """
    game = load_scenario(scenario, changes)
    for path in (rows_file, paths_file):
        if path is not None and not path.absolute().parent.is_dir():  # before hours of planning
            raise UserError(f"{str(path)!r} cannot be written: there is no folder {str(path.parent)!r}")
    settings: dict[str, Any] = {"slack": slack, "starts": starts}
    given = {key: value for key, value in settings.items() if value is not None}
    if player in PLANNERS and "on_round" in inspect.signature(PLANNERS[player]).parameters:
        given["on_round"] = lambda done, rounds: say(f"fitting: round {done} of {rounds}")
    try:
        with _progress() as advance:
            figures, flights = plan_episodes(player, game, episodes, seed, advance, regret, **given)
    except KeyboardInterrupt:
        fail("interrupted: nothing is kept of an unfinished plan", 130)
    for path, rows in ((rows_file, flights.rows), (paths_file, flights.paths)):
        if path is not None:
            write_rows(path, rows)
    print_figures(figures, as_json, f"{player} on {game.title}, {episodes} episodes")
    if "equilibrium" in player and figures.get("equilibria_percent", 100.0) < 100.0:
        say(
            "not all episodes are equilibria: searches without a fixed point, or flights longer than --slack would gain"
        )


@contextmanager
def _progress() -> Iterator[Advance]:
    """A bar for each thing that is done, game by game; where no bar can be drawn, a line now and then."""
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("games, left:")
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
            left = (last_line - began) * (total - done) / max(done - 1, 1)  # it began as the first game was done
            say(f"{what}: {done} of {total} games, about {left / 60:.0f} min left")

    with bars:
        yield advance
