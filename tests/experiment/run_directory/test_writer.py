"""One writer at a time in a run's directory, and nothing left of one that was ended."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from lawn_sb3.errors import HeldError
from lawn_sb3.experiment.registry import REPOSITORY
from lawn_sb3.experiment.run_directory import writer
from lawn_sb3.experiment.run_directory.writer import Writer, only_writer

HOLD = (
    "import sys; from pathlib import Path; from lawn_sb3.experiment.run_directory.writer import only_writer\n"
    "with only_writer(Path(sys.argv[1])): print('held', flush=True); sys.stdin.read()\n"
)


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(writer, "PATIENCE_SECONDS", 0.1)
    return tmp_path / "run"


def other_writer(run: Path) -> subprocess.Popen[str]:
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY)}
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    other = subprocess.Popen([sys.executable, "-c", HOLD, run], env=environment, text=True, **pipes)  # type: ignore[call-overload]
    assert other.stdout.readline() == "held\n"
    return other  # type: ignore[no-any-return]


def test_the_second_writer_is_told_who_holds_it_and_touches_nothing(run: Path) -> None:
    other = other_writer(run)
    (run / "part-model.zip").write_text("half")
    with pytest.raises(HeldError, match=rf"process {other.pid} on .* since 20") as refusal, only_writer(run):
        pytest.fail("came in")
    assert "\n" not in str(refusal.value)
    assert {path.name for path in run.iterdir()} == {"lock", "part-model.zip"}
    other.communicate()
    assert not (run / "lock").exists()


def test_what_a_writer_left_that_was_killed_is_taken_over(run: Path) -> None:
    other = other_writer(run)
    (run / "part-model.zip").write_text("half")
    other.kill()
    other.communicate()
    assert (run / "lock").exists()
    with only_writer(run):
        assert not (run / "part-model.zip").exists()
    assert not list(run.iterdir())


def test_a_file_system_without_locks_gets_a_file_that_is_one(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: object) -> bool:
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr("filelock._unix.lock_fd_nonblocking", missing)
    with only_writer(run):
        assert (run / "lock").exists()
        with pytest.raises(HeldError, match="being written by"), only_writer(run):
            pytest.fail("came in")
    assert not list(run.iterdir())


def test_a_writer_who_is_known_to_have_ended_loses_its_lock_and_no_other(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writer, "LEASE_SECONDS", 0.1)
    other = other_writer(run)  # as the server of a file system may have it of a machine that is gone
    monkeypatch.setattr(writer, "ENDED", {Writer(Writer.here().host, other.pid + 1), Writer("elsewhere", other.pid)})
    with pytest.raises(HeldError), only_writer(run):
        pytest.fail("came in")
    monkeypatch.setattr(writer, "ENDED", {Writer(Writer.here().host, other.pid)})
    with only_writer(run):
        assert f'"pid": {os.getpid()}' in (run / "lock").read_text()
    other.communicate()
    assert not list(run.iterdir())


def test_so_does_one_that_had_a_file_for_a_lock(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: object) -> bool:
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr("filelock._unix.lock_fd_nonblocking", missing)
    monkeypatch.setattr(writer, "LEASE_SECONDS", 0.1)
    run.mkdir()
    (run / "lock").write_text("12\nelsewhere?pidns-1f\n")
    with pytest.raises(HeldError, match="process 12 on elsewhere: wait"), only_writer(run):
        pytest.fail("came in")
    monkeypatch.setattr(writer, "ENDED", {Writer("elsewhere", 12)})
    with only_writer(run):
        assert str(os.getpid()) in (run / "lock").read_text()
    assert not list(run.iterdir())
