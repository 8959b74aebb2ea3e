"""Claims of the paper as data (``CLAIMS_FILES``), the evidence they are held to, and what a test of one finds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
import yaml
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Method
from lawn_sb3.results.results import Results

Verdict = Literal["reproduced", "partly", "not reproduced", "impossible as printed", "not testable"]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)

CLAIMS_FILES = tuple(Path(__file__).with_name(name) for name in ("premises.yaml", "claims.yaml"))
"""What the paper says of its model and method, and of its results."""

LADDER = {"algo": "mappo-episodes", "without_reward": ("rate", "nav", "col")}
"""What the learners of the ladder have in common."""
ROLES: dict[str, dict[str, Any]] = {
    "random": {"player": "random"},
    "straight": {"player": "shortest-path"},
    "alone": {"player": "best-route"},
    "welfare": {"player": "welfare"},
    "equilibrium": {"player": "equilibrium"},
    "iql": {"algo": "iql", "policy": "local_q"},
    "qmix": {"algo": "qmix", "policy": "monotonic_mixer"},
    "mappo": {"algo": "mappo", "policy": "state_critic"},
    "mappo-o": {"algo": "mappo", "policy": "centralized_critic"},
    "mappo-raw": {"algo": "mappo", "policy": "centralized_critic", "normalize_value": False},
    "mappo-separate": {"algo": "mappo", "policy": "separate_actors"},
    "ippo": {"algo": "mappo", "policy": "local_critic"},
    "blind": {"algo": "mappo", "policy": "congestion_blind"},
    "knows-nothing": {**LADDER, "policy": "knows_nothing"},
    "knows-loads": {**LADDER, "policy": "knows_clock"},
    "knows-destinations": {**LADDER, "policy": "knows_destinations"},
}
"""Parts that methods play in the claims. ``mappo`` is the paper's own, with the critic V(x) that it writes down;
``mappo-o`` is the same with V([o_i, x])."""

UNLESS_SET = {"share_parameters": False, "normalize_value": True, "without_reward": ()}
"""What tell parts apart, and the defaults: a method that changes one plays only a part that asks for it."""


class Claim(BaseModel):
    """One checkable statement of the paper.

    :param id: short name
    :param section: where the paper says it
    :param text: what it says, in its words or close to them
    :param measure: what is measured, and what makes the verdict
    :param test: name of the test
    :param arguments: the test's arguments
    :param headline: whether it is one of those that carry the paper
    :param needs: the recipe in ``runs/`` whose methods it takes and in whose report it is judged, if not the paper's
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    id: str
    section: str
    text: str
    measure: str
    test: str
    arguments: dict[str, Any] = Field(default_factory=dict)
    headline: bool = False
    needs: Literal["ablation", "ladder"] | None = None


class Finding(NamedTuple):
    """What the test of a claim found."""

    verdict: Verdict
    figure: str
    """What was measured, with its interval."""
    why: str
    """One sentence."""


class Judged(NamedTuple):
    """A claim and what was found."""

    claim: Claim
    finding: Finding


class CannotTellError(Exception):
    """The evidence a claim needs is not there; the message says what is missing."""


@dataclass
class Evidence:
    """What claims are held to.

    :param results: what the runs left
    :param cells: the recipe's cells, for claims about the trained models
    """

    results: Results
    cells: Sequence[Cell]

    @cached_property
    def roles(self) -> dict[str, str]:
        """Part: key of the first method of the recipe that plays it."""
        found: dict[str, str] = {}
        for role in ROLES:
            for key, method in self.results.methods.items():
                if _plays(method, role):
                    found.setdefault(role, key)
        return found

    def key(self, role: str) -> str:
        """The method that plays a part.

        :param role: the part
        :return: its key in the recipe
        :raises CannotTellError: if the recipe has no such method, or no run of it is whole
        """
        if role not in self.roles:
            raise CannotTellError(f"needs finished runs of a method with {_described(role)}")
        return self.roles[role]

    def label(self, role: str) -> str:
        """What tables call the method that plays a part.

        :param role: the part
        :return: its label
        """
        return self.method(role).label

    def method(self, role: str) -> Method:
        """The method that plays a part.

        :param role: the part
        :return: the method
        """
        return self.results.methods[self.key(role)]

    def scores(self, role: str, name: str) -> NDArray[np.float64]:
        """A figure of every seed and test episode.

        :param role: the part
        :param name: a quantity, or another column of the raw rows
        :return: means over the UAVs of an episode [S, E]
        """
        return self.results.scores(self.key(role), name)


def _plays(method: Method, role: str) -> bool:
    fields = {name: getattr(method, name) for name in ("player", "algo", "policy", "without_reward")}
    values = {**UNLESS_SET, **method.settings, **fields}
    return all(values[name] == wanted for name, wanted in {**UNLESS_SET, **ROLES[role]}.items())


def _described(role: str) -> str:
    return ", ".join(f"{name} {str(value).lower()}" for name, value in ROLES[role].items())


def load_claims(files: Sequence[Path] = CLAIMS_FILES) -> list[Claim]:
    """Read the claims.

    :param files: YAML files, each a list of claims
    :return: the claims: premises in the paper's order, then results
    """
    return [Claim.model_validate(values) for path in files for values in yaml.safe_load(path.read_text("utf-8"))]
