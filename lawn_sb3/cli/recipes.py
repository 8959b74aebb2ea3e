"""Commands about whole recipes: reproduce, ablate, report, export, tune."""

import shutil
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from lawn_sb3.cli.console import (
    ABLATION_RECIPE,
    PAPER_RECIPE,
    Address,
    BackendName,
    Jobs,
    RecipePath,
    interruptible,
    messages,
    print_table,
    say,
    wide_console,
)
from lawn_sb3.errors import FailedRunsError, UserError
from lawn_sb3.experiment.backends.choice import find_backend
from lawn_sb3.experiment.cell import Cell, cells
from lawn_sb3.experiment.policy_places import locate
from lawn_sb3.experiment.recipe import Recipe, check_policies, read_recipe
from lawn_sb3.experiment.reproduce import run_cells
from lawn_sb3.experiment.run_directory.configuration import check_finished, is_finished
from lawn_sb3.experiment.run_directory.files import ABLATION_FILES, MANIFEST_FILE, RESULT_FILES, WEIGHTS_FILE
from lawn_sb3.experiment.run_directory.manifest import vouch_late
from lawn_sb3.experiment.run_directory.writer import only_writer
from lawn_sb3.experiment.search import load_search
from lawn_sb3.experiment.shipped import shipped_recipe

if TYPE_CHECKING:
    from lawn_sb3.report.document import Report

app = typer.Typer()


@app.command()
def reproduce(
    recipe_path: RecipePath = PAPER_RECIPE,
    jobs: Jobs = None,
    backend: BackendName = "local",
    address: Address = None,
) -> None:
    """Run what a recipe lacks, write its report, and compare with the reference results.

    Finished runs are kept, interrupted ones are resumed, those made with other settings are made anew.
    """
    source, command = shipped_recipe(recipe_path), f"lawn-sb3 reproduce {recipe_path.as_posix()}"
    recipe = read_recipe(source)
    workers = find_backend(backend, jobs, address)
    check_policies(recipe, source)
    runs = recipe_path.parent / recipe.name
    todo = cells(recipe, runs)
    _try_methods(todo)

    from lawn_sb3.experiment.after_training import add_costs, add_regrets, add_scaling
    from lawn_sb3.paper.making import fly_checks
    from lawn_sb3.report.contents import build_report

    with interruptible(), only_writer(runs):
        try:
            run_cells(todo, workers, messages)
            if recipe.scaling is not None:
                add_scaling(todo, recipe.scaling, messages)
                if recipe.scaling.costs:
                    add_costs(todo, recipe.scaling, messages)
            if recipe.regret:
                add_regrets(todo, messages)
        except FailedRunsError:
            with suppress(UserError, OSError):  # the failure says more than that there is nothing to report
                fly_checks(recipe, todo, messages)
                _publish(build_report(recipe, todo, command), runs / "report")
            raise
        fly_checks(recipe, todo, messages)
        _publish(build_report(recipe, todo, command), runs / "report")
    if not recipe.variants:
        _compare(recipe, runs, _reference(recipe_path, recipe))


def _try_methods(todo: list[Cell]) -> None:
    """Refuse broken policies and settings before anything runs."""
    from lawn_sb3.experiment.train import try_method

    for cell in {(cell.variant, cell.key): cell for cell in todo}.values():
        if cell.method.algo is not None:
            try_method(cell)


@app.command()
def ablate(
    policy: Annotated[str, typer.Argument(help="NAME of policies/NAME.py, or package.module:Class")],
    recipe_path: Annotated[Path, typer.Option("--recipe", help="the ablations to compare with")] = ABLATION_RECIPE,
    jobs: Jobs = None,
    backend: BackendName = "local",
    address: Address = None,
) -> None:
    """Train a policy of yours with the default settings, and compare it with all ablations.

    It takes the place of the default policy of its algorithm. What it is compared with are your own runs of the
    recipe, or the reference results of each method that you have not run in full; where there are neither, the default
    is trained too.
    """
    source = shipped_recipe(recipe_path)
    recipe = read_recipe(source)
    locate(policy)
    workers = find_backend(backend, jobs, address)
    check_policies(recipe, source)

    from lawn_sb3.experiment.ablation import with_policy
    from lawn_sb3.report.contents import build_report

    recipe, key = with_policy(recipe, policy)
    runs, reference = recipe_path.parent / recipe.name, _reference(source, recipe)
    todo = cells(recipe, runs)
    unfinished = {cell.key for cell in todo if cell.key != key and not is_finished(cell)}
    kept = [cell for cell in cells(recipe, reference) if cell.key in unfinished]
    compared = [cell for cell in todo if cell.key not in unfinished] + kept
    own = [cell for cell in todo if cell.key == key]
    base = recipe.methods[key].baseline
    if not any(is_finished(cell) for cell in compared if cell.key == base):
        own += [cell for cell in todo if cell.key == base]
        compared += own[len(recipe.seeds) :]
        unfinished.remove(str(base))
    _try_methods(own)
    with interruptible(), only_writer(runs):
        run_cells(own, workers, messages)
    option = "" if recipe_path == ABLATION_RECIPE else f" --recipe {recipe_path.as_posix()}"
    report = build_report(recipe, compared, f"lawn-sb3 ablate {policy}{option}")
    if kept:
        report.summary.append(f"Reference results, not your own runs: {', '.join(sorted(unfinished))}.")
    _publish(report, runs / key / "report")


@app.command("report")
def report_command(
    recipe_path: RecipePath = PAPER_RECIPE,
    runs: Annotated[
        Path | None, typer.Option(help="where the runs are, such as runs/reference/paper; default: runs/NAME")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="folder to write; default: report/ beside the runs")] = None,
) -> None:
    """Rebuild tables, figures and verdicts from what the runs of a recipe left; nothing is trained."""
    source = shipped_recipe(recipe_path)
    recipe = read_recipe(source)
    chosen = runs or recipe_path.parent / recipe.name
    reference = _reference(recipe_path, recipe)
    if not chosen.is_dir():
        hint = (
            f"; the reference results are in {str(reference)!r}: add --runs {reference}" if reference.is_dir() else ""
        )
        raise UserError(f"no runs in {str(chosen)!r}: run lawn-sb3 reproduce {recipe_path} first{hint}")
    check_policies(recipe, source)

    from lawn_sb3.report.contents import build_report

    command = f"lawn-sb3 report {recipe_path.as_posix()}" + (f" --runs {runs.as_posix()}" if runs else "")
    todo = cells(recipe, chosen)
    _publish(build_report(recipe, todo, command), out or chosen / "report")
    finished = [cell for cell in todo if is_finished(cell)]
    without = sum(not (cell.directory / MANIFEST_FILE).exists() for cell in finished)
    if without:
        say(f"{without} of {len(finished)} runs hold no {MANIFEST_FILE}: nothing vouches for their files", "yellow")


@app.command()
def export(
    recipe_path: RecipePath = PAPER_RECIPE,
    to: Annotated[Path | None, typer.Option(help="folder to write; default: runs/reference/NAME")] = None,
    vouch: Annotated[
        bool, typer.Option("--vouch", help=f"instead give runs kept there the {MANIFEST_FILE} that they lack")
    ] = False,
) -> None:
    """Keep finished runs as reference results: rows, curves, provenance, and the weights of one model a method.

    Of a recipe with changed games the report alone is kept, of ablations all that their report reads.
    """
    source = shipped_recipe(recipe_path)
    recipe = read_recipe(source)
    runs, folder = recipe_path.parent / recipe.name, to or _reference(recipe_path, recipe)
    if vouch:
        kept = [cell.directory for cell in cells(recipe, folder) if is_finished(cell)]
        without = [directory for directory in kept if not (directory / MANIFEST_FILE).exists()]
        for directory in without:
            vouch_late(directory)
        say(f"{len(without)} of {len(kept)} runs in {folder} are vouched for from now on, the others were already")
        return
    if folder.resolve() == runs.resolve():
        raise UserError(f"--to {str(folder)!r} is where the runs are")
    if folder.exists() and not (folder / "report" / "report.json").exists() and any(folder.iterdir()):
        raise UserError(f"--to {str(folder)!r} holds something else than an earlier export: name a new folder")
    finished = cells(recipe, runs)
    if not recipe.variants:
        check_finished(finished)
    check_policies(recipe, source)

    from lawn_sb3.experiment.reference import export_runs
    from lawn_sb3.paper.checks import export_checks
    from lawn_sb3.report.contents import build_report

    if recipe.variants:  # too many runs to keep
        command = f"lawn-sb3 reproduce {recipe_path.as_posix()}"
        _publish(build_report(recipe, finished, command), runs / "report")
        shutil.copytree(runs / "report", folder / "report", dirs_exist_ok=True)
        return
    files = ABLATION_FILES if recipe.is_ablation else (*RESULT_FILES, WEIGHTS_FILE)
    written = export_runs(finished, runs, folder, files)  # refuses before anything is replaced
    written += export_checks(finished, folder)
    command = f"lawn-sb3 report {recipe_path.as_posix()} --runs {folder.as_posix()}"
    _publish(build_report(recipe, cells(recipe, folder), command), folder / "report")
    say(f"{written / 1e6:.1f} MB of runs in {folder}")


def _reference(recipe_path: Path, recipe: Recipe) -> Path:
    return recipe_path.parent / "reference" / recipe.name


def _publish(report: "Report", folder: Path) -> None:
    """Write a report and show its main table."""
    from lawn_sb3.report.document import write_report

    write_report(report, folder)
    if report.main in report.tables:
        print_table(report.tables[report.main].shown, f"{report.title}: {report.main_title}")
    for text in report.summary:
        say(text)
    for problem in report.problems:
        say(f"not in the report: {problem}", "yellow")
    say(f"report: {folder / 'README.md'}")


def _compare(recipe: Recipe, runs: Path, reference: Path) -> None:
    """Hold new runs against the reference, where there is one."""
    if not reference.is_dir():
        say("no reference results to compare with")
        return

    from lawn_sb3.report.against_reference import against_reference
    from lawn_sb3.results.results import read_results

    table = against_reference(*(read_results(recipe, cells(recipe, folder), ()) for folder in (runs, reference)))
    if table.shown.empty:
        say(f"the reference results in {reference} are of other methods or settings: nothing to compare with")
        return
    table.save(runs / "report", "against_reference")
    print_table(table.shown, f"This run against the reference results in {reference}")


@app.command()
def tune(
    search_path: Annotated[Path, typer.Argument(help="what to search")] = Path("runs/tuning.yaml"),
    jobs: Jobs = None,
    backend: BackendName = "local",
    address: Address = None,
    show: Annotated[bool, typer.Option("--show", help="run nothing, only show the trials so far")] = False,
) -> None:
    """Search for settings: as many trials for every method, on seeds apart from the reported ones."""
    workers = find_backend(backend, jobs, address)
    search, methods = load_search(search_path)
    file = search_path.with_suffix(".csv")

    from lawn_sb3.experiment.tuning import ranked_settings, read_trainings, run_search

    with interruptible():
        if not show:
            run_search(search, methods, file, workers, messages)
    table = Table(
        title=f"mean greedy reward J after {search.env_steps:,} env steps; * is the first or last value offered"
    )
    for heading in ("method", "rank", "seeds", "J", "settings"):
        table.add_column(heading)
    for method, rank, seeds, reward, at_edge, settings in ranked_settings(search, file).itertuples(index=False):
        shown = ", ".join(f"{key} {value}{'*' if key in at_edge else ''}" for key, value in settings.items())
        table.add_row(method, str(rank), str(seeds), f"{reward:.3f}", shown)
    wide_console().print(table)
    spent = read_trainings(file).groupby("method")["cpu_seconds"].sum()
    say("CPU minutes: " + ", ".join(f"{method} {seconds / 60:.0f}" for method, seconds in spent.items()))
