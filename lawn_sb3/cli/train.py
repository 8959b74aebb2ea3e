"""The command about training one model: train."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from lawn_sb3.cli.console import (
    PAPER_RECIPE,
    Address,
    BackendName,
    Changes,
    Jobs,
    fail,
    interruptible,
    messages,
    print_figures,
    say,
)
from lawn_sb3.cli.runs import show_runs
from lawn_sb3.config import parse_overrides
from lawn_sb3.errors import UserError, said, unknown_name
from lawn_sb3.experiment.backends.choice import find_backend
from lawn_sb3.experiment.backends.job import Backend
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Evaluation, Method, honest_label, parse_method, read_recipe
from lawn_sb3.experiment.registry import ALGORITHMS
from lawn_sb3.experiment.reproduce import run_cells, training_bar
from lawn_sb3.experiment.run_directory.configuration import is_finished
from lawn_sb3.experiment.run_directory.files import (
    CONFIG_FILE,
    FINISHED_FILE,
    LOCK_FILE,
    LOG_FILE,
    PROVENANCE_FILE,
)
from lawn_sb3.experiment.shipped import shipped_recipe
from lawn_sb3.scenario import load_scenario

app = typer.Typer()

MOST_SEEDS = 1_000
"""Of one command."""


@app.command()
def train(
    out: Annotated[Path, typer.Option(help="run directory to write; an interrupted training in it is resumed")],
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
    seed: Annotated[int | None, typer.Option(min=0, help="seed of everything random in training; default: 0")] = None,
    seeds: Annotated[
        str | None, typer.Option(help="train one run for each instead, in --out/seed-K: 0-4, or 0,2,7")
    ] = None,
    jobs: Jobs = None,
    backend: BackendName = "local",
    address: Address = None,
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
    """Train one model, or one for each of several seeds, and evaluate it on 200 episodes.

    Settings that --hyperparams does not name are those of the recipe's method; without --recipe, those of
    runs/paper.yaml for the same algorithm and policy.
    """
    chosen = _seeds(seed, seeds)
    if seeds is None and (jobs is not None or backend != "local" or address is not None):
        raise UserError("--jobs, --backend and --address: only for several runs, with --seeds")
    workers = find_backend(backend, jobs, address)
    settings = parse_overrides(hyperparams, "--hyperparams") | ({} if device == "cpu" else {"device": device})
    if (recipe_path is None) != (method is None):
        raise UserError("name both --recipe FILE and --method NAME, or neither")
    if recipe_path is not None and method is not None:
        if algo is not None or policy is not None:
            raise UserError("--recipe: algorithm and policy are those of its --method; leave out --algo and --policy")
        cell = _cell_of_recipe(recipe_path, method)
    else:
        cell = _cell_of_algorithm(algo or "mappo", policy, out.resolve().name)
    if scenario is not None:
        cell = replace(cell, scenario=load_scenario(scenario))
    if changes:
        cell = replace(cell, scenario=cell.scenario.changed(**parse_overrides(changes)))
    changed = _changed(cell.method, settings, env_steps=env_steps, num_games=num_games)
    cell = replace(cell, method=changed, seed=chosen[0], directory=out)
    if seeds is not None:
        _train_seeds([replace(cell, seed=one, directory=out / f"seed-{one}") for one in chosen], out, workers)
        return
    if _has_to_run(cell):
        from lawn_sb3.experiment.train import try_method

        try_method(cell)
        _run(cell, progress)
        say(f"the run is in {out}; evaluate it: lawn-sb3 evaluate --run {out}")
    else:
        say(f"{out} holds this run already, finished")
    _show_result(cell)


def _seeds(seed: int | None, seeds: str | None) -> list[int]:
    """The seeds to train: one, or all that a text such as ``0-4`` or ``0,2,7`` names."""
    if seeds is None:
        return [seed or 0]
    if seed is not None:
        raise UserError("name --seed K or --seeds K-L, not both")
    found: list[int] = []
    for part in seeds.split(","):
        match = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", part.strip())
        low, high = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
        if low > high or high - low >= MOST_SEEDS:
            raise UserError(
                f"--seeds {seeds!r}: whole numbers from 0 up and ranges such as 0-4, with commas between, at most "
                f"{MOST_SEEDS}"
            )
        found += range(low, high + 1)
    if len(set(found)) < len(found):
        raise UserError(f"--seeds {seeds!r}: each seed once")
    return found


def _train_seeds(todo: list[Cell], out: Path, workers: Backend) -> None:
    """Train some seeds side by side, each in a folder of its own, and list them."""
    if out.exists() and not out.is_dir():
        raise UserError(f"--out {str(out)!r} is a file, not a folder")
    if (out / CONFIG_FILE).exists():
        raise UserError(f"--out {str(out)!r} holds a run: name another folder for several")
    unfinished = [cell for cell in todo if _has_to_run(cell)]  # all are looked at before any is begun
    if unfinished:
        from lawn_sb3.experiment.train import try_method

        try_method(unfinished[0])
    with interruptible():
        run_cells(todo, workers, messages)

    from lawn_sb3.results.at_hand import runs_below

    show_runs(list(runs_below(out, [cell.method.policy for cell in todo if cell.method.policy])), out)


def _show_result(cell: Cell) -> None:
    """Print what a finished run came to."""
    from lawn_sb3.experiment.measures import standard_errors, summarize
    from lawn_sb3.experiment.run_directory.reading import read_evaluation

    record = json.loads((cell.directory / PROVENANCE_FILE).read_text(encoding="utf-8"))
    steps = record.get("trained_env_steps", cell.method.env_steps)
    if steps != cell.method.env_steps:
        say(f"trained {steps:,} env steps: whole rollouts, so not just the {cell.method.env_steps:,} asked for")
    rows = read_evaluation(cell)
    title = f"{cell.method.label} after {steps:,} env steps, {cell.evaluation.episodes} episodes"
    print_figures(summarize(rows), False, title, standard_errors(rows))


def _cell_of_recipe(path: Path, name: str) -> Cell:
    """The cell of a recipe's method."""
    recipe = read_recipe(shipped_recipe(path))
    if name not in recipe.methods:
        raise unknown_name("method", name, recipe.methods)
    method = recipe.methods[name]
    if method.algo is None:
        raise UserError(f"method {name!r} is a player without training; lawn-sb3 evaluate --player {method.player}")
    return Cell(name, method, 0, recipe.game(), recipe.evaluation, Path(), regret=recipe.regret)


def _cell_of_algorithm(algo: str, policy: str | None, name: str) -> Cell:
    """The cell of an algorithm with the settings of ``runs/paper.yaml``, where that has a method like it."""
    if policy is None and algo in ALGORITHMS:
        policy = ALGORITHMS[algo].default_policy
    same = [method for method in read_recipe(shipped_recipe(PAPER_RECIPE)).methods.values() if method.algo == algo]
    exact = [method for method in same if method.policy == policy]
    like: dict[str, Any] = {}
    for known in (exact or same)[:1]:
        like = {"num_games": known.num_games, "settings": known.settings}
    method = parse_method({"label": name, "algo": algo, "policy": policy, "env_steps": 150_000, **like})
    return Cell(name, method, 0, load_scenario("paper"), Evaluation(), Path())


def _changed(method: Method, settings: dict[str, Any], **fields: int | None) -> Method:
    """A method with some settings and fields changed; those without a number stay."""
    values = method.model_dump() | {name: value for name, value in fields.items() if value is not None}
    values["settings"] = method.settings | settings
    values["label"] = honest_label(method.label, values["settings"])
    return parse_method(values)


def _has_to_run(cell: Cell) -> bool:
    """Whether a cell's directory lacks its finished run; a directory that holds something else is refused."""
    out = cell.directory
    if out.exists() and not out.is_dir():
        raise UserError(f"--out {str(out)!r} is a file, not a folder")
    others = {path.name for path in out.iterdir()} - {LOCK_FILE, LOG_FILE} if out.exists() else set()
    if others and CONFIG_FILE not in others:
        raise UserError(f"--out {str(out)!r} holds other files than a run's: name a new folder")
    if is_finished(cell):
        return False
    if (out / FINISHED_FILE).exists():
        raise UserError(
            f"--out {str(out)!r} holds a finished run with other settings: choose another folder or delete it"
        )
    return True


def _run(cell: Cell, progress: bool) -> None:
    """Train and evaluate; a failure is told in one line."""
    from lawn_sb3.experiment.train import run_cell

    with interruptible(), training_bar(cell, messages, hidden=not progress) as advance:
        try:
            run_cell(cell, advance)
        except (ArithmeticError, AssertionError, RuntimeError, TypeError, ValueError) as error:
            fail(f"training in {str(cell.directory)!r} failed: {said(error)}; checkpoints are kept", 1)
