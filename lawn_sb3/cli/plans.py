"""The command about planners: plan."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

from lawn_sb3.cli.console import AsJson, Changes, ScenarioName, fail, messages, print_figures, say
from lawn_sb3.experiment.plans import plan_figures
from lawn_sb3.experiment.registry import PLANNERS
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
        int | None, typer.Option(min=0, help="slots beyond T_min that a flight may take; default: forecast 0, others 5")
    ] = None,
    starts: Annotated[
        int | None, typer.Option(min=1, help="starts of the search for equilibria and welfare; default: 16")
    ] = None,
    regret: Annotated[bool, typer.Option(help="also work out what each UAV could gain by deviating alone")] = True,
    as_json: AsJson = False,
) -> None:
    """Let a planner that knows the game fly some joint episodes and print the means: rates in Mbps, times in slots.

    Beside the figures of evaluate: the bound (every UAV alone) and the share of it, fairness over the UAVs of an
    episode, regret (mean of a UAV; largest of an episode), and how the searches for equilibria ended.
    """
    game = load_scenario(scenario, changes)
    settings: dict[str, Any] = {"slack": slack, "starts": starts}
    given = {key: value for key, value in settings.items() if value is not None}
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("games, left:")
    bars = Progress(*columns, TimeRemainingColumn(), console=messages, disable=not messages.is_terminal)
    tasks: dict[str, TaskID] = {}

    def advance(what: str, total: int) -> None:
        if what not in tasks:
            tasks[what] = bars.add_task(what, total=total)
        bars.advance(tasks[what])

    try:
        with bars:
            figures = plan_figures(player, game, episodes, seed, advance, regret, **given)
    except KeyboardInterrupt:
        fail("interrupted: nothing is kept of an unfinished plan", 130)
    print_figures(figures, as_json, f"{player} on {game.title}, {episodes} episodes")
    if "equilibrium" in player and figures.get("equilibria_percent", 100.0) < 100.0:
        say(
            "not all episodes are equilibria: searches without a fixed point, or flights longer than --slack would gain"
        )
