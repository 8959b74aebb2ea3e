"""Outputs are there whole or not at all, under any name, and never in place of what is no file."""

import os
import stat
from pathlib import Path

import pytest

from lawn_sb3.whole_files import whole_file, write_text


@pytest.mark.parametrize(
    "name", ["rows.csv", "ein Name mit Ö und – Leerzeichen.csv", "行.csv", ".hidden", "-rows", "a'b\"c"]
)
def test_any_name_will_do(tmp_path: Path, name: str) -> None:
    write_text(tmp_path / name, "1\n")
    write_text(tmp_path / name, "2\n")
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "2\n"


def test_what_a_link_points_to_is_written_and_the_link_stays(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "link.csv").symlink_to(tmp_path / "folder" / "rows.csv")
    write_text(tmp_path / "link.csv", "1\n")
    assert (tmp_path / "link.csv").is_symlink()
    assert (tmp_path / "folder" / "rows.csv").read_text() == "1\n"


def test_what_is_no_file_is_never_replaced(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "folder")
    for name in ("pipe", "folder", "link"):
        with pytest.raises(OSError, match="something else than a file") as refusal:
            write_text(tmp_path / name, "1\n")
        assert refusal.value.filename == str(tmp_path / name)
    for device in (Path("/dev/null"), Path("/dev/full"), Path("/")):
        with pytest.raises(OSError, match="something else than a file"):
            write_text(device, "1\n")
    assert stat.S_ISFIFO((tmp_path / "pipe").stat().st_mode)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "link", "pipe"]


def test_a_folder_that_vanishes_is_named_and_nothing_is_left(tmp_path: Path) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()

    def write() -> None:
        with whole_file(folder / "rows.csv") as part:
            part.write_text("1\n")
            part.unlink()
            folder.rmdir()

    with pytest.raises(OSError, match="No such file") as refusal:
        write()
    assert refusal.value.filename == str(folder / "rows.csv")
    assert list(tmp_path.iterdir()) == []


def test_the_one_before_stays_when_writing_fails(tmp_path: Path) -> None:
    write_text(tmp_path / "rows.csv", "1\n")

    def write() -> None:
        with whole_file(tmp_path / "rows.csv") as part:
            part.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        write()
    assert (tmp_path / "rows.csv").read_text() == "1\n"
    assert len(list(tmp_path.iterdir())) == 1
