"""Commands about one model: train, evaluate, verify."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from lawn_sb3.cli.console import (
    PAPER_RECIPE,
    AsJson,
    Changes,
    fail,
    interruptible,
    messages,
    print_figures,
    say,
)
from lawn_sb3.config import parse_overrides
from lawn_sb3.errors import UserError, unknown_name
from lawn_sb3.experiment.evaluation import flies_alone, fly
from lawn_sb3.experiment.measures import regrets, summarize, summarize_regrets
from lawn_sb3.experiment.players import load_player
from lawn_sb3.experiment.recipe import Cell, Evaluation, Method, load_recipe, parse_method
from lawn_sb3.experiment.registry import ALGORITHMS, DEFAULT_POLICIES, PLAYERS, REPOSITORY, find_player
from lawn_sb3.experiment.reproduce import training_bar
from lawn_sb3.experiment.run_directory.configuration import is_finished, load_run
from lawn_sb3.experiment.run_directory.csv_file import write_rows
from lawn_sb3.experiment.run_directory.files import CONFIG_FILE, EVALUATION_FILE, FINISHED_FILE
from lawn_sb3.experiment.train import run_cell, try_method
from lawn_sb3.experiment.verification import verify_run
from lawn_sb3.scenario import Scenario, load_scenario

app = typer.Typer()


@app.command()
def train(
    out: Annotated[Path, typer.Option(help="run directory to write; a cut training in it is resumed")],
    recipe_path: Annotated[
        Path | None,
        typer.Option("--recipe", help="recipe whose --method is trained, on its game and with its settings"),
    ] = None,
    method: Annotated[str | None, typer.Option(help="method of the --recipe")] = None,
    algo: Annotated[
        str | None, typer.Option(help=f"algorithm: {', '.join(ALGORITHMS)}; default: mappo, or the method's own")
    ] = None,
    policy: Annotated[
        str | None, typer.Option(help="NAME of policies/NAME.py, or package.module:Class; default: the algorithm's own")
    ] = None,
    scenario: Annotated[
        str | None, typer.Option(help="preset or YAML file; default: paper, or the recipe's own")
    ] = None,
    changes: Changes = [],  # noqa: B006
    seed: Annotated[int, typer.Option(min=0, help="seed of everything random in training")] = 0,
    env_steps: Annotated[
        int | None, typer.Option(min=1, help="budget: joint slots of one game; default: 150000, or the method's own")
    ] = None,
    num_games: Annotated[
        int | None, typer.Option(min=1, help="games played side by side; default: as in runs/paper.yaml")
    ] = None,
    hyperparams: Annotated[
        list[str], typer.Option("--hyperparams", "-params", help="setting of the algorithm: key=value; repeatable")
    ] = [],  # noqa: B006
    device: Annotated[str, typer.Option(help="torch device: cpu, cuda, auto")] = "cpu",
    progress: Annotated[bool, typer.Option("--progress/--no-progress", "-P", help="show a progress bar")] = True,
) -> None:
    """Train one model and evaluate it on 200 episodes.

    Settings that --hyperparams does not name are those of the recipe's method; without --recipe, those of
    runs/paper.yaml for the same algorithm and policy.
    """
    changed = parse_overrides(hyperparams, "--hyperparams") | ({} if device == "cpu" else {"device": device})
    if (recipe_path is None) != (method is None):
        raise UserError("name both --recipe FILE and --method NAME, or neither")
    if recipe_path is not None and method is not None:
        if algo is not None or policy is not None:
            raise UserError("--recipe: algorithm and policy are those of its --method; leave out --algo and --policy")
        whole = _cell_of_recipe(recipe_path, method)
    else:
        whole = _cell_of_algorithm(algo or "mappo", policy, out.resolve().name)
    game = whole.scenario if scenario is None else load_scenario(scenario)
    if changes:
        game = game.changed(**parse_overrides(changes))
    values = whole.method.model_dump()
    values["settings"] = {**values["settings"], **changed}
    values |= {key: value for key, value in (("env_steps", env_steps), ("num_games", num_games)) if value is not None}
    cell = replace(whole, method=parse_method(values), seed=seed, scenario=game, directory=out)
    _refuse_folder(out)
    if is_finished(cell):
        say(f"{out} holds this run already, finished")
        return
    if (out / FINISHED_FILE).exists():
        raise UserError(
            f"--out {str(out)!r} holds a finished run with other settings: choose another folder or delete it"
        )
    try_method(cell)
    with interruptible(), training_bar(cell, messages, hidden=not progress) as advance:
        try:
            run_cell(cell, advance)
        except (ArithmeticError, AssertionError, RuntimeError, TypeError, ValueError) as error:
            reason = str(error).splitlines()[0] if str(error) else "no reason given"
            fail(f"training in {str(out)!r} failed: {type(error).__name__}: {reason}; checkpoints are kept", 1)
    say(f"the run is in {out}; evaluate it: lawn-sb3 evaluate --run {out}")


def _cell_of_recipe(path: Path, name: str) -> Cell:
    """The cell of a recipe's method, with its first seed."""
    recipe = load_recipe(path)
    if name not in recipe.methods:
        raise unknown_name("method", name, recipe.methods)
    method = recipe.methods[name]
    if method.algo is None:
        raise UserError(f"method {name!r} is a player without training; lawn-sb3 evaluate --player {method.player}")
    return Cell(name, method, 0, recipe.game(), recipe.evaluation, Path(), regret=recipe.regret)


def _cell_of_algorithm(algo: str, policy: str | None, name: str) -> Cell:
    """The cell of an algorithm with the settings of ``runs/paper.yaml``, where that has a method like it."""
    policy = policy or DEFAULT_POLICIES.get(algo)
    known = _paper_method(algo, policy)
    values = {
        "label": name,
        "algo": algo,
        "policy": policy,
        "env_steps": 150_000,
        "num_games": known.num_games if known else 64,
        "settings": known.settings if known else {},
    }
    return Cell(name, parse_method(values), 0, load_scenario("paper"), Evaluation(), Path())


def _refuse_folder(out: Path) -> None:
    """Refuse a run directory that is none."""
    if out.exists() and not out.is_dir():
        raise UserError(f"--out {str(out)!r} is a file, not a folder")
    if out.exists() and any(out.iterdir()) and not (out / CONFIG_FILE).exists():
        raise UserError(f"--out {str(out)!r} holds other files than a run's: name a new folder")


def _paper_method(algo: str, policy: str | None) -> Method | None:
    """The paper's recipe for an algorithm, with the same policy if it has that one."""
    recipe = load_recipe(REPOSITORY / PAPER_RECIPE)
    same = [method for method in recipe.methods.values() if method.algo == algo]
    exact = [method for method in same if method.policy == policy]
    return next(iter(exact or same), None)


@app.command("evaluate")
def evaluate_command(
    run: Annotated[Path | None, typer.Option(help="run directory of a trained model")] = None,
    player: Annotated[str | None, typer.Option(help=f"player that needs no training: {', '.join(PLAYERS)}")] = None,
    scenario: Annotated[
        str | None, typer.Option(help="preset or YAML file; default: the run's own, or paper for a player")
    ] = None,
    changes: Changes = [],  # noqa: B006
    episodes: Annotated[int, typer.Option(min=1, help="joint episodes")] = 200,
    seed: Annotated[int, typer.Option(min=0, help="picks the missions: the same for every player")] = 20_000,
    sample: Annotated[bool, typer.Option("--sample", help="sample actions instead of taking the likeliest")] = False,
    rows_file: Annotated[
        Path | None, typer.Option("--rows", help="also write the raw rows, one per episode and UAV")
    ] = None,
    regret: Annotated[
        bool, typer.Option("--regret", help="also work out what each UAV could gain by deviating alone")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Let a player fly some joint episodes and print the means: rates in Mbps, times in slots."""
    if (run is None) == (player is None):
        raise UserError("name either --run DIR or --player NAME")
    if run is not None:
        cell = load_run(run)
        own = cell.scenario if scenario is None else load_scenario(scenario)
        game = own.changed(**parse_overrides(changes)) if changes else own
        if (game.num_gbs, game.max_voxel_steps) != (cell.scenario.num_gbs, cell.scenario.max_voxel_steps):
            raise UserError(f"{str(run)!r} was trained for {_sizes(cell.scenario)}; {game.name!r} has {_sizes(game)}")
        if not is_finished(cell):
            raise UserError(f"{str(run)!r} is not finished, or its policy file has changed since")
        chosen, name, player_seed = load_player(cell, deterministic=not sample), cell.key, cell.seed
    else:
        assert player is not None
        game = load_scenario(scenario or "paper", changes)
        chosen, name, player_seed = find_player(player), player, 0
    if regret and flies_alone(chosen):
        raise UserError(f"--regret: the UAVs of {name!r} never meet, so none has others to respond to")
    flights = fly(chosen, game, episodes, seed, player_seed, traced=episodes if regret else 0)
    if rows_file is not None:
        write_rows(rows_file, flights.rows)
    summary = summarize(flights.rows)
    if regret:
        summary |= summarize_regrets(regrets(flights, game, seed), flights.rows)
    figures = {"method": name, "scenario": game.title, "episodes": episodes, "seed": seed, **summary}
    print_figures(figures, as_json, f"{name} on {game.title}, {episodes} episodes")


def _sizes(scenario: Scenario) -> str:
    return f"{scenario.num_gbs} GBSs, v_max {scenario.max_voxel_steps}"


@app.command()
def verify(
    run: Annotated[Path, typer.Argument(help="run directory of a trained model")],
    as_json: AsJson = False,
) -> None:
    """Fly a run's test missions again and compare with the rows it left; exit status 1 if any differs.

    Where the kept weights are rounded to half precision, one row in a hundred may differ.
    """
    found = verify_run(run)
    print_figures(found._asdict(), as_json, f"{run}, flown again")
    if not found.passed:
        fail(f"{found.rows_that_differ} of {found.rows} rows of {str(run / EVALUATION_FILE)!r} come out otherwise", 1)
