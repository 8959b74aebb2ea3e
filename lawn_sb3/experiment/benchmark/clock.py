"""Timing: what is compared is measured in turn, in one process, so that a busy machine slows both."""

import math
import multiprocessing
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from lawn_sb3.experiment.plan_episodes import Advance

ROUNDS = 10
"""Parts of a measurement that has none by itself."""


def calls_per_second(
    jobs: Sequence[Callable[[], object]], seconds: float, advance: Advance, what: str, rounds: int = ROUNDS
) -> list[float]:
    """How often each of several jobs can be done in a second: the best of some rounds, in which each has its turn.

    :param jobs: what to time; each is called once before, to compile and to warm up
    :param seconds: for all rounds of one job
    :param advance: told after each round
    :param what: what is being measured
    :param rounds: how many
    :return: calls a second, in the order of the jobs
    """
    for job in jobs:
        job()
    best = [0.0] * len(jobs)
    for _ in range(rounds):
        for k, job in enumerate(jobs):
            calls, began = 0, time.perf_counter()
            while (passed := time.perf_counter() - began) < seconds / rounds or not calls:
                job()
                calls += 1
            best[k] = max(best[k], calls / passed)
        advance(what, rounds)
    return best


def exponent(sizes: Sequence[float], costs: Sequence[float]) -> float:
    """The exponent p of the power law cost ~ size^p that fits best, by least squares of the logarithms.

    >>> round(exponent([1, 10, 100], [3, 30, 300]), 6)
    1.0
    """
    return float(np.polyfit(np.log(sizes), np.log(costs), 1)[0])


def peak_memory_mb(job: Callable[[], object]) -> float:
    """The most memory that a process of its own takes for a job.

    :param job: a function of a module
    :return: peak resident memory in MB, that of Python and the libraries included; not a number where there is no /proc
    """
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(_resident_after, (job,))


def _resident_after(job: Callable[[], object]) -> float:
    job()
    return peak_of_this_process_mb()


def peak_of_this_process_mb() -> float:
    """The most memory that this process has taken so far in MB; not a number where there is no /proc."""
    # Not getrusage, whose peak a process takes over from the one that started it.
    status = Path("/proc/self/status")
    lines = status.read_text(encoding="utf-8").splitlines() if status.exists() else []
    return next((float(line.split()[1]) / 1024.0 for line in lines if line.startswith("VmHWM:")), math.nan)
