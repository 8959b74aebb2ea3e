"""What an identification found, what that says, and how it is kept as JSON."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

import pandas as pd

from lawn_sb3.paper.identification.allowed import conclusion_findings, joint_findings
from lawn_sb3.paper.identification.candidates import PAPER
from lawn_sb3.paper.identification.findings import findings
from lawn_sb3.paper.identification.random_row import link_budget_interval

TABLES = ("random", "linear", "bounds", "others", "games", "conclusions")
DECIMALS = 6
"""Those of a figure that is kept, and shown: a page says the same before and after."""


@dataclass(frozen=True, eq=False)
class Identification:
    """What was tried, and the tables that it gave."""

    episodes: int
    """Joint episodes of the Random player in each scenario."""
    seed: int
    """Picks their missions."""
    random: pd.DataFrame
    """One row per candidate: the Random row it gives, and its distance to the paper's in standard errors."""
    linear: pd.DataFrame
    """One row per term of Random's J."""
    bounds: pd.DataFrame
    """One row per rate unit, ``nav_weight`` and ``ema_beta``: between which values the J of CTDE-MAPPO must lie."""
    others: pd.DataFrame
    """One row per trained player and candidate for a constant of the reward: its J beside the paper's."""
    games: pd.DataFrame
    """One row per reading and grid, with the constants fitted to it (:mod:`lawn_sb3.paper.identification.joint`)."""
    conclusions: pd.DataFrame
    """One row per example of an allowed game: what planners earn in it."""

    @property
    def findings(self) -> dict[str, str]:
        """What each constant alone may be, all others as in the preset."""
        return findings(self.random, self.linear, self.bounds, self.others, link_budget_interval(self.random))

    @property
    def joint_findings(self) -> dict[str, str]:
        """What holds in all games that the paper's figures are consistent with, and what stays open."""
        return joint_findings(self.games) | conclusion_findings(self.conclusions) if len(self.games) else {}

    def as_json(self) -> dict[str, Any]:
        """All results for machines.

        :return: numbers, texts, and each table as its ``columns`` and its rows (``data``); what is not a number is None
        """
        return {
            "scenario": PAPER.name,
            "episodes": self.episodes,
            "seed": self.seed,
            "link_budget_db": list(link_budget_interval(self.random)),
            "findings": self.findings,
            "joint_findings": self.joint_findings,
            **{
                name: json.loads(getattr(self, name).to_json(orient="split", index=False, double_precision=DECIMALS))
                for name in TABLES
            },
        }

    def as_text(self) -> str:
        """The same as text, one row of a table a line."""
        parts = []
        for name, value in self.as_json().items():
            text = json.dumps(value, ensure_ascii=False)
            if name in TABLES:
                rows = ",\n".join(json.dumps(row, ensure_ascii=False) for row in value["data"])
                text = f'{{"columns": {json.dumps(value["columns"])}, "data": [\n{rows}\n]}}'
            parts.append(f'"{name}": {text}')
        return "{\n" + ",\n".join(parts) + "\n}\n"

    @classmethod
    def from_json(cls, content: Mapping[str, Any]) -> Self:
        """The identification that :meth:`as_json` told of; what its tables say is worked out anew.

        :param content: what :meth:`as_json` returned
        :raises KeyError, TypeError, ValueError: if it is something else
        """
        tables = {name: pd.DataFrame(**content[name]) for name in TABLES}
        if len(tables["games"]):
            for name in ("games", "conclusions"):
                tables[name]["grid"] = tables[name]["grid"].map(tuple)
        return cls(content["episodes"], content["seed"], **tables)
