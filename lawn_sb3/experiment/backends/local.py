"""Jobs on this machine: some processes side by side, each of which may end without harm to the others' jobs."""

import multiprocessing
import os
import signal
import time
from collections import Counter, deque
from collections.abc import Generator, Sequence
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import NamedTuple

from lawn_sb3.experiment.backends.job import EVENTS, Event, Failed, Job, Noted
from lawn_sb3.experiment.backends.worker import ONE_THREAD, serve

SECONDS_TO_END = 1.5
"""How long processes that were asked to end may take before they are made to."""


class Worker(NamedTuple):
    """A process and the pipe to it."""

    process: BaseProcess
    pipe: Connection


class LocalBackend:
    """Does jobs in processes of this machine.

    :param side_by_side: how many at a time
    """

    def __init__(self, side_by_side: int) -> None:
        self.side_by_side = side_by_side

    def run(self, jobs: Sequence[Job]) -> Generator[Event, None, None]:
        """Do all jobs, as :class:`lawn_sb3.experiment.backends.job.Backend` says."""
        waiting, deaths = deque(range(len(jobs))), Counter[int]()
        idle: list[Worker] = []
        busy: dict[Connection, tuple[Worker, int]] = {}
        try:
            while waiting or busy:
                while waiting and len(busy) < self.side_by_side:
                    worker, job = idle.pop() if idle else _start(), waiting.popleft()
                    busy[worker.pipe] = worker, job
                    _hand(worker, jobs[job])
                for pipe in wait(list(busy)):
                    assert isinstance(pipe, Connection)
                    worker, job = busy[pipe]
                    try:
                        kind, value = pipe.recv()
                    except (EOFError, OSError):  # it has ended without an answer
                        del busy[pipe]
                        how = _how_it_ended(worker)
                        deaths[job] += 1
                        if deaths[job] > 1:
                            yield Failed(job, f"{how}, twice")
                        else:
                            waiting.appendleft(job)
                            yield Noted(job, f"{how}; it is done once more")
                        continue
                    if kind in ("finished", "failed"):
                        del busy[pipe]
                        idle.append(worker)
                    yield EVENTS[kind](job, value)
        finally:
            _end([*idle, *(worker for worker, _ in busy.values())])


def _start() -> Worker:
    """Start a process that waits for jobs."""
    os.environ.update(ONE_THREAD)
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    process = context.Process(target=serve, args=(there,), daemon=True)
    resource_tracker.ensure_running()  # which would unblock the interrupts
    # What is blocked here is blocked there, from its first moment on: interrupts are left to this process.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        process.start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    there.close()
    return Worker(process, here)


def _hand(worker: Worker, job: Job) -> None:
    """Give a process a job; one that has ended meanwhile is found out by whoever waits for its answer."""
    try:
        worker.pipe.send(job.work)
    except OSError:
        worker.process.kill()


def _how_it_ended(worker: Worker) -> str:
    worker.process.join(SECONDS_TO_END)
    worker.pipe.close()
    code = worker.process.exitcode
    if code is not None and code < 0:
        return f"its process was ended by {signal.Signals(-code).name}"
    return f"its process ended with status {code}"


def _end(workers: Sequence[Worker]) -> None:
    """End processes: asked to at first, so that they leave nothing half written."""
    for worker in workers:
        worker.process.terminate()
    deadline = time.monotonic() + SECONDS_TO_END
    for worker in workers:
        worker.process.join(max(deadline - time.monotonic(), 0.0))
        worker.process.kill()
        worker.process.join()
        worker.pipe.close()
