"""The command line: ``lawn-sb3``, also ``python -m lawn_sb3``."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.benchmark import benchmark
from lawn_sb3.experiment.cell import is_finished, run_cell, write_rows
from lawn_sb3.experiment.evaluation import evaluate, summarize
from lawn_sb3.experiment.players import build_model, load_player, load_run
from lawn_sb3.experiment.recipe import Cell, Evaluation, Method, cells, load_recipe, parse_method
from lawn_sb3.experiment.registry import ALGORITHMS, DEFAULT_POLICIES, PLAYERS, REPOSITORY, find_player
from lawn_sb3.experiment.reproduce import FailedRunsError, run_cells, training_bar
from lawn_sb3.experiment.tuning import load_search, ranked_trials, run_search
from lawn_sb3.report.page import write_report
from lawn_sb3.report.table_two import as_text, table_two
from lawn_sb3.scenario import PRESETS, Scenario, load_scenario, parse_overrides, parse_scenario

app = typer.Typer(
    help="Train, evaluate and reproduce: game-theoretic trajectory planning of UAV swarms, with Stable-Baselines3.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
messages = Console(stderr=True)

PAPER_RECIPE = Path("runs/paper.yaml")
ScenarioName = Annotated[str, typer.Option(help=f"{', '.join(PRESETS)}, or the path of a YAML file")]
Changes = Annotated[list[str], typer.Option("--set", help="change a constant of the scenario: key=value; repeatable")]
AsJson = Annotated[bool, typer.Option("--json", help="print one JSON object on standard output and nothing else")]
RecipePath = Annotated[Path, typer.Argument(help="the recipe")]


@app.command()
def train(
    out: Annotated[Path, typer.Option(help="run directory to write; a cut training in it is resumed")],
    algo: Annotated[str, typer.Option(help=f"algorithm: {', '.join(ALGORITHMS)}")] = "mappo",
    policy: Annotated[
        str | None, typer.Option(help="NAME of policies/NAME.py, or package.module:Class; default: the algorithm's own")
    ] = None,
    scenario: ScenarioName = "paper",
    changes: Changes = [],  # noqa: B006
    seed: Annotated[int, typer.Option(min=0, help="seed of everything random in training")] = 0,
    env_steps: Annotated[int, typer.Option(min=1, help="budget: joint slots of one game")] = 150_000,
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

    Settings that --hyperparams does not name are those of runs/paper.yaml for the same algorithm and policy.
    """
    chosen = policy or DEFAULT_POLICIES.get(algo)
    known = _paper_method(algo, chosen)
    settings = {**(known.settings if known else {}), **parse_overrides(hyperparams, "--hyperparams"), "device": device}
    values = {
        "label": out.resolve().name,
        "algo": algo,
        "policy": chosen,
        "env_steps": env_steps,
        "num_games": num_games or (known.num_games if known else 64),
        "settings": settings,
    }
    cell = Cell(out.resolve().name, parse_method(values), seed, load_scenario(scenario, changes), Evaluation(), out)
    if out.exists() and not out.is_dir():
        raise UserError(f"--out {str(out)!r} is a file, not a folder")
    if is_finished(cell):
        messages.print(f"{out} holds this run already, finished", markup=False, soft_wrap=True)
        return
    if (out / "finished").exists():
        raise UserError(
            f"--out {str(out)!r} holds a finished run with other settings: choose another folder or delete it"
        )
    with _interruptible(), training_bar(cell, messages, hidden=not progress) as advance:
        run_cell(cell, advance)
    messages.print(f"the run is in {out}; evaluate it: lawn-sb3 evaluate --run {out}", markup=False, soft_wrap=True)


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
        Path | None, typer.Option("--rows", help="also write the raw rows, one an episode and UAV")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Let a player fly some joint episodes and print the means: rates in Mbps, times in slots."""
    if (run is None) == (player is None):
        raise UserError("name either --run DIR or --player NAME")
    if run is not None:
        cell = load_run(run)
        own = cell.scenario if scenario is None else load_scenario(scenario)
        changed = {**own.model_dump(), **parse_overrides(changes)}
        game = parse_scenario(changed, where=f"scenario {own.name!r}") if changes else own
        if (game.num_uavs, game.num_gbs, game.max_voxel_steps) != (
            cell.scenario.num_uavs,
            cell.scenario.num_gbs,
            cell.scenario.max_voxel_steps,
        ):
            raise UserError(f"{str(run)!r} was trained for {_sizes(cell.scenario)}; {game.name!r} has {_sizes(game)}")
        if not is_finished(cell):
            raise UserError(f"{str(run)!r} is not finished, or its policy file has changed since")
        chosen, name, player_seed = load_player(cell, deterministic=not sample), cell.key, cell.seed
    else:
        assert player is not None
        game = load_scenario(scenario or "paper", changes)
        chosen, name, player_seed = find_player(player), player, 0
    rows = evaluate(chosen, game, episodes, seed, player_seed)
    if rows_file is not None:
        write_rows(rows_file, rows)
    summary = summarize(rows)
    figures = {"method": name, "scenario": game.title, "episodes": episodes, "seed": seed, **summary}
    _print_figures(figures, as_json, f"{name} on {game.title}, {episodes} episodes")


def _sizes(scenario: Scenario) -> str:
    return f"{scenario.num_uavs} UAVs, {scenario.num_gbs} GBSs, v_max {scenario.max_voxel_steps}"


@app.command()
def reproduce(
    recipe_path: RecipePath = PAPER_RECIPE,
    jobs: Annotated[int, typer.Option(min=1, help="runs side by side, one core each")] = 2,
) -> None:
    """Run what a recipe lacks, then write its report.

    Finished runs are kept, cut ones are resumed, those made with other settings are made anew.
    """
    recipe = load_recipe(recipe_path)
    todo = cells(recipe, recipe_path.parent / recipe.name)
    for cell in {cell.key: cell for cell in todo}.values():
        if cell.method.algo is not None:
            build_model(cell)  # an algorithm that refuses its settings is found before anything runs
    with _interruptible():
        try:
            run_cells(todo, jobs, messages)
        except FailedRunsError:
            with suppress(UserError, OSError):  # the failure says more than that there is nothing to report
                _report(recipe_path)
            raise
        _report(recipe_path)


@app.command()
def report(recipe_path: RecipePath = PAPER_RECIPE) -> None:
    """Rebuild tables and figures from what the runs of a recipe left; nothing is trained."""
    _report(recipe_path)


def _report(recipe_path: Path) -> None:
    recipe = load_recipe(recipe_path)
    root = recipe_path.parent / recipe.name
    results = write_report(recipe, cells(recipe, root), root / "report", recipe_path)
    shown = as_text(table_two(results))
    table = Table(title=f"Table II: {recipe.title or recipe.name}; the paper's values in parentheses")
    for heading in shown.columns:
        table.add_column(heading, justify="left" if heading == "Method" else "right")
    for row in shown.itertuples(index=False):
        table.add_row(*map(escape, row))
    _wide_console().print(table)
    for problem in results.problems:
        messages.print(f"not in the report: {problem}", style="yellow", markup=False)
    messages.print(f"report: {root / 'report' / 'README.md'}", soft_wrap=True)


@app.command()
def tune(
    search_path: Annotated[Path, typer.Argument(help="what to search")] = Path("runs/tuning.yaml"),
    jobs: Annotated[int, typer.Option(min=1, help="trainings side by side, one core each")] = 2,
    show: Annotated[bool, typer.Option("--show", help="run nothing, only show the trials so far")] = False,
) -> None:
    """Search for settings: as many trials for every method, on seeds apart from the reported ones."""
    search, methods = load_search(search_path)
    folder = search_path.with_suffix("")
    with _interruptible():
        if not show:
            run_search(search, methods, folder, jobs, messages)
    table = Table(title=f"trials: mean greedy reward J after {search.env_steps:,} env steps")
    for heading in ("method", "rank", "J", "settings"):
        table.add_column(heading)
    for method, rank, reward, settings in ranked_trials(search, folder).itertuples(index=False):
        table.add_row(
            method, str(rank), f"{reward:.3f}", ", ".join(f"{key} {value}" for key, value in settings.items())
        )
    _wide_console().print(table)


@app.command()
def bench(as_json: AsJson = False) -> None:
    """Measure the speed of simulator, vector environment and training, on one core."""
    recipe = load_recipe(REPOSITORY / PAPER_RECIPE)
    method = next(method for method in recipe.methods.values() if method.algo == "mappo")
    figures = benchmark(method, lambda text: messages.print(f"measuring: {text}"))
    _print_figures(figures, as_json, "speed on one core")


@app.command("scenario")
def scenario_command(
    name: Annotated[str, typer.Argument(help=f"{', '.join(PRESETS)}, or the path of a YAML file")] = "paper",
    changes: Changes = [],  # noqa: B006
    as_yaml: Annotated[bool, typer.Option("--yaml", help="print YAML that --scenario FILE.yaml reads")] = False,
) -> None:
    """Show every constant of a scenario: symbol, value, unit, and where the value comes from."""
    chosen = load_scenario(name, changes)
    if as_yaml:
        print(chosen.to_yaml(), end="")
        return
    table = Table(title=f"scenario {chosen.name}")
    for heading in ("constant", "symbol", "value", "unit", "source", "what it is"):
        table.add_column(heading, no_wrap=heading == "constant")
    for key, field in Scenario.model_fields.items():
        extra = field.json_schema_extra
        if isinstance(extra, dict):
            value = str(getattr(chosen, key))
            table.add_row(key, str(extra["symbol"]), value, str(extra["unit"]), str(extra["source"]), field.description)
    Console().print(table)


def _wide_console() -> Console:
    """Standard output, wide enough for a whole table where there is no terminal to fit."""
    return Console(width=None if sys.stdout.isatty() else 160)


def _print_figures(figures: dict[str, Any], as_json: bool, title: str) -> None:
    if as_json:
        print(json.dumps(figures))
        return
    table = Table(title=title)
    table.add_column("figure")
    table.add_column("value", justify="right")
    for key, value in figures.items():
        table.add_row(key, f"{value:,.3f}" if isinstance(value, float) else str(value))
    Console().print(table)


def main() -> None:
    """Run the command line: exit status 2 for bad input, 1 for failed work, 130 when interrupted."""
    try:
        app()
    except UserError as error:
        _fail(str(error), 2)
    except FailedRunsError as error:
        _fail(f"{error}; finished runs are kept, the same command resumes the others", 1)
    except OSError as error:
        _fail(f"{error.strerror or error}: {error.filename or 'a file'}; what is finished is kept", 1)


@contextmanager
def _interruptible() -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        _fail("interrupted; finished runs and checkpoints are kept, the same command goes on from there", 130)


def _fail(message: str, status: int) -> None:
    messages.print(f"lawn-sb3: {message}", style="red", markup=False, highlight=False, soft_wrap=True)
    sys.exit(status)
