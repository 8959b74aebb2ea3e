"""What claims are held to: what the runs left, and what was flown for the claims alone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.experiment.recipe import Method
from lawn_sb3.paper.roles import cast, described
from lawn_sb3.results.results import Results


class CannotTellError(Exception):
    """The evidence a claim needs is not there; the message says what is missing."""


@dataclass
class Evidence:
    """What claims are held to.

    :param results: what the runs left
    """

    results: Results

    @cached_property
    def roles(self) -> dict[str, str]:
        """Part: key of the first method with results that plays it."""
        return cast(self.results.methods)

    def key(self, role: str) -> str:
        """The method that plays a part.

        :param role: the part
        :return: its key in the recipe
        :raises CannotTellError: if the recipe has no such method, or no run of it is whole
        """
        if role not in self.roles:
            raise CannotTellError(f"needs finished runs of a method with {described(role)}")
        return self.roles[role]

    def method(self, role: str) -> Method:
        """The method that plays a part."""
        return self.results.methods[self.key(role)]

    def label(self, role: str) -> str:
        """What tables call the method that plays a part."""
        return self.method(role).label

    def scores(self, role: str, name: str) -> NDArray[np.float64]:
        """A figure of every seed and test episode.

        :param role: the part
        :param name: column of the raw rows
        :return: means over the UAVs of an episode [S, E]
        """
        return self.results.scores(self.key(role), name)

    def utilities_mbps(self, role: str) -> NDArray[np.float64]:
        """The utility of every seed, test episode and UAV [S, E, N]."""
        return self.results.scores(self.key(role), "utility_mbps", per="uav")

    def check(self, name: str) -> pd.DataFrame:
        """What was flown for claims alone.

        :param name: the name of a check
        :return: its rows
        :raises CannotTellError: if they are not there
        """
        found = self.results.checks.get(name, f"needs checks/{name}.csv, which lawn-sb3 reproduce makes")
        if isinstance(found, str):
            raise CannotTellError(found)
        return found
