"""How Sphinx builds these pages: Markdown by MyST, the API from the docstrings; nothing is fetched."""

from __future__ import annotations

import importlib
import os
import re
import sys
from pathlib import Path
from typing import Any, TypeVar

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment

REPOSITORY = Path(__file__).parents[1]
sys.path.insert(0, str(REPOSITORY))

import lawn_sb3  # noqa: E402  # of this checkout

COPIED = {
    "readme": "README.md",
    "contributing": "CONTRIBUTING.md",
    "changelog": "CHANGELOG.md",
    "report-paper": "runs/reference/paper/report/README.md",
    "report-ladder": "runs/reference/ladder/report/README.md",
    "report-ablation": "runs/reference/ablation/report/README.md",
    "report-as-printed": "runs/reference/as_printed/report/README.md",
    "report-swarm": "runs/reference/swarm/report/README.md",
    "report-sensitivity": "runs/reference/sensitivity/report/README.md",
    "report-readings": "runs/reference/readings/report/README.md",
    "report-bfloat16": "runs/reference/bfloat16/report/README.md",
    "report-defaults": "runs/reference/defaults/report/README.md",
    "report-identify": "runs/reference/identify/README.md",
}
"""Markdown of the repository that becomes a page too, by the page's name under ``_made/``."""
PAGES = {path: f"_made/{name}.md" for name, path in COPIED.items()}

project = "lawn-sb3"
author = "the lawn-sb3 authors"
version = release = lawn_sb3.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.apidoc"]
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = f"lawn-sb3 {release}"
html_static_path = ["_static"]
html_css_files = ["wide.css"]
myst_heading_anchors = 4

nitpicky = True
nitpick_ignore_regex = [
    (r"py:.*", r"(?!lawn_sb3\.|policies\.).*"),  # names of other projects
    (r"py:.*", r".*\._\w+"),  # what annotations show of private names
]
autodoc_default_options = {"members": True, "show-inheritance": True, "ignore-module-all": True}
autodoc_mock_imports = ["ray"]  # an extra
autodoc_member_order = "bysource"
apidoc_modules = [
    {
        "path": str(REPOSITORY / package),
        "destination": f"_made/api/{package}",
        "max_depth": 2,
        "automodule_options": {"members", "show-inheritance"},
    }
    for package in ("lawn_sb3", "policies")
]
add_module_names = False
python_use_unqualified_type_names = True


def copy_pages(app: Sphinx) -> None:
    """Copy what ``COPIED`` names; a page that is up to date stays as it is, so that it need not be built again.

    :param app: the build
    """
    for path, page in PAGES.items():
        target, text = Path(app.srcdir) / page, (REPOSITORY / path).read_text(encoding="utf-8")
        target.parent.mkdir(exist_ok=True)
        if not target.exists() or target.read_text(encoding="utf-8") != text:
            target.write_text(text, encoding="utf-8")


def lead_links(app: Sphinx, docname: str, source: list[str]) -> None:
    """Lead links and pictures, which are right in the repository, to where they are for Sphinx.

    :param app: the build
    :param docname: the page
    :param source: its text, changed in place
    """
    here = Path(app.srcdir) / f"{docname}.md"
    origins = {page: path for path, page in PAGES.items()}
    folder = (REPOSITORY / origins.get(f"{docname}.md", f"docs/{docname}")).parent

    def led(link: re.Match[str]) -> str:
        target = Path(os.path.normpath(folder / link[1]))
        if not target.is_file():
            return link[0]
        path = target.relative_to(REPOSITORY)
        page = PAGES.get(path.as_posix())
        if page is None and path.suffix == ".md":
            page = PAGES.get((path.parent / "README.md").as_posix())  # one table of a report: the whole report
        return f"]({os.path.relpath(Path(app.srcdir) / page if page else target, here.parent)}"

    source[0] = re.sub(r"\]\(([^)#:\s]+)", led, source[0])


def find_elsewhere(app: Sphinx, env: BuildEnvironment, node: pending_xref, contnode: nodes.Element) -> Any:
    """Find what a docstring names by where it is imported from: it is documented where it is defined.

    :param app: the build
    :param env: its environment
    :param node: the reference that has no target
    :param contnode: what it shows
    :return: the reference with its target, if there is one
    """
    module, _, name = node.get("reftarget", "").rpartition(".")
    try:
        found = getattr(importlib.import_module(module), name)
    except (AttributeError, ImportError, ValueError):
        return None
    if isinstance(found, TypeVar):
        return contnode
    place = f"{getattr(found, '__module__', '')}.{name}"
    return env.domains.python_domain.resolve_xref(
        env, node["refdoc"], app.builder, node["reftype"], place, node, contnode
    )


def setup(app: Sphinx) -> None:
    """Called by Sphinx.

    :param app: the build
    """
    app.connect("builder-inited", copy_pages)
    app.connect("source-read", lead_links)
    app.connect("missing-reference", find_elsewhere)
