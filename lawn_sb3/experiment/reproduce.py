"""Running all cells of a recipe side by side, one torch thread each, with progress; what is finished is kept."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from lawn_sb3.errors import FailedRunsError
from lawn_sb3.experiment.backends.job import Backend, Event, Failed, Job, Noted, Progressed
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.run_directory.configuration import is_finished
from lawn_sb3.experiment.run_directory.files import LOG_FILE

MOST_NAMED = 3
"""Failed runs that the last message names; each was named when it failed."""
QUIET_SECONDS = 30.0
"""How often progress is printed where no bar can be drawn."""


def run_cells(cells: Sequence[Cell], backend: Backend, console: Console) -> None:
    """Run the cells that are not finished yet.

    :param cells: the cells
    :param backend: who runs them
    :param console: where progress goes
    :raises KeyboardInterrupt: when interrupted; finished runs and checkpoints stay
    :raises FailedRunsError: if some runs failed, once all the others are done
    """
    todo = [cell for cell in cells if not is_finished(cell)]
    if len(todo) < len(cells):
        console.print(f"{len(cells) - len(todo)} of {len(cells)} runs are finished already and are kept")
    if not todo:
        return
    jobs = [
        Job(cell.title, partial(_run, cell, log := cell.directory / LOG_FILE), log, cell.method.gpus) for cell in todo
    ]
    with _bars(console) as bars, closing(backend.run(jobs)) as events:
        failures = _follow(todo, jobs, events, bars, console)
    if failures:
        more = f"; and {len(failures) - MOST_NAMED} more" if len(failures) > MOST_NAMED else ""
        raise FailedRunsError(f"{len(failures)} of {len(todo)} runs failed: {'; '.join(failures[:MOST_NAMED])}{more}")


def _run(cell: Cell, log: Path, progress: Callable[[int], None]) -> None:
    """Run a cell, in whatever process."""
    import torch as th  # here, as the command line imports this module before it knows whether there is work

    from lawn_sb3.experiment.train import run_cell

    th.set_num_threads(1)
    run_cell(cell, progress, log)


def _bars(console: Console, hidden: bool = False) -> Progress:
    return Progress(
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("env steps"),
        TimeElapsedColumn(),
        TextColumn("left:"),
        TimeRemainingColumn(),
        console=console,
        speed_estimate_period=120,
        disable=hidden,
    )


def _follow(
    todo: Sequence[Cell], jobs: Sequence[Job], events: Iterator[Event], bars: Progress, console: Console
) -> list[str]:
    """Draw what is told of the cells until all are done; return what went wrong in which."""
    failures: list[str] = []
    total = bars.add_task(f"all {len(todo)} runs", total=sum(cell.method.env_steps for cell in todo))
    tasks: dict[int, Any] = {}
    done_steps = dict.fromkeys(range(len(todo)), 0)
    runs_done, last_line = 0, bars.get_time()
    for event in events:
        index, cell = event.job, todo[event.job]
        if isinstance(event, Progressed):
            if index not in tasks:
                tasks[index] = bars.add_task(cell.title, total=cell.method.env_steps, completed=event.env_steps)
            done_steps[index] = min(event.env_steps, cell.method.env_steps)
            bars.update(tasks[index], completed=done_steps[index])
        elif isinstance(event, Noted):
            console.print(f"{cell.title}: {event.text}", style="yellow", markup=False, soft_wrap=True)
        else:
            runs_done += 1
            done_steps[index] = cell.method.env_steps
            if index in tasks:
                bars.remove_task(tasks.pop(index))
            if isinstance(event, Failed):
                log = jobs[index].log
                where = f"; log: {log}" if log is not None and log.exists() else ""
                failures.append(f"{cell.title}: {event.reason}{where}")
                console.print(f"failed {failures[-1]}", style="red", markup=False, soft_wrap=True)
            else:
                console.print(f"finished {cell.title}", markup=False)
        bars.update(total, completed=sum(done_steps.values()))
        if not console.is_terminal and bars.get_time() - last_line > QUIET_SECONDS:
            last_line = bars.get_time()
            console.print(progress_line(bars, total, runs_done, len(todo)))
    return failures


def progress_line(bars: Progress, total: Any, runs_done: int, runs: int) -> str:
    """How far all runs have come, where no bar can be drawn.

    :param bars: the bars
    :param total: the one of all runs, by its id
    :param runs_done: runs that have ended
    :param runs: how many there are
    :return: one line
    """
    task = next(task for task in bars.tasks if task.id == total)
    if task.finished:
        left = "all trained, what is left is flying"
    elif task.time_remaining is None:
        left = "time left not known yet"
    else:
        left = f"about {task.time_remaining / 60:.0f} min left"
    return f"{runs_done} of {runs} runs, {task.completed:,.0f} of {task.total or 0:,.0f} env steps, {left}"


@contextmanager
def training_bar(cell: Cell, console: Console, hidden: bool = False) -> Iterator[Callable[[int], None]]:
    """Show one training's progress.

    :param cell: what is being trained
    :param console: where the bar goes
    :param hidden: show nothing
    :return: a function to call with the env steps done so far
    """
    import torch as th  # here, as the command line imports this module before it knows whether there is work

    th.set_num_threads(1)
    with _bars(console, hidden) as bars:
        task = bars.add_task(cell.title, total=cell.method.env_steps)
        yield lambda env_steps: bars.update(task, completed=min(env_steps, cell.method.env_steps))
