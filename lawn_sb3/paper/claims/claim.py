"""What a claim is, and where claims come from.

A rule that serves one claim stands right below it: ``@claim(...)`` over a function makes the claim. A rule that serves
several is marked ``@shared_rule``, and its claims stand in ``claims.yaml`` with the rule's arguments.
"""

import importlib
import pkgutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeVar, get_args

import yaml
from pydantic import BaseModel, ConfigDict

from lawn_sb3.paper.claims.evidence import Evidence

Verdict = Literal[
    "reproduced",
    "partly",
    "contradicted",
    "not shown",
    "impossible as printed",
    "fitted",
    "by construction",
    "not testable",
]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
MEANINGS: dict[Verdict, str] = {
    "reproduced": "the data show it",
    "partly": "some of its conditions hold",
    "contradicted": "the data, or the paper's own equations, show the contrary",
    "not shown": "these data cannot tell",
    "impossible as printed": "what the paper prints contradicts itself",
    "fitted": "nothing speaks against the figures, by which the game's constants were chosen",
    "by construction": "it holds in every run of the game as it is defined",
    "not testable": "runs are missing",
}
"""What each verdict says."""
Condition = Literal["holds", "fails", "open"]
"""What the data say of a condition; open: they cannot tell."""
CLAIMS_FILE = Path(__file__).with_name("claims.yaml")


class Finding(NamedTuple):
    """What the rule of a claim found."""

    verdict: Verdict
    figure: str
    """What was measured, with its interval."""
    why: str
    """One sentence."""


Rule = Callable[[Evidence], Finding]
AnyRule = TypeVar("AnyRule", bound=Callable[..., Finding])


class Claim(BaseModel):
    """One checkable statement of the paper.

    :param id: short name
    :param place: where it stands in tables: the paper's section in hundreds (results from 500 on), tens in its order
    :param section: where the paper says it
    :param text: what it says, in its words or close to them
    :param measure: what is measured, and what makes the verdict
    :param rule: judges it
    :param headline: whether it is one of those that carry the paper
    :param owed_to: why it holds, where no run could have shown otherwise: then the verdict is this in place of
        ``reproduced``
    :param needs: the recipe in ``runs/`` whose methods it takes and in whose report it is judged, if not the paper's
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    id: str
    place: int
    section: str
    text: str
    measure: str
    rule: Rule
    headline: bool = False
    owed_to: Literal["by construction"] | None = None
    needs: Literal["ablation", "ladder"] | None = None


class Judged(NamedTuple):
    """A claim and what was found."""

    claim: Claim
    finding: Finding


SHARED_RULES: dict[str, Callable[..., Finding]] = {}
"""Rules that ``claims.yaml`` may name."""
_IN_PYTHON: list[Claim] = []


def claim(**fields: Any) -> Callable[[Rule], Rule]:
    """Make the function below the rule of a claim, which is named for it: ``time_ratio`` judges ``time-ratio``.

    :param fields: all other fields of the claim
    :return: the decorator
    """

    def add(rule: Rule) -> Rule:
        _IN_PYTHON.append(Claim(id=rule.__name__.replace("_", "-"), rule=rule, **fields))
        return rule

    return add


def shared_rule(rule: AnyRule) -> AnyRule:
    """Let ``claims.yaml`` name this rule; the arguments after the evidence stand there too."""
    SHARED_RULES[rule.__name__] = rule
    return rule


def load_claims(path: Path = CLAIMS_FILE) -> list[Claim]:
    """All claims, from the modules of this folder and from a YAML file.

    :param path: a list of claims with ``rule`` and ``arguments``
    :return: the claims by their place
    """
    for module in pkgutil.iter_modules([str(Path(__file__).parent)]):
        importlib.import_module(f"{__package__}.{module.name}")
    in_yaml = [_with_shared_rule(**values) for values in yaml.safe_load(path.read_text("utf-8"))]
    return sorted([*_IN_PYTHON, *in_yaml], key=lambda claim: claim.place)


def _with_shared_rule(rule: str, arguments: dict[str, Any], **fields: Any) -> Claim:
    return Claim(rule=partial(SHARED_RULES[rule], **arguments), **fields)
