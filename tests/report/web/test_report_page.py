"""The report as a page has all that the Markdown has; its tables sort, its claims filter, its figures are enlarged."""

import re
from html import unescape
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from lawn_sb3.experiment.cell import cells
from lawn_sb3.experiment.recipe import load_recipe
from lawn_sb3.report.contents import build_report
from lawn_sb3.report.document import write_report
from lawn_sb3.report.web.report_page import MOST_COLUMNS, narrowed
from tests.report.web.browser import opened_page

VISIBLE = "() => [...document.querySelectorAll('.claims > details')].filter((c) => !c.hidden).length"
COLUMN = "() => [...document.querySelector('table.sorts').tBodies[0].rows].map((row) => row.cells[1].textContent)"


@pytest.fixture(scope="session")
def folder(finished_runs: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report as it is written."""
    recipe = load_recipe(finished_runs / "planned.yaml")
    report = build_report(recipe, cells(recipe, finished_runs / "small"), "lawn-sb3 report <b>")
    made = tmp_path_factory.mktemp("report")
    write_report(report, made)
    return made


def test_wide_tables_go_on_below_with_what_names_their_rows() -> None:
    shown = pd.DataFrame({"a": ["x", "x"], "b": ["1", "2"], **{f"c{k}": ["u", "v"] for k in range(14)}})
    parts = list(narrowed(shown))
    assert all(len(part.columns) <= MOST_COLUMNS and list(part.columns[:2]) == ["a", "b"] for part in parts)
    assert [name for part in parts for name in part.columns[2:]] == list(shown.columns[2:])
    assert next(narrowed(shown[["a", "b"]])).equals(shown[["a", "b"]])


def test_every_cell_and_caption_of_the_markdown_is_on_the_page(folder: Path) -> None:
    page = (folder / "index.html").read_text("utf-8")
    text = " ".join(unescape(re.sub(r"<[^>]+>", " ", page)).split())
    tables = [path for path in folder.glob("*.md") if path.stem not in ("README", "claims_headlines", "claims_summary")]
    assert len(tables) > 8
    for path in tables:
        if path.stem == "claims":
            continue  # its columns are lines there
        for line in path.read_text("utf-8").splitlines():
            for cell in re.split(r"(?<!\\)\|", line.strip("|")):
                shown = cell.strip().replace("\\|", "|").replace("`", "")
                assert set(shown) <= set(":-") or shown in text, (path.name, shown)
    for claim in pd.read_csv(folder / "claims.csv").fillna("").to_dict("records"):
        for part in ("verdict", "claim", "measure", "figure", "why"):
            assert " ".join(claim[part].replace("`", "").split()) in text, claim["id"]
    assert "lawn-sb3 report <b>" in text  # as text, not as a tag
    assert len(page) < 1_000_000


def test_tables_sort_claims_filter_and_figures_are_enlarged(browser: Any, folder: Path) -> None:
    claims = pd.read_csv(folder / "claims.csv")
    with opened_page(browser, folder / "index.html", 390, "dark") as page:
        as_written = page.evaluate(COLUMN)
        head = page.locator("table.sorts").first.locator("th button").nth(1)
        orders = []
        for order in ("ascending", "descending", None):
            head.click()
            assert page.locator("table.sorts").first.locator("th").nth(1).get_attribute("aria-sort") == order
            orders.append(page.evaluate(COLUMN))
        values = [float(text.split()[0]) for text in as_written]
        assert [float(text.split()[0]) for text in orders[0]] == sorted(values)
        assert [float(text.split()[0]) for text in orders[1]] == sorted(values, reverse=True)
        assert orders[2] == as_written
        assert page.evaluate(VISIBLE) == len(claims)
        for verdict, count in claims["verdict"].value_counts().items():
            page.click(f".filters [data-verdict='{verdict}']")
            assert page.evaluate(VISIBLE) == count
        page.click(".filters [data-verdict='']")
        first = page.locator(".claims > details").first
        assert not first.locator("dl").is_visible()
        first.locator("summary").click()
        assert first.locator("dl").is_visible()
        page.locator("button.zoom").first.click()
        assert page.locator("#zoom img").get_attribute("src").endswith(".png")
        page.keyboard.press("Escape")
        assert not page.locator("#zoom").is_visible()
        wide, screen = page.evaluate("() => [document.scrollingElement.scrollWidth, window.innerWidth]")
        assert wide <= screen


def test_the_replay_of_a_report_shows_the_paths_that_its_runs_hold(folder: Path, finished_runs: Path) -> None:
    page = (folder / "replay.html").read_text("utf-8")
    assert 'href="replay.html"' in (folder / "index.html").read_text("utf-8")
    assert '"title":"CTDE-MAPPO, seed 0"' in page
    assert '"title":"Bound' not in page  # its UAVs never meet
