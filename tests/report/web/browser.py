"""A headless browser for the tests of pages; where there is none they are skipped, and say what to install."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
MISSING = "no browser: install playwright by pip, and chromium by apt-get or by playwright install"
AS_ROOT = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
"""Pages of our own alone are opened; where there is no graphics card, WebGL is worked out by the processor."""

PATIENCE_MS = 300_000
"""A busy machine may take minutes to draw in space without a graphics card."""


@contextmanager
def opened_browser() -> Iterator[Any]:
    api = pytest.importorskip("playwright.sync_api", reason=MISSING)
    installed = next((path for name in NAMES if (path := shutil.which(name))), None)
    with api.sync_playwright() as playwright:
        chromium = playwright.chromium
        if installed is None and not Path(chromium.executable_path).exists():
            pytest.skip(MISSING)
        browser = chromium.launch(executable_path=installed, args=list(AS_ROOT))
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def opened_page(browser: Any, path: Path, width: int = 1200, scheme: str = "light") -> Iterator[Any]:
    """Open a page; it may neither say an error nor ask for anything but itself and what lies beside it."""
    wrong: list[str] = []

    def told(message: Any) -> None:
        if message.type == "error":
            wrong.append(message.text)

    def asked(request: Any) -> None:
        beside = path.parent.as_uri() + "/"
        if not request.url.startswith((beside, "data:", f"blob:{beside}", "blob:null")):
            wrong.append(f"asked for {request.url}")

    page = browser.new_page(viewport={"width": width, "height": 700}, color_scheme=scheme)
    page.set_default_timeout(PATIENCE_MS)
    page.on("console", told)
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("request", asked)
    page.on("requestfailed", lambda request: wrong.append(f"failed: {request.url}"))
    try:
        page.goto(path.as_uri())
        yield page
        assert wrong == []
    finally:
        page.close()
