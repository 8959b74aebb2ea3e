"""Commands about one finished model or player: evaluate, verify."""

from pathlib import Path
from typing import Annotated

import typer

from lawn_sb3.choices import MOST_EPISODES
from lawn_sb3.cli.console import AsJson, Changes, Trusted, fail, print_figures
from lawn_sb3.cli.flyers import player_flyer, run_flyer
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.registry import PLAYERS
from lawn_sb3.experiment.run_directory.configuration import load_finished_run
from lawn_sb3.experiment.run_directory.files import EVALUATION_FILE
from lawn_sb3.scenario import load_scenario

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
    if run is not None:
        flyer = run_flyer(run, scenario, changes, trusted)
    else:
        assert player is not None
        flyer = player_flyer(player, load_scenario(scenario or "paper", changes))
    name, game = flyer.name, flyer.game
    if regret and flyer.flies_alone:
        raise UserError(f"--regret: the UAVs of {name!r} never meet, so none has others to respond to")

    from lawn_sb3.experiment.evaluation import fly
    from lawn_sb3.experiment.measures import regrets, standard_errors, summarize, summarize_regrets
    from lawn_sb3.experiment.run_directory.csv_file import write_rows

    flights = fly(flyer.load(sample), game, episodes, seed, flyer.seed, traced=episodes if regret else 0)
    if rows_file is not None:
        write_rows(rows_file, flights.rows)
    summary = summarize(flights.rows)
    if regret:
        summary |= summarize_regrets(regrets(flights, game, seed), flights.rows)
    figures = {"method": name, "scenario": game.title, "episodes": episodes, "seed": seed, **summary}
    print_figures(figures, as_json, f"{name} on {game.title}, {episodes} episodes", standard_errors(flights.rows))


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
