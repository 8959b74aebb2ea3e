"""Commands about planners: plan, ceiling."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from lawn_sb3.choices import MOST_EPISODES
from lawn_sb3.cli.console import AsJson, Changes, ScenarioName, Trusted, print_figures, progress, say
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.registry import PLANNERS, PLAYERS, check_planner, check_player, find_player, make_planner
from lawn_sb3.experiment.run_directory.configuration import load_run
from lawn_sb3.scenario import MOST_SLOTS, load_scenario

if TYPE_CHECKING:
    from lawn_sb3.game.player import Player

app = typer.Typer()


@app.command()
def plan(
    player: Annotated[str, typer.Option(help=f"planner: {', '.join(PLANNERS)}")],
    scenario: ScenarioName = "paper",
    changes: Changes = [],  # noqa: B006
    episodes: Annotated[int, typer.Option(min=1, max=MOST_EPISODES, help="joint episodes")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="picks the missions: the same for every player")] = 20_000,
    slack: Annotated[
        int | None,
        typer.Option(
            min=0,
            max=MOST_SLOTS,
            help="slots beyond T_min a flight may take; default: forecast and mean-field 0, others 5",
        ),
    ] = None,
    starts: Annotated[
        int | None, typer.Option(min=1, help="starts of the search for equilibria and welfare; default: 16")
    ] = None,
    regret: Annotated[bool, typer.Option(help="also work out what each UAV could gain by deviating alone")] = True,
    rows_file: Annotated[
        Path | None,
        typer.Option("--rows", help="also write the raw rows, one per episode and UAV, with best responses"),
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
    check_planner(player, given)

    from lawn_sb3.experiment.measures import standard_errors
    from lawn_sb3.experiment.plan_episodes import plan_episodes
    from lawn_sb3.experiment.run_directory.csv_file import write_rows

    if "on_round" in PLANNERS[player].settings:
        given["on_round"] = lambda done, rounds: say(f"fitting: round {done} of {rounds}")
    with progress("games") as advance:
        figures, flights = plan_episodes(player, game, episodes, seed, advance, regret, **given)
    for path, rows in ((rows_file, flights.rows), (paths_file, flights.paths)):
        if path is not None:
            write_rows(path, rows)
    title = f"{player} on {game.title}, {episodes} episodes"
    print_figures(figures, as_json, title, standard_errors(flights.rows))
    if "equilibrium" in player and figures.get("equilibria_percent", 100.0) < 100.0:
        say(
            "not all episodes are equilibria: searches without a fixed point, or flights longer than --slack would gain"
        )


@app.command("ceiling")
def show_ceiling(
    scenario: ScenarioName = "tiny",
    changes: Changes = [],  # noqa: B006
    players: Annotated[list[str], typer.Option("--player", help=f"also fly it: {', '.join(PLAYERS)}; repeatable")] = [],  # noqa: B006
    runs: Annotated[list[Path], typer.Option("--run", help="also fly this trained run; repeatable")] = [],  # noqa: B006
    trusted: Trusted = [],  # noqa: B006
    as_json: AsJson = False,
) -> None:
    """Prove what two UAVs of a tiny game can have at most in T_min, by what they know of each other.

    Mean utility of a UAV over all missions, each flown once, in Mbps: what no decentralised policy exceeds that is
    never later than T_min, and what the best that was found has. Planners fly without slack here if they can.
    """
    game = load_scenario(scenario, changes)
    for name in players:
        check_player(name)
    trained = {run: load_run(run, trusted) for run in runs}
    for run, cell in trained.items():
        if cell.scenario != game:
            raise UserError(f"{str(run)!r} was trained on {cell.scenario.title!r}, not on {game.title!r}")

    from lawn_sb3.experiment.ceilings import ceilings, earned
    from lawn_sb3.planning.ceiling import tiny_games

    games = tiny_games(game)
    chosen: dict[str, tuple[Player, int]] = {name: (_without_slack(name), 0) for name in players}
    for cell in trained.values():
        from lawn_sb3.experiment.players import load_player

        chosen[f"{cell.key} seed {cell.seed}"] = load_player(cell, deterministic=True), cell.seed
    say(f"{len(games.origin):,} missions, {len(games.mission):,} joint flights in time")
    proven = ceilings(games, lambda name: say(f"ceiling of who knows {name}"))
    flown = {name: earned(player, game, games, seed) for name, (player, seed) in chosen.items()}
    if as_json:
        print(json.dumps({**proven._asdict(), "earned": {name: one._asdict() for name, one in flown.items()}}))
        return
    table = Table(title=f"mean utility of a UAV on {game.title}, Mbps")
    for column in ("a UAV knows", "at most", "found"):
        table.add_column(column, justify="left" if column == "a UAV knows" else "right")
    for name, (at_most, found) in proven.ceilings.items():
        table.add_row(name, f"{at_most:.3f}", f"{found:.3f}")
    table.add_section()
    table.add_row("best joint flights in time", "", f"{proven.joint_optimum_mbps:.3f}")
    for name, one in flown.items():
        late = f" ({one.late_percent:.1f} % of the UAVs late: no ceiling holds)" if one.late_percent else ""
        table.add_row(name + late, "", f"{one.utility_mbps:.3f}")
    Console().print(table)


def _without_slack(name: str) -> "Player":
    return make_planner(name, slack=0) if "slack" in PLAYERS[name].settings else find_player(name)
