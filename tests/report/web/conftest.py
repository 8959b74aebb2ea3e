"""One browser for all tests of pages."""

from collections.abc import Iterator
from typing import Any

import pytest

from tests.report.web.browser import opened_browser


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    with opened_browser() as opened:
        yield opened
