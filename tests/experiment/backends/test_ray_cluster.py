"""Jobs on a Ray cluster of two nodes of this machine: they go on when a node ends, to the same bytes.

``make test-cluster`` installs Ray beside the other packages, and runs them.
"""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import yaml

ray = pytest.importorskip("ray", reason="Ray is not installed: make test-cluster runs what needs it")

from ray.cluster_utils import Cluster  # noqa: E402

from lawn_sb3.errors import UserError  # noqa: E402
from lawn_sb3.experiment.backends import ray_cluster  # noqa: E402
from lawn_sb3.experiment.backends.choice import find_backend  # noqa: E402
from lawn_sb3.experiment.backends.job import Event, Failed, Finished, Job, Noted, Progressed  # noqa: E402
from lawn_sb3.experiment.backends.ray_cluster import RayBackend  # noqa: E402
from lawn_sb3.experiment.provenance import versions  # noqa: E402
from lawn_sb3.experiment.registry import REPOSITORY  # noqa: E402
from tests.experiment.backends.test_local import alive, answer, die, die_once, refuse, wait_until  # noqa: E402
from tests.torture.kills import check_resumed, compare, have_checkpoints  # noqa: E402

pytestmark = pytest.mark.cluster
Report = Callable[[int], None]


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """One node with one core; tests add others."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RAY_USAGE_STATS_ENABLED", "0")
        made = Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
        yield made
        ray.shutdown()
        made.shutdown()


@pytest.fixture
def second(cluster: Any) -> Iterator[Any]:
    """A second node, with one core too."""
    node = cluster.add_node(num_cpus=1)
    yield node
    if node in cluster.worker_nodes:
        cluster.remove_node(node)


def ended(backend: RayBackend, jobs: list[Job]) -> tuple[dict[str, Event], list[str]]:
    """How each job ended, and what was noted on the way."""
    ends: dict[str, Event] = {}
    notes: list[str] = []
    for event in backend.run(jobs):
        if isinstance(event, Noted):
            notes.append(event.text)
        elif not isinstance(event, Progressed):
            assert jobs[event.job].title not in ends
            ends[jobs[event.job].title] = event
    return ends, notes


def where(report: Report) -> tuple[str, list[str], str]:
    return os.getcwd(), sys.argv, os.environ["OMP_NUM_THREADS"]


def wait_for(path: Path, seen: Path, report: Report) -> str:
    """Leave a sign, and wait for another; leave one at the end too."""
    report(1)
    seen.mkdir(exist_ok=True)
    (seen / str(os.getpid())).touch()
    try:
        while not path.exists():
            time.sleep(0.05)
    finally:
        (seen / "ended").touch()
    return str(ray.get_runtime_context().get_node_id())


def test_jobs_end_as_they_do_on_this_machine(cluster: Any, tmp_path: Path) -> None:
    jobs: dict[str, Callable[[Report], object]] = {
        "dies": partial(die, signal.SIGKILL),
        "one": partial(answer, 1),
        "raises": refuse,
        "dies once": partial(die_once, tmp_path / "seen"),
        "where": where,
    }
    listed = [Job(title, work, tmp_path / title / "worker.log") for title, work in jobs.items()]
    ends, notes = ended(RayBackend(cluster.address), listed)
    assert ends == {
        "dies": Failed(0, "its process was ended, twice"),
        "one": Finished(1, 1),
        "raises": Failed(2, "ArithmeticError: no such number"),
        "dies once": Finished(3, "done"),
        "where": Finished(4, (os.getcwd(), sys.argv, "1")),
    }
    assert notes == ["its process was ended; it is done once more"] * 2
    assert not list(tmp_path.rglob("part-*"))


def test_a_job_whose_node_ends_is_done_on_another(cluster: Any, second: Any, tmp_path: Path) -> None:
    go, seen = tmp_path / "go", tmp_path / "seen"
    notes, values = [], []
    for event in RayBackend(cluster.address).run([Job(name, partial(wait_for, go, seen)) for name in "ab"]):
        if isinstance(event, Noted):
            notes.append(event.text)
            go.touch()
        elif isinstance(event, Finished):
            values.append(event.value)
        elif seen.exists() and len(list(seen.iterdir())) == 2 and second in cluster.worker_nodes:
            cluster.remove_node(second, allow_graceful=False)
    assert notes == ["its node ended; it is done once more"]
    assert values == [cluster.head_node.node_id] * 2


def test_who_stops_listening_ends_what_runs(cluster: Any, tmp_path: Path) -> None:
    go, seen = tmp_path / "go", tmp_path / "seen"
    jobs = [Job("slow", partial(wait_for, go, seen), tmp_path / "slow" / "worker.log"), Job("waits", refuse)]
    events = RayBackend(cluster.address).run(jobs)
    assert next(events) == Progressed(0, 1)
    wait_until(seen.exists)
    events.close()
    wait_until(lambda: (seen / "ended").exists() or not alive(seen))  # Ray may keep the process for other tasks
    assert not list(tmp_path.rglob("part-*"))


def test_a_folder_that_a_node_does_not_see_is_named(
    cluster: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ray_cluster, "_lay_token", lambda job: tmp_path / "elsewhere" / "part-1")
    ends, _ = ended(RayBackend(cluster.address), [Job("lost", partial(answer, 1), tmp_path / "worker.log")])
    assert isinstance(ends["lost"], Failed)
    assert f"does not see '{tmp_path}/elsewhere': all nodes have to share that folder" in ends["lost"].reason


def test_a_node_with_other_versions_is_named(cluster: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ray_cluster, "versions", lambda: {**versions(), "torch": "1.0"})
    ends, _ = ended(RayBackend(cluster.address), [Job("other", partial(answer, 1))])
    assert isinstance(ends["other"], Failed)
    assert "this command 1.0: results could differ" in ends["other"].reason


def test_a_job_that_no_node_has_room_for_says_what_it_waits_for(cluster: Any) -> None:
    events = RayBackend(cluster.address).run([Job("big", partial(answer, 1), gpus=1)])
    assert next(events) == Noted(0, "waits for a GPU and a core: no node of the cluster has that now")
    events.close()


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("127.0.0.1:1", "no Ray cluster answers at '127.0.0.1:1': "),
        ("nowhere.invalid:6379", "no Ray cluster answers at 'nowhere.invalid:6379': "),
        ("nonsense", "no Ray cluster answers at 'nonsense': "),
    ],
)
def test_an_address_where_nothing_answers_is_refused_at_once(address: str, said: str) -> None:
    with pytest.raises(UserError) as refusal:
        find_backend("ray", None, address)
    assert str(refusal.value).startswith(said)
    assert "\n" not in str(refusal.value)


METHODS = {
    "mappo": {
        "label": "MAPPO", "algo": "mappo", "env_steps": 24_000, "num_games": 8,
        "settings": {"n_steps": 32, "batch_size": 256, "n_epochs": 2},
    },
}  # fmt: skip


def begin(recipe: Path, *options: str) -> "subprocess.Popen[str]":
    """Start a recipe in its folder, with nothing but its name."""
    (recipe.parent / "policies").mkdir(exist_ok=True)
    command = [sys.executable, "-m", "lawn_sb3", "reproduce", recipe.name, *options]
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY), "OMP_NUM_THREADS": "1"}
    pipes: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    return subprocess.Popen(command, cwd=recipe.parent, env=environment, text=True, process_group=0, **pipes)


@pytest.fixture
def recipe(tmp_path: Path) -> Path:
    """Two trainings with a policy of one's own, in a folder with a space in its name."""
    folder = tmp_path / "on a cluster"
    (folder / "policies").mkdir(parents=True)
    shipped = (REPOSITORY / "policies" / "local_critic.py").read_text(encoding="utf-8")
    (folder / "policies" / "mine.py").write_text(f"{shipped}\n# mine\n", encoding="utf-8")
    methods = {"mine": {**METHODS["mappo"], "policy": "mine"}}
    evaluation = {"episodes": 5, "record_every": 1_000, "watch_every": 20_000, "watch_episodes": 3}
    content = {"seeds": [0, 1], "evaluation": evaluation, "methods": methods}
    for name in ("there", "here"):
        (folder / f"{name}.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    return folder / "there.yaml"


def test_runs_go_on_when_their_node_ends_and_leave_the_bytes_of_this_machine(
    cluster: Any, second: Any, recipe: Path
) -> None:
    process, runs = begin(recipe, "--backend", "ray", "--address", cluster.address), recipe.with_suffix("")
    wait_until(lambda: len(have_checkpoints(list(runs.glob("*/seed-*")))) == 2 or process.poll() is not None, 600)
    cluster.remove_node(second, allow_graceful=False)
    out, err = process.communicate()
    assert process.returncode == 0, err
    assert "its node ended; it is done once more" in err
    assert "ray" not in (out + err).lower().replace("--backend ray", "")
    here = begin(recipe.with_name("here.yaml"))
    assert here.wait() == 0
    assert check_resumed(runs, set()) == 1
    compare(recipe.with_name("here"), runs)


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)])
def test_an_interrupt_ends_the_runs_on_the_cluster(
    cluster: Any, recipe: Path, number: signal.Signals, status: int
) -> None:
    process, run = begin(recipe, "--backend", "ray", "--address", cluster.address), recipe.with_suffix("") / "mine"
    lock = run / "seed-0" / "lock"
    wait_until(lambda: (lock.exists() and lock.read_text() != "") or process.poll() is not None, 300)
    holder = yaml.safe_load(lock.read_text())
    process.send_signal(number)
    _, err = process.communicate()
    assert process.returncode == status, err
    wait_until(lambda: not Path("/proc", str(holder["pid"]), "cmdline").exists() or not lock.exists())
    if number != signal.SIGKILL:
        assert err.splitlines()[-1] == (
            "lawn-sb3: interrupted; finished runs and checkpoints are kept, the same command goes on from there"
        )
        assert not list(recipe.parent.rglob("part-*"))
