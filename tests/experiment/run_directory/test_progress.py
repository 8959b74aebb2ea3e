"""What writes the training curve names its file where there is no room for it."""

import errno
import os
import threading
from pathlib import Path

import pytest
from stable_baselines3.common.logger import TensorBoardOutputFormat
from tensorboard.summary.writer.record_writer import RecordWriter

from lawn_sb3.experiment.run_directory.progress import STEPS, ProgressCSV, TensorBoardCurve

NOWHERE = Path("/dev/full")
"""Where there is never room."""


@pytest.mark.skipif(not NOWHERE.exists(), reason="this system has no such file")
def test_a_table_that_has_no_room_is_named(tmp_path: Path) -> None:
    with pytest.raises(OSError, match=r"No space left on device: '/dev/full'"):
        ProgressCSV(NOWHERE, "a\n1\n")
    table = ProgressCSV(tmp_path / "progress.csv")
    table.path = NOWHERE
    with pytest.raises(OSError, match=r"No space left on device: '/dev/full'"):
        table.write({STEPS: 1}, {})


def refuse(*arguments: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_an_event_file_that_has_no_room_is_named_and_its_thread_says_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(RecordWriter, "write", refuse)
    monkeypatch.setattr(threading, "excepthook", threading.__excepthook__)
    before = set(threading.enumerate())
    with pytest.raises(OSError, match=r"No space left on device: '.*tensorboard'"):
        TensorBoardCurve(tmp_path / "tensorboard").write({STEPS: 1, "a": 1.0}, {})
    for thread in set(threading.enumerate()) - before:
        thread.join(timeout=60.0)
    assert capfd.readouterr().err == ""


def test_an_event_file_that_cannot_be_closed_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    curve = TensorBoardCurve(tmp_path / "tensorboard")
    monkeypatch.setattr(TensorBoardOutputFormat, "close", refuse)
    with pytest.raises(OSError, match=r"No space left on device: '.*tensorboard'"):
        curve.close()


def test_other_threads_tell_what_they_end_by_to_whom_they_did_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[threading.ExceptHookArgs] = []
    monkeypatch.setattr(threading, "excepthook", told.append)
    for name in ("one", "two"):
        TensorBoardCurve(tmp_path / name).close()
    thread = threading.Thread(target=refuse)
    thread.start()
    thread.join()
    assert [failure.thread for failure in told] == [thread]
