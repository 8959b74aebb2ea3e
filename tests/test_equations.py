"""The paper's equations are cited by number and label where they are computed; examples in docstrings are true."""

from __future__ import annotations

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
NUMBERS = {label: number for number, label in enumerate(LABELS, start=1) if label}


@pytest.mark.parametrize(("name", "examples"), MODULES)
def test_examples_in_docstrings_are_true(name: str, examples: int) -> None:
    result = doctest.testmod(importlib.import_module(name))
    assert (result.attempted, result.failed) == (examples, 0)


def test_every_equation_is_cited_with_its_number() -> None:
    cited: set[str] = set()
    for folder in ("game", "envs", "planning"):
        for path in (PACKAGE / folder).rglob("*.py"):
            for before, label in re.findall(r"(.{0,10})\beq:(\w+)", path.read_text(encoding="utf-8"), re.DOTALL):
                assert re.search(rf"Eq\. \({NUMBERS[label]}\),\s+$", before), f"{path.name}: eq:{label}"
                cited.add(label)
    learning = {"gae", "ppo_clip", "critic_loss"}
    assert cited == set(NUMBERS) - learning
