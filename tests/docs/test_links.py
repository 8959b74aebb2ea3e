"""The README is short, and whatever the pages link to or name is there."""

import re

import pytest
import yaml
from pydantic import BaseModel

from lawn_sb3.experiment.recipe import Evaluation, Method, Recipe, Scaling
from lawn_sb3.experiment.registry import ALGORITHMS, REPOSITORY
from lawn_sb3.scenario import Scenario
from tests.docs.pages import PAGES, blocks, prose

NOT_THERE = re.compile(r"/(NAME|RECIPE|nearest|positions|mine|ablation/nearest)\b")
"""Files that a reader is to write, and what comes of them."""


def anchors(path: str) -> set[str]:
    """The anchors that a forge, and MyST, give the headings of a page."""
    text = re.sub(r"^```.*?^```$", "", (REPOSITORY / path).read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
    headings = re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


def test_the_readme_is_short() -> None:
    assert len(PAGES["README.md"].splitlines()) <= 200
    assert len(PAGES["README.md"].encode()) <= 10 * 1024


@pytest.mark.parametrize("page", PAGES)
def test_every_link_leads_somewhere(page: str) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if link.startswith("http"):
            continue
        path, _, anchor = link.partition("#")
        target = (REPOSITORY / page).parent / path if path else REPOSITORY / page
        assert target.is_file(), link
        assert not anchor or anchor in anchors(target.resolve().relative_to(REPOSITORY).as_posix()), link


@pytest.mark.parametrize("page", PAGES)
def test_every_file_that_a_page_names_is_there(page: str) -> None:
    named = re.findall(r"`((?:lawn_sb3|policies|runs|tests|docs)/[\w/.-]*)`", PAGES[page])
    assert [path for path in named if not NOT_THERE.search(path) and not (REPOSITORY / path).exists()] == []
    for paths in re.findall(r"`(lawn_sb3/(?:\w+/)*)\w+\.py`((?:, `\w+\.py`)+)", PAGES[page]):
        folder, others = paths  # lawn_sb3/game/airspace.py, radio.py
        for name in re.findall(r"\w+\.py", others):
            assert (REPOSITORY / folder / name).exists(), folder + name


def test_every_page_is_in_the_index_for_readers_of_plain_markdown_and_for_sphinx() -> None:
    trees = "".join(blocks("docs/index.md", "{toctree}")).split()
    for page in PAGES:
        if page.startswith("docs/") and page != "docs/index.md":
            name = page.removeprefix("docs/").removesuffix(".md")
            assert f"({name}.md)" in PAGES["docs/index.md"]
            assert name in trees


@pytest.mark.parametrize("model", [Scenario, Recipe, Method, Evaluation, Scaling])
def test_every_key_of_a_scenario_and_of_a_recipe_is_explained(model: type) -> None:
    page = PAGES["docs/scenarios-and-recipes.md"]
    assert [key for key in model.model_fields if f"`{key}`" not in page] == []  # type: ignore[attr-defined]


@pytest.mark.parametrize("model", [Recipe, Method, Evaluation])
def test_the_defaults_of_a_recipe_are_those_that_the_page_names(model: type[BaseModel]) -> None:
    rows = [line.strip("|").split("|") for line in PAGES["docs/scenarios-and-recipes.md"].splitlines()]
    named = {row[0].strip(" `"): row[-1].strip() for row in rows if len(row) == 3}
    for key, field in model.model_fields.items():
        if field.is_required():
            assert named[key] in ("must be given", "the file's name")
        elif isinstance(field.default, str | int) and field.default not in (0, "") and key != "continuation":
            assert yaml.safe_load(named[key].strip("`")) == field.default
    own = [f"`{algorithm.default_policy}`" for algorithm in ALGORITHMS.values()]
    assert all(policy in named["policy"] for policy in own)


def test_no_placeholder_is_left() -> None:
    assert not re.findall(r"\b(TODO|FIXME|XXX)\b", " ".join(PAGES.values()))
