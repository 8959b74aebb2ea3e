"""Processes that do jobs: each ends alone, is followed by another, and none outlives who started it."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from lawn_sb3.experiment.backends.job import Event, Failed, Finished, Job, Noted, Progressed
from lawn_sb3.experiment.backends.local import LocalBackend
from lawn_sb3.experiment.registry import REPOSITORY

Report = Callable[[int], None]


def answer(value: int, report: Report) -> int:
    report(value)
    return value


def refuse(report: Report) -> None:
    raise ArithmeticError("no such number")


def die(number: int, report: Report) -> None:
    os.kill(os.getpid(), number)
    time.sleep(60)


def die_once(seen: Path, report: Report) -> str:
    if not seen.exists():
        seen.touch()
        os._exit(3)
    return "done"


def sleep(pids: Path, report: Report) -> None:
    (pids / str(os.getpid())).touch()
    time.sleep(600)


def ended(jobs: dict[str, Callable[[Report], object]], side_by_side: int = 2) -> tuple[dict[str, Event], list[str]]:
    """How each job ended, and what was noted on the way."""
    names, notes = list(jobs), list[str]()
    ends: dict[str, Event] = {}
    for event in LocalBackend(side_by_side).run([Job(name, work) for name, work in jobs.items()]):
        if isinstance(event, Noted):
            notes.append(event.text)
        elif not isinstance(event, Progressed):
            assert names[event.job] not in ends
            ends[names[event.job]] = event
    return ends, notes


def test_a_failing_or_dying_job_leaves_the_others_alone(tmp_path: Path) -> None:
    ends, notes = ended({
        "dies": partial(die, signal.SIGKILL),
        "one": partial(answer, 1),
        "raises": refuse,
        "dies once": partial(die_once, tmp_path / "seen"),
        "two": partial(answer, 2),
    })  # fmt: skip
    assert ends == {
        "dies": Failed(0, "its process was ended by SIGKILL, twice"),
        "one": Finished(1, 1),
        "raises": Failed(2, "ArithmeticError: no such number"),
        "dies once": Finished(3, "done"),
        "two": Finished(4, 2),
    }
    again = "it is done once more"
    assert sorted(notes) == [f"its process ended with status 3; {again}", f"its process was ended by SIGKILL; {again}"]


def alive(pids: Path) -> list[str]:
    """Which of the processes that left their numbers there run."""
    stats = [Path("/proc", path.name, "stat") for path in pids.iterdir()]
    return [
        path.parent.name for path in stats if path.exists() and path.read_text().rpartition(")")[2].split()[0] != "Z"
    ]


def wait_until(holds: Callable[[], bool], seconds: int = 60) -> None:
    for _ in range(10 * seconds):
        if holds():
            return
        time.sleep(0.1)
    pytest.fail("has not come about")


@pytest.mark.skipif(sys.platform != "linux", reason="looks at /proc")
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_no_process_outlives_who_started_it(tmp_path: Path, number: signal.Signals) -> None:
    code = (
        "import sys; from functools import partial; from pathlib import Path\n"
        "from lawn_sb3.experiment.backends.job import Job\n"
        "from lawn_sb3.experiment.backends.local import LocalBackend\n"
        "from tests.experiment.backends.test_local import sleep\n"
        "if __name__ == '__main__':\n"
        "    list(LocalBackend(2).run([Job('', partial(sleep, Path(sys.argv[1]))) for _ in range(2)]))\n"
    )
    script, pids = tmp_path / "script.py", tmp_path / "pids"
    script.write_text(code)
    pids.mkdir()
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    parent = subprocess.Popen([sys.executable, script, pids], env=environment)
    wait_until(lambda: len(list(pids.iterdir())) == 2)
    assert len(alive(pids)) == 2
    parent.send_signal(number)
    parent.wait()
    wait_until(lambda: not alive(pids))


def test_who_stops_listening_ends_what_runs(tmp_path: Path) -> None:
    events = LocalBackend(1).run([Job("quick", partial(answer, 1)), Job("slow", partial(sleep, tmp_path))])
    assert next(events).job == 0
    events.close()
    assert not alive(tmp_path)
