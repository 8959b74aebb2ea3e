"""What claims are held to: what the runs left, and what was flown for the claims alone."""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.experiment.recipe import Method
from lawn_sb3.paper.roles import cast, described
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import LEVEL, holm


class CannotTellError(Exception):
    """The evidence a claim needs is not there; the message says what is missing."""


@dataclass
class Family:
    """The differences that claims test, of two methods or of a figure to a level, as one family.

    :param level: the largest p-value that counts
    :param p_values: what was tested so far, as figure, one or two parts, and the level that these are held to;
        what several claims test counts once
    """

    level: float = LEVEL
    p_values: dict[tuple[str, ...], float] = field(default_factory=dict)

    def is_apart(self, tested: tuple[str, ...], p_value: float) -> bool:
        """Whether a difference counts; the p-value is NaN where no seed differs from another: chance has no part."""
        if math.isnan(p_value):
            return True
        self.p_values[tested] = p_value
        return p_value <= self.level

    def correct(self) -> None:
        """From now on judge by Holm's procedure over all that was tested so far."""
        self.level = holm(list(self.p_values.values()))

    @property
    def num_apart(self) -> int:
        """How many of the differences count."""
        return sum(p_value <= self.level for p_value in self.p_values.values())


@dataclass
class Evidence:
    """What claims are held to, and the tests that they make of it."""

    results: Results
    tests: Family = field(default_factory=Family)

    @cached_property
    def roles(self) -> dict[str, str]:
        """Part: key of the first method with results that plays it."""
        return cast(self.results.methods)

    def key(self, role: str) -> str:
        """The key of the method that plays a part.

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
        """One column of the raw rows for every seed and test episode: means over the UAVs of an episode [S, E]."""
        return self.results.scores(self.key(role), name)

    def utilities_mbps(self, role: str) -> NDArray[np.float64]:
        """The utility of every seed, test episode and UAV [S, E, N]."""
        return self.results.scores(self.key(role), "utility_mbps", per="uav")

    def check(self, name: str) -> pd.DataFrame:
        """The rows of a check, which was flown for claims alone.

        :raises CannotTellError: if they are not there
        """
        found = self.results.checks.get(name, f"needs checks/{name}.csv, which lawn-sb3 reproduce makes")
        if isinstance(found, str):
            raise CannotTellError(found)
        return found
