"""The page of a replay shows what was flown, to the digit of the raw rows, and needs nothing else than itself."""

import json
import re
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from lawn_sb3.report.space import OFFSET_VOXELS
from tests.cli.running import exit_status
from tests.report.web.browser import opened_page

EPISODES, SHOWN = 5, [0, 3]
PLAYERS = ["random", "shortest-path"]
GAME = ["--set", "max_slots=9", "--episodes", str(EPISODES), "--seed", "11"]
UAVS = "() => document.querySelector('.scene').data.find((trace) => trace.name === 'UAVs')"


@pytest.fixture(scope="session")
def replay(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A page of two players, and the rows that evaluate gives of the same."""
    folder = tmp_path_factory.mktemp("replay")
    chosen = [part for number in SHOWN for part in ("--episode", str(number))]
    named = [part for name in PLAYERS for part in ("--player", name)]
    assert exit_status("replay", *named, *GAME, *chosen, "--out", folder / "page.html") == 0
    for name in PLAYERS:
        assert exit_status("evaluate", "--player", name, *GAME, "--rows", folder / f"{name}.csv") == 0
    return folder / "page.html"


def data_in(page: Path) -> dict[str, Any]:
    (text,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page.read_text("utf-8"))
    data: dict[str, Any] = json.loads(text)
    return data


def set_slot(page: Any, slot: int) -> None:
    page.evaluate(
        "(slot) => { const one = document.getElementById('slot'); one.value = slot;"
        " one.dispatchEvent(new Event('input')); }",
        slot,
    )


def table_in(page: Any) -> list[list[str]]:
    """The texts of the first method's table."""
    rows: list[list[str]] = page.evaluate(
        "() => [...document.querySelector('.method tbody').rows].map((row) => [...row.cells].map((c) => c.textContent))"
    )
    return rows


def test_all_numbers_of_the_page_are_those_of_the_raw_rows_of_evaluate(replay: Path) -> None:
    data = data_in(replay)
    assert [episode["number"] for episode in data["episodes"]] == SHOWN
    for name, method in zip(PLAYERS, data["methods"], strict=True):
        rows = pd.read_csv(replay.with_name(f"{name}.csv"))
        assert method["means"]["utility_mbps"] == pytest.approx(rows["utility_mbps"].mean(), rel=1e-8)
        for number, track in zip(SHOWN, method["tracks"], strict=True):
            own = rows[rows["episode"] == number]
            assert {column: own[column].tolist() for column in track["rows"]} == track["rows"]
            for uav, row in enumerate(own.to_dict("records")):
                assert track["ema"][row["slots"]][uav] == row["rate_mbps"]
                assert track["utility"][-1][uav] == row["utility_mbps"]


def test_a_text_in_the_data_cannot_end_the_script(tmp_path: Path) -> None:
    run = tmp_path / "page.html"
    assert exit_status("replay", "--player", "random", *GAME, "--out", run) == 0
    assert run.read_text("utf-8").count("</script>") == 3  # data, Plotly and ours: no more than were opened
    assert "http-equiv" in run.read_text("utf-8")


@pytest.mark.parametrize(("width", "scheme"), [(1300, "light"), (390, "dark")])
def test_the_slider_moves_the_uavs_and_the_numbers_with_them(
    browser: Any, replay: Path, width: int, scheme: str
) -> None:
    data = data_in(replay)
    track, voxel = data["methods"][0]["tracks"][0], data["game"]["voxel"]
    aside = OFFSET_VOXELS * voxel
    with opened_page(browser, replay, width, scheme) as page:
        for slot in (0, 4, track["slots"]):
            set_slot(page, slot)
            uavs = page.evaluate(UAVS)
            for axis, name in enumerate("xyz"):
                centres = [(place[axis] + 0.5) * voxel for place in track["voxels"][slot]]
                assert uavs[name] == pytest.approx(centres, abs=aside + 1e-9)
            for uav, cells in enumerate(table_in(page)):
                assert cells[1] == ", ".join(map(str, track["voxels"][slot][uav]))
                for cell, values in zip(cells[4:7], (track["rate"], track["ema"], track["utility"]), strict=True):
                    value = values[slot][uav]
                    assert cell == ("–" if value is None else f"{value:.2f}")
            loads = page.evaluate("() => document.querySelector('.scene').data[0].intensity")
            assert {loads[2 * k] for k in range(100)} <= set(track["loads"][slot])
        wide, screen = page.evaluate("() => [document.scrollingElement.scrollWidth, window.innerWidth]")
        assert wide <= screen


def test_play_steps_keys_and_choices_do_what_they_say(browser: Any, replay: Path) -> None:
    def now() -> str:
        return str(page.text_content("#now"))

    data = data_in(replay)
    longest = max(method["tracks"][0]["slots"] for method in data["methods"])
    with opened_page(browser, replay) as page:
        assert page.locator(".method").count() == 2  # side by side where there is room
        assert now() == f"slot 0 of {longest}"
        page.click("#on")
        page.evaluate("() => document.activeElement.blur()")
        page.keyboard.press("ArrowRight")
        assert now() == f"slot 2 of {longest}"
        page.keyboard.press("ArrowLeft")
        assert now() == f"slot 1 of {longest}"
        page.keyboard.press("End")
        assert now() == f"slot {longest} of {longest}"
        page.select_option("#beside", "-1")
        assert page.locator(".method").count() == 1
        page.evaluate("() => document.activeElement.blur()")
        page.select_option("#speed", "10")
        page.keyboard.press(" ")  # from the end it begins anew
        assert page.text_content("#play") == "Pause"
        page.wait_for_function("() => document.getElementById('play').textContent === 'Play'")
        assert now() == f"slot {longest} of {longest}"
        page.select_option("#method", "1")
        page.select_option("#episode", "1")
        assert page.locator(".method h2").all_text_contents() == ["Shortest path"]
        short = data["methods"][1]["tracks"][1]
        assert now() == f"slot {short['slots']} of {short['slots']}"
        assert [row[7] for row in table_in(page)] == [f"arrived in slot {slots}" for slots in short["rows"]["slots"]]
        said = str(page.text_content("#said"))
        assert said.startswith("Shortest path: 0 of 4 UAVs fly on")
        assert page.get_attribute(".scene", "aria-label").endswith(said)
        assert page.get_attribute("#said", "aria-live") == "polite"
