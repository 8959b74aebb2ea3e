"""The command that shows a scenario."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from lawn_sb3.cli.commands import app


@pytest.mark.parametrize(("columns", "explained"), [("80", False), ("140", True)])
def test_a_shown_scenario_fits_the_window_and_says_where_each_value_is_from(columns: str, explained: bool) -> None:
    shown = CliRunner().invoke(app, ["scenario", "as-printed", "--set", "num_uavs=8"], env={"COLUMNS": columns}).stdout
    assert max(map(len, shown.splitlines())) <= int(columns)
    rows = {line.split()[1]: line for line in shown.splitlines() if line.startswith("│")}
    assert "Delta_s" in rows["voxel_size_m"]
    sources = {"num_uavs": "yours", "width_voxels": "preset", "max_slots": "stated", "tx_power_dbm": "inferred"}
    assert all(source in rows[key] for key, source in sources.items())
    assert ("deadline" in shown) == explained


def test_no_grid_of_gbss_is_shown_where_their_positions_are_given(tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text("gbs_positions_m: [[25, 25, 0], [75, 75, 0]]\n")
    shown = CliRunner().invoke(app, ["scenario", str(mine)], env={"COLUMNS": "160"}).stdout
    (row,) = (line for line in shown.splitlines() if "gbs_grid" in line)
    assert "not used: gbs_positions_m" in row
    assert "2, 2" not in row


def test_a_scenario_is_drawn_where_asked(tmp_path: Path) -> None:
    for ending in (".png", ".pdf", ".svg"):
        file = tmp_path / f"mine{ending}"
        assert CliRunner().invoke(app, ["scenario", "tiny", "--picture", str(file)]).exit_code == 0
        assert file.stat().st_size > 1_000
    refused = CliRunner().invoke(app, ["scenario", "tiny", "--picture", "mine.docx"]).exception
    assert ".png, .pdf, .svg" in str(refused)
