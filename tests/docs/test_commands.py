"""Every command and make target that the pages name exists, with the options that they use; nothing is run."""

import re
import shlex
from pathlib import Path

import pytest
import typer.main
import yaml

from lawn_sb3.cli.commands import app
from lawn_sb3.experiment.recipe import load_recipe
from lawn_sb3.experiment.registry import PLAYERS, REPOSITORY
from tests.docs.pages import PAGES, blocks, prose

PARSER = typer.main.get_command(app)
COMMANDS = PARSER.commands  # type: ignore[attr-defined]
TARGETS = set(re.findall(r"^([a-z]+):", (REPOSITORY / "Makefile").read_text("utf-8"), flags=re.MULTILINE))
STANDS_FOR = {"K": "0"}
"""What is written for a number."""


def commands(page: str) -> list[str]:
    """What follows ``lawn-sb3`` in a page's code blocks and inline code."""
    lines = "".join(blocks(page, "")).splitlines()
    code = [line for line in lines if re.match(r"(\.venv/bin/)?lawn-sb3 ", line)]
    code += re.findall(r"`((?:\.venv/bin/)?lawn-sb3 [^`]+)`", prose(page))
    return [re.sub(r"\s*[>#].*", "", line).split("lawn-sb3 ", 1)[1] for line in code]


def used_targets(page: str) -> list[str]:
    code = "".join(blocks(page, "")) + " ".join(re.findall(r"`(make [^`]+)`", prose(page)))
    return re.findall(r"\bmake (?:[A-Z]+=\S+ )?([a-z]+)", code)


@pytest.mark.parametrize("page", PAGES)
def test_every_command_that_a_page_names_is_understood(page: str) -> None:
    for text in commands(page):
        name, *arguments = (STANDS_FOR.get(word, word) for word in shlex.split(text))
        assert name in COMMANDS, text
        if not arguments:
            continue  # the command's name alone, in a sentence
        parsed = COMMANDS[name].make_context(name, arguments).params
        if str(parsed.get("player")).islower():
            assert parsed["player"] in PLAYERS, text
        recipe = parsed.get("recipe_path")
        if recipe is not None and recipe.stem not in ("mine", "NAME"):
            methods = load_recipe(REPOSITORY / recipe).methods
            assert (parsed.get("method") or "METHOD") in (*methods, "METHOD"), text


@pytest.mark.parametrize("page", PAGES)
def test_every_make_target_that_a_page_names_exists(page: str) -> None:
    assert set(used_targets(page)) <= TARGETS


def test_the_readme_and_the_page_of_commands_name_all_of_them() -> None:
    listed = {text.split()[0] for text in commands("docs/commands.md")}
    assert listed == set(COMMANDS)
    section = prose("README.md").partition("## Commands")[2].partition("## Limits")[0]
    assert set(COMMANDS) <= set(re.findall(r"[a-z]+", " ".join(re.findall(r"`([^`]+)`", section))))


def test_the_page_of_commands_names_every_target_that_make_help_lists() -> None:
    listed = set(re.findall(r"^([a-z]+):.*##", (REPOSITORY / "Makefile").read_text("utf-8"), flags=re.MULTILINE))
    assert listed - {"bench"} <= {*used_targets("docs/commands.md")}


def test_pre_commit_checks_what_make_lint_checks() -> None:
    (repository,) = yaml.safe_load((REPOSITORY / ".pre-commit-config.yaml").read_text("utf-8"))["repos"]
    makefile = (REPOSITORY / "Makefile").read_text("utf-8")
    (parts,) = re.findall(r"^lint: ([a-z ]+) ##", makefile, flags=re.MULTILINE)
    assert [hook["entry"] for hook in repository["hooks"]] == [f"make {part}" for part in parts.split()]


def test_ci_runs_the_oldest_python_that_is_allowed_and_the_newest_that_contributors_are_told() -> None:
    workflow = yaml.safe_load((REPOSITORY / ".github" / "workflows" / "ci.yml").read_text("utf-8"))
    oldest, newest = workflow["jobs"]["ci"]["strategy"]["matrix"]["python"]
    assert f"python_requires = >={oldest}" in (REPOSITORY / "setup.cfg").read_text("utf-8")
    assert f"The oldest supported Python is {oldest}, the newest that CI runs on is {newest}." in prose(
        "CONTRIBUTING.md"
    )
    assert "make lint\nmake docs\nmake test\n" in (Path(REPOSITORY) / ".ci" / "run").read_text("utf-8")
