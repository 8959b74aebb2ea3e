"""One HTML file out of its parts: a body, data, styles and scripts, and a rule that nothing is fetched."""

import json
from collections.abc import Iterable
from html import escape
from importlib.resources import files
from typing import Any

FROM_PAGE = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self' data: blob:"
"""What the browser may load: what is in the page, and pictures beside it."""


def own(name: str) -> str:
    """A style, script or body that comes with the kit, by its file's name."""
    return (files("lawn_sb3.report.web") / "files" / name).read_text(encoding="utf-8")


def as_page(title: str, body: str, styles: Iterable[str], scripts: Iterable[str], data: dict[str, Any] | None) -> str:
    """Put a page together.

    :param title: its title, as text
    :param body: HTML
    :param styles: CSS, one after the other
    :param scripts: JavaScript, one after the other, below the body
    :param data: what scripts find in the element ``data``, as JSON
    :return: the page
    """
    head = [
        '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        '<meta name="color-scheme" content="light dark">',
        f'<meta http-equiv="Content-Security-Policy" content="{FROM_PAGE}">',
        '<link rel="icon" href="data:,">',
        f"<title>{escape(title)}</title>",
        *(f"<style>\n{style}</style>" for style in styles),
    ]
    below = [f"<script>\n{script}</script>" for script in scripts]
    if data is not None:
        # A text in it cannot end the element: JSON may write any sign by its number.
        text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
        below.insert(0, f'<script type="application/json" id="data">{text}</script>')
    parts = ["<!DOCTYPE html>", '<html lang="en">', "<head>", *head, "</head>", "<body>", body, *below, "</body>"]
    return "\n".join([*parts, "</html>", ""])
