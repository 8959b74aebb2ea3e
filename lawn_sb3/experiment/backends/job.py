"""What there is to do, how it is told about, and what a backend is: it is handed all jobs and says how they go."""

from collections.abc import Callable, Generator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

Progress = Callable[[int], None]
"""Called with the env steps done so far."""


class Job(NamedTuple):
    """Something to do in another process."""

    title: str
    """What messages call it."""
    work: Callable[[Progress], Any]
    """What does it: a function of a module, with its arguments."""
    log: Path | None = None
    """Where it leaves what it printed: in the folder of its results."""
    gpus: int = 0
    """How many GPUs are to be set aside for it, where machines are shared out."""


class Progressed(NamedTuple):
    """A job has come this far."""

    job: int
    """Which of the jobs, from 0; the same in all that follows."""
    env_steps: int


class Noted(NamedTuple):
    """Something about a job that the user should know."""

    job: int
    text: str


class Finished(NamedTuple):
    """A job is done."""

    job: int
    value: Any
    """What it returned."""


class Failed(NamedTuple):
    """A job is given up."""

    job: int
    reason: str


Event = Progressed | Noted | Finished | Failed
EVENTS: Mapping[str, type[Event]] = {
    "progressed": Progressed, "noted": Noted, "finished": Finished, "failed": Failed,
}  # fmt: skip
"""By the words with which a process tells of them."""


class Backend(Protocol):
    """Whoever does the jobs."""

    def run(self, jobs: Sequence[Job]) -> Generator[Event, None, None]:
        """Do all jobs, side by side.

        A job whose process ends without an answer is done once more before it is given up; one whose machine ends, on
        another. Closing the generator ends what is running.

        :param jobs: what to do
        :return: what happens, as it happens; every job ends as finished or failed
        """
