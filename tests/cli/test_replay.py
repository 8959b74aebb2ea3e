"""The command that shows flights, as a page, a film and a picture."""

from pathlib import Path

import pytest
from matplotlib.animation import FFMpegWriter
from PIL import Image, ImageChops

from tests.cli.running import Lawn

SHORT = ["--player", "shortest-path", "--episodes", "2", "--episode", "1"]


def test_a_film_shows_every_slot_and_its_last_one_longer(lawn: Lawn, tmp_path: Path) -> None:
    lawn("replay", *SHORT, "--out", tmp_path / "film.gif")
    lawn("evaluate", "--player", "shortest-path", "--episodes", 2, "--rows", tmp_path / "rows.csv")
    rows = [line.split(",") for line in (tmp_path / "rows.csv").read_text("utf-8").splitlines()[1:]]
    makespan = max(int(row[4]) for row in rows if row[0] == "1")
    with Image.open(tmp_path / "film.gif") as film:
        assert (
            getattr(film, "n_frames", 1) == makespan + 1
        )  # the start, too; frames that are the same are one that lasts
        first, lasts = film.convert("RGB"), film.info["duration"]
        film.seek(makespan)
        assert film.info["duration"] > lasts
        assert ImageChops.difference(first, film.convert("RGB")).getbbox() is not None


def test_equal_pictures_are_equal_bytes_and_slots_look_different(lawn: Lawn, tmp_path: Path) -> None:
    for name, slot in (("one", 1), ("again", 1), ("start", 0)):
        lawn("replay", *SHORT, "--player", "random", "--slot", slot, "--out", tmp_path / f"{name}.png")
    one, again, start = ((tmp_path / f"{name}.png").read_bytes() for name in ("one", "again", "start"))
    assert one == again
    assert one != start


def test_runs_fly_their_own_game_and_are_told_apart_by_their_seeds(lawn: Lawn, runs: Path, tmp_path: Path) -> None:
    named = [part for seed in (0, 1) for part in ("--run", runs / "small" / "mappo" / f"seed-{seed}")]
    lawn("replay", *named, "--episodes", 2, "--out", tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text("utf-8")
    assert all(f'"title":"CTDE-MAPPO, seed {seed}"' in page for seed in (0, 1))
    other = ["--scenario", "paper", "--set", "num_uavs=3", "--player", "random", "--episodes", 1]
    lawn("replay", *named, *other, "--out", tmp_path / "page.html")
    assert '"title":"paper, num_uavs=3"' in (tmp_path / "page.html").read_text("utf-8")


@pytest.mark.skipif(not FFMpegWriter.isAvailable(), reason="ffmpeg is not there")
def test_an_mp4_is_written_where_ffmpeg_is(lawn: Lawn, tmp_path: Path) -> None:
    lawn("replay", *SHORT, "--out", tmp_path / "film.mp4")
    assert (tmp_path / "film.mp4").read_bytes()[4:8] == b"ftyp"
    assert [path.name for path in tmp_path.iterdir()] == ["film.mp4"]


@pytest.mark.skipif(FFMpegWriter.isAvailable(), reason="ffmpeg is there")
def test_without_ffmpeg_an_mp4_is_refused_before_anything_flies(lawn: Lawn, tmp_path: Path) -> None:
    said = lawn("replay", *SHORT, "--out", tmp_path / "film.mp4", status=2)
    assert ".mp4 needs ffmpeg, which is not installed; .gif needs nothing" in said.err
