"""Running all cells of a recipe side by side, one torch thread each, with progress; what is finished is kept."""

import multiprocessing
import os
import queue
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
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

from lawn_sb3.errors import FailedRunsError, said
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.run_directory.configuration import is_finished

MOST_NAMED = 3
"""Failed runs that the last message names; each was named when it failed."""
QUIET_SECONDS = 30.0
"""How often progress is printed where no bar can be drawn."""


def run_cells(cells: Sequence[Cell], jobs: int, console: Console) -> None:
    """Run the cells that are not finished yet.

    :param cells: the cells
    :param jobs: how many run at a time
    :param console: where progress goes
    :raises KeyboardInterrupt: when interrupted; finished runs and checkpoints stay
    :raises FailedRunsError: if some runs failed, once all the others are done
    """
    todo = [cell for cell in cells if not is_finished(cell)]
    if len(todo) < len(cells):
        console.print(f"{len(cells) - len(todo)} of {len(cells)} runs are finished already and are kept")
    if not todo:
        return
    context = multiprocessing.get_context("spawn")
    # Numba and BLAS read their number of threads when a process starts.
    os.environ.update({"OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"})
    with context.Manager() as manager, _bars(console) as bars:
        events: queue.Queue[tuple[int, int]] = manager.Queue()
        pool = ProcessPoolExecutor(min(jobs, len(todo)), mp_context=context, initializer=prepare_worker)
        try:
            # Workers inherit this and so leave interrupts to their parent from their first moment on.
            before = signal.signal(signal.SIGINT, signal.SIG_IGN)
            futures = {pool.submit(_work, index, cell, events): index for index, cell in enumerate(todo)}
            signal.signal(signal.SIGINT, before)
            failures = _follow(todo, futures, events, bars, console)
            pool.shutdown()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in multiprocessing.active_children():
                process.terminate()
            raise
    if failures:
        more = f"; and {len(failures) - MOST_NAMED} more" if len(failures) > MOST_NAMED else ""
        raise FailedRunsError(f"{len(failures)} of {len(todo)} runs failed: {'; '.join(failures[:MOST_NAMED])}{more}")


def prepare_worker() -> None:
    """Make a worker process leave interrupts to its parent and use one torch thread."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what an interrupt ends
    _use_one_thread()


def _use_one_thread() -> None:
    import torch as th  # here, as the command line imports this module before it knows whether there is work

    th.set_num_threads(1)


def _work(index: int, cell: Cell, events: queue.Queue[tuple[int, int]]) -> None:
    from lawn_sb3.experiment.train import run_cell

    run_cell(cell, lambda env_steps: events.put((index, env_steps)))


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
    todo: Sequence[Cell],
    futures: dict[Future[None], int],
    events: queue.Queue[tuple[int, int]],
    bars: Progress,
    console: Console,
) -> list[str]:
    """Draw what the workers report until all are done; return what went wrong in which cell."""
    failures: list[str] = []
    total = bars.add_task(f"all {len(todo)} runs", total=sum(cell.method.env_steps for cell in todo))
    tasks: dict[int, Any] = {}
    done_steps = dict.fromkeys(range(len(todo)), 0)
    pending = set(futures)
    last_line = bars.get_time()
    while pending:
        finished, pending = wait(pending, timeout=0.2, return_when=FIRST_COMPLETED)
        for index, env_steps in _drain(events):
            cell = todo[index]
            if index not in tasks:
                tasks[index] = bars.add_task(cell.title, total=cell.method.env_steps, completed=env_steps)
            done_steps[index] = min(env_steps, cell.method.env_steps)
            bars.update(tasks[index], completed=done_steps[index])
        for future in finished:
            index = futures[future]
            cell = todo[index]
            done_steps[index] = cell.method.env_steps
            if index in tasks:
                bars.remove_task(tasks.pop(index))
            error = future.exception()
            if error is None:
                console.print(f"finished {cell.title}", markup=False)
            else:
                failures.append(f"{cell.title}: {said(error)}")
                console.print(f"failed {failures[-1]}", style="red", markup=False, soft_wrap=True)
        bars.update(total, completed=sum(done_steps.values()))
        if not console.is_terminal and bars.get_time() - last_line > QUIET_SECONDS:
            last_line = bars.get_time()
            console.print(_line(bars, total, len(todo) - len(pending), len(todo)))
    return failures


def _line(bars: Progress, total: Any, runs_done: int, runs: int) -> str:
    task = next(task for task in bars.tasks if task.id == total)
    left = (
        f"about {task.time_remaining / 60:.0f} min left"
        if task.time_remaining is not None
        else "time left not known yet"
    )
    return f"{runs_done} of {runs} runs, {task.completed:,.0f} of {task.total or 0:,.0f} env steps, {left}"


def _drain(events: queue.Queue[tuple[int, int]]) -> list[tuple[int, int]]:
    """All reports that are waiting, the newest of each cell."""
    newest: dict[int, int] = {}
    while True:
        try:
            index, env_steps = events.get_nowait()
        except queue.Empty:
            return list(newest.items())
        newest[index] = env_steps


@contextmanager
def training_bar(cell: Cell, console: Console, hidden: bool = False) -> Iterator[Callable[[int], None]]:
    """Show one training's progress.

    :param cell: what is being trained
    :param console: where the bar goes
    :param hidden: show nothing
    :return: a function to call with the env steps done so far
    """
    _use_one_thread()
    with _bars(console, hidden) as bars:
        task = bars.add_task(cell.title, total=cell.method.env_steps)
        yield lambda env_steps: bars.update(task, completed=min(env_steps, cell.method.env_steps))
