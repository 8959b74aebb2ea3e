"""The paper's equations are cited by number and label where they are computed; examples in docstrings are true."""

import doctest
import importlib
import re
from pathlib import Path

import pytest

import lawn_sb3

PACKAGE = Path(lawn_sb3.__file__).parent
MODULES = sorted(
    (".".join(("lawn_sb3", *path.relative_to(PACKAGE).with_suffix("").parts)), text.count(">>> "))
    for path in PACKAGE.rglob("*.py")
    if ">>> " in (text := path.read_text(encoding="utf-8"))
)

# Label by number, as the paper's reader sees it: Eq. (6) is the game itself, Eq. (19) the advantage; neither has one.
LABELS = (
    *("rb", "rate", "mobility", "collision", "deadline", "", "ema", "tmin", "utility", "welfare", "global_state"),
    *("obs", "action_space", "reward", "reward_rate", "reward_nav", "reward_col", "terminal", "", "gae", "ppo_clip"),
    "critic_loss",
)
ROOMS = ("game", "envs", "planning", "algos")
NUMBERS = {label: number for number, label in enumerate(LABELS, start=1) if label}


@pytest.mark.parametrize(("name", "examples"), MODULES)
def test_examples_in_docstrings_are_true(name: str, examples: int) -> None:
    result = doctest.testmod(importlib.import_module(name))
    assert (result.attempted, result.failed) == (examples, 0)


def numbers_missing(text: str, cited: set[str]) -> list[str]:
    """The labels that stand without their number, whatever the line breaks; adds all to those cited."""
    found = re.findall(r"(.{0,10})\beq:(\w+)", " ".join(text.split()))
    cited |= {label for _, label in found}
    return [label for before, label in found if not before.endswith(f"Eq. ({NUMBERS[label]}), ")]


def test_every_equation_of_the_game_is_cited_with_its_number() -> None:
    cited: set[str] = set()
    for path in [
        PACKAGE / "scenario.py",
        PACKAGE / "choices.py",
        *(path for room in ROOMS for path in (PACKAGE / room).rglob("*.py")),
    ]:
        assert numbers_missing(path.read_text(encoding="utf-8"), cited) == [], path.name
    assert cited == set(NUMBERS)


def test_docstrings_about_the_paper_cite_the_numbers_too() -> None:
    for path in (path for room in ("paper", "report", "results") for path in (PACKAGE / room).rglob("*.py")):
        for docstring in re.findall(r'"""(?:[^"]|"(?!""))*"""', path.read_text(encoding="utf-8")):
            assert numbers_missing(docstring, set()) == [], path.name


def test_no_number_stands_beside_another_equation_s_label() -> None:
    for path in PACKAGE.rglob("*.py"):
        for number, label in re.findall(r"Eq\. \((\d+)\),\s+eq:(\w+)", path.read_text(encoding="utf-8")):
            assert int(number) == NUMBERS[label], f"{path.name}: eq:{label}"
