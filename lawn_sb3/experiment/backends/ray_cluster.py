"""Jobs on the machines of a Ray cluster, which all see the folder that the command runs in.

Each job is a task with a core of its own. Its results and checkpoints go to the shared folder, so that it goes on from
there when its process or its node ends: Ray itself tries nothing again.
"""

import os
import secrets
import signal
import socket
import sys
import warnings
from collections import Counter, defaultdict, deque
from collections.abc import Generator, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import ray
from ray import exceptions
from ray._private import worker as of_driver
from ray.util.queue import Queue
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

from lawn_sb3.errors import UserError, first_line
from lawn_sb3.experiment.backends.job import EVENTS, Event, Failed, Job, Noted
from lawn_sb3.experiment.backends.worker import ONE_THREAD, answer, tell_notices
from lawn_sb3.experiment.provenance import versions
from lawn_sb3.experiment.run_directory import writer

SECONDS_TO_ANSWER = 5.0
"""How long a cluster may take to answer at all."""
SECONDS_TO_END = 1.5
"""How long tasks that were asked to end may take before they are made to."""
SECONDS_BETWEEN_LOOKS = 0.2
ADDRESS = "RAY_ADDRESS"
AUTHENTICATION = "RAY_AUTH_MODE"
"""Ray's own variables of the environment. A token is only handed to a named address if the user says so."""


class Origin(NamedTuple):
    """What a task has to have in common with the command that it is part of."""

    folder: Path
    """The folder that it runs in: paths are relative to it, and policies are sought there."""
    argv: list[str]
    """The command, for the provenance of runs."""
    versions: dict[str, str]


class RayBackend:
    """Does jobs as tasks of a Ray cluster.

    :param address: where the cluster is; by default what ``RAY_ADDRESS`` says, or one that runs on this machine
    :param side_by_side: how many at a time; by default as many as there is room for
    :raises UserError: if no cluster answers there
    """

    def __init__(self, address: str | None = None, side_by_side: int | None = None) -> None:
        self.side_by_side = side_by_side
        _connect(address or os.environ.get(ADDRESS) or "auto")

    def run(self, jobs: Sequence[Job]) -> Generator[Event, None, None]:
        """Do all jobs, as :class:`lawn_sb3.experiment.backends.job.Backend` says.

        One that no node has room for waits, as clusters may grow.
        """
        waiting, deaths = deque(range(len(jobs))), Counter[int]()
        begun: defaultdict[int, list[writer.Writer]] = defaultdict(list)
        running: dict[Any, int] = {}
        origin = Origin(Path.cwd(), sys.argv, versions())
        here = NodeAffinitySchedulingStrategy(ray.get_runtime_context().get_node_id(), soft=False)
        news = Queue(actor_options={"num_cpus": 0, "scheduling_strategy": here})
        tokens: dict[int, Path | None] = {}
        try:
            for job, need in [(job, _lacking(one)) for job, one in enumerate(jobs)]:
                if need:
                    yield Noted(job, f"waits for {need}: no node of the cluster has that now")
                    break  # the others wait for much the same
            while waiting or running:
                while waiting and len(running) < (self.side_by_side or len(jobs)):
                    job = waiting.popleft()
                    tokens[job] = _lay_token(jobs[job])
                    task = ray.remote(_do).options(
                        name=jobs[job].title,
                        num_cpus=1,
                        num_gpus=jobs[job].gpus,
                        max_retries=0,
                        runtime_env={"env_vars": ONE_THREAD},
                    )
                    running[task.remote(job, jobs[job].work, tokens[job], begun[job], origin, news)] = job
                ended, _ = ray.wait(list(running), num_returns=len(running), timeout=SECONDS_BETWEEN_LOOKS)
                for job, kind, value in _told(news):
                    if kind == "begun":
                        begun[job].append(value)
                    else:
                        yield EVENTS[kind](job, value)
                for reference in ended:
                    job = running.pop(reference)
                    try:
                        kind, value = ray.get(reference)
                    except exceptions.RayError as error:
                        lost_node = isinstance(error, exceptions.NodeDiedError | exceptions.LocalRayletDiedError)
                        deaths[job] += not lost_node
                        how = _how_it_ended(error)
                        if deaths[job] > 1:
                            yield Failed(job, f"{how}, twice")
                            continue
                        waiting.append(job)
                        need = _lacking(jobs[job])
                        yield Noted(job, f"{how}; it is done once more{f', once a node has {need}' if need else ''}")
                    else:
                        yield EVENTS[kind](job, value)
        finally:
            _end(list(running))
            for token in filter(None, tokens.values()):
                token.unlink(missing_ok=True)
            news.shutdown(force=True)


def _connect(address: str) -> None:
    """Join a cluster, unless this process has done so already."""
    host, _, port = address.rpartition("://")[2].rpartition(":")
    heeded = signal.getsignal(signal.SIGTERM)
    try:
        if address != "auto":  # Ray itself would try for minutes
            socket.create_connection((host, int(port)), timeout=SECONDS_TO_ANSWER).close()
        of_driver._worker_logs_enabled = False  # what dying nodes say would go to standard output
        ray.init(address=address, ignore_reinit_error=True, log_to_driver=False, logging_level="CRITICAL")
    except (OSError, RuntimeError, ValueError, ImportError, exceptions.RayError) as error:
        if address == "auto":
            raise UserError(
                "no Ray cluster runs on this machine: start one, ray start --head, or name its --address"
            ) from None
        hint = "" if AUTHENTICATION in os.environ else f"; one that asks for a token wants {AUTHENTICATION}=token set"
        raise UserError(f"no Ray cluster answers at {address!r}: {first_line(error)}{hint}") from None
    finally:
        signal.signal(signal.SIGTERM, heeded)  # Ray has put its own in its place


def _lacking(job: Job) -> str | None:
    """What no node has that is there now, of all that a job needs at once."""
    alive = [node["Resources"] for node in ray.nodes() if node["Alive"]]
    if job.gpus and not any(node.get("GPU", 0) >= job.gpus and node.get("CPU", 0) >= 1 for node in alive):
        return "a GPU and a core" if job.gpus == 1 else f"{job.gpus} GPUs and a core"
    return None if any(node.get("CPU", 0) >= 1 for node in alive) else "a core"


def _lay_token(job: Job) -> Path | None:
    """Leave a file where a job's results go; its task takes it away, or finds that the folder is not shared."""
    if job.log is None:
        return None
    token = job.log.parent / f"part-{secrets.token_hex(8)}"
    token.parent.mkdir(parents=True, exist_ok=True)
    token.touch()
    return token


def _told(news: Queue) -> Iterator[tuple[int, str, Any]]:
    """What tasks have told since the last look."""
    if waiting := news.qsize():
        yield from news.get_nowait_batch(waiting)


def _how_it_ended(error: exceptions.RayError) -> str:
    if isinstance(error, exceptions.NodeDiedError | exceptions.LocalRayletDiedError):
        return "its node ended"
    if isinstance(error, exceptions.OutOfMemoryError):
        return "its process was ended, as its node had no memory left"
    if isinstance(error, exceptions.WorkerCrashedError):
        return "its process was ended"
    return f"Ray could not do it: {str(error).strip().splitlines()[-1]}"  # after where that was


def _end(tasks: Sequence[Any]) -> None:
    """End tasks: asked to at first, so that they leave nothing half written."""
    for force in (False, True):
        for task in tasks:
            ray.cancel(task, force=force)
        if tasks:
            _, tasks = ray.wait(list(tasks), num_returns=len(tasks), timeout=SECONDS_TO_END)


def _do(
    job: int, work: Any, token: Path | None, ended: Sequence[writer.Writer], origin: Origin, news: Queue
) -> tuple[str, Any]:
    """Do a job, in a process of a node.

    :param job: which one
    :param work: what does it
    :param token: the file that shows whether this node sees the folder of its results; none if it has none
    :param ended: the processes that began it before, and are not there any more
    :param origin: the command that it is part of
    :param news: takes what it tells: ``(job, "progressed", env_steps)`` and ``(job, "noted", text)``, and at first
        ``(job, "begun", writer)``
    :return: ``("finished", value)`` or ``("failed", reason)``
    """
    host = socket.gethostname()
    try:
        os.chdir(origin.folder)
        if token is not None:
            token.unlink()
    except OSError:
        folder = token.parent if token is not None else origin.folder
        return "failed", f"{host} does not see {str(origin.folder / folder)!r}: all nodes have to share that folder"
    if others := {name: own for name, own in versions().items() if own != origin.versions[name]}:
        name, own = next(iter(others.items()))
        return "failed", f"{host} has {name} {own}, this command {origin.versions[name]}: results could differ"
    sys.argv = origin.argv
    writer.ENDED.update(ended)
    news.put((job, "begun", writer.Writer.here()))
    with warnings.catch_warnings():
        tell_notices(lambda text: news.put((job, "noted", text)))
        return answer(work, lambda env_steps: news.put((job, "progressed", env_steps)))
