"""Commands about one finished model or player: evaluate, verify."""

from pathlib import Path
from typing import Annotated

import typer

from lawn_sb3.choices import MOST_EPISODES
from lawn_sb3.cli.console import AsJson, Changes, Trusted, fail, print_figures
from lawn_sb3.config import parse_overrides
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import fits_all_games
from lawn_sb3.experiment.registry import PLAYERS, check_player, find_player
from lawn_sb3.experiment.run_directory.configuration import load_finished_run
from lawn_sb3.experiment.run_directory.files import EVALUATION_FILE
from lawn_sb3.scenario import Scenario, load_scenario

app = typer.Typer()


@app.command("evaluate")
def evaluate_command(
    run: Annotated[Path | None, typer.Option(help="run directory of a trained model")] = None,
    player: Annotated[str | None, typer.Option(help=f"player that needs no training: {', '.join(PLAYERS)}")] = None,
    scenario: Annotated[
        str | None, typer.Option(help="preset or YAML file; default: the run's own, or paper for a player")
    ] = None,
    changes: Changes = [],  # noqa: B006
    episodes: Annotated[int, typer.Option(min=1, max=MOST_EPISODES, help="joint episodes")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="picks the missions: the same for every player")] = 20_000,
    sample: Annotated[bool, typer.Option("--sample", help="sample actions instead of taking the likeliest")] = False,
    rows_file: Annotated[
        Path | None, typer.Option("--rows", help="also write the raw rows, one per episode and UAV")
    ] = None,
    regret: Annotated[
        bool, typer.Option("--regret", help="also work out what each UAV could gain by deviating alone")
    ] = False,
    trusted: Trusted = [],  # noqa: B006
    as_json: AsJson = False,
) -> None:
    """Let a player fly some joint episodes and print the means: rates in Mbps, times in slots."""
    if (run is None) == (player is None):
        raise UserError("name either --run DIR or --player NAME")
    cell = None if run is None else load_finished_run(run, trusted)
    if cell is not None:
        own = cell.scenario if scenario is None else load_scenario(scenario)
        game = own.changed(**parse_overrides(changes)) if changes else own
        same_moves = game.max_voxel_steps == cell.scenario.max_voxel_steps
        if not same_moves or (game.num_gbs != cell.scenario.num_gbs and not _fits_any_num_gbs(cell)):
            raise UserError(f"{str(run)!r} was trained for {_sizes(cell.scenario)}; {game.name!r} has {_sizes(game)}")
        name, player, player_seed = cell.key, cell.method.player, cell.seed
    else:
        assert player is not None
        game = load_scenario(scenario or "paper", changes)
        check_player(player)
        name, player_seed = player, 0
    if regret and player is not None and PLAYERS[player].flies_alone:
        raise UserError(f"--regret: the UAVs of {name!r} never meet, so none has others to respond to")

    from lawn_sb3.experiment.evaluation import fly
    from lawn_sb3.experiment.measures import regrets, standard_errors, summarize, summarize_regrets
    from lawn_sb3.experiment.run_directory.csv_file import write_rows

    if cell is None:
        chosen = find_player(name)
    else:
        from lawn_sb3.experiment.players import load_player

        chosen = load_player(cell, not sample, game)
    flights = fly(chosen, game, episodes, seed, player_seed, traced=episodes if regret else 0)
    if rows_file is not None:
        write_rows(rows_file, flights.rows)
    summary = summarize(flights.rows)
    if regret:
        summary |= summarize_regrets(regrets(flights, game, seed), flights.rows)
    figures = {"method": name, "scenario": game.title, "episodes": episodes, "seed": seed, **summary}
    print_figures(figures, as_json, f"{name} on {game.title}, {episodes} episodes", standard_errors(flights.rows))


def _fits_any_num_gbs(cell: Cell) -> bool:
    return cell.method.policy is not None and fits_all_games(cell.method)


def _sizes(scenario: Scenario) -> str:
    return f"{scenario.num_gbs} GBSs, v_max {scenario.max_voxel_steps}"


@app.command()
def verify(
    run: Annotated[Path, typer.Argument(help="run directory of a trained model")],
    trusted: Trusted = [],  # noqa: B006
    as_json: AsJson = False,
) -> None:
    """Fly a run's test missions again and compare with the rows it left; exit status 1 if any differs.

    Where the kept weights are rounded to half precision, one row in a hundred may differ.
    """
    load_finished_run(run, trusted)

    from lawn_sb3.experiment.verification import verify_run

    found = verify_run(run, trusted)
    print_figures(found._asdict(), as_json, f"{run}, flown again")
    if not found.passed:
        fail(f"{found.rows_that_differ} of {found.rows} rows of {str(run / EVALUATION_FILE)!r} come out otherwise", 1)
