"""What a check is: which recipes it is for, what it depends on, how it is flown, and what its file may hold."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import pandas as pd

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.knowledge import has_ladder
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.experiment.run_directory.csv_file import Columns
from lawn_sb3.experiment.run_directory.files import EPISODE_KEY, evaluation_columns
from lawn_sb3.game.player import Player
from lawn_sb3.scenario import Scenario


class Check(ABC):
    """Something to fly or plan for a recipe, for its claims if nothing else is said; it is kept in ``NAME.csv``."""

    name: str
    since: str = "0.2.0"
    """The last version that changed what it leaves, as ``RESULTS_SINCE`` is for runs."""
    key: Sequence[str] = EPISODE_KEY
    """Columns that no two rows have alike."""

    def game(self, recipe: Recipe) -> Scenario:
        """The game that is flown, on the recipe's test missions."""
        return recipe.game()

    def is_needed(self, recipe: Recipe, finished: Sequence[Cell]) -> bool:
        """Whether the report asks for it: here, whether it judges the claims that need no other recipe.

        :param recipe: the recipe
        :param finished: the cells whose runs are finished
        :return: true if it does
        """
        return not has_ladder({cell.key: cell.method for cell in finished})

    def depends_on(self, recipe: Recipe, finished: Sequence[Cell]) -> dict[str, Any]:
        """What the rows depend on besides game and missions: with anything else they are stale.

        :param recipe: the recipe
        :param finished: the cells whose runs are finished
        :return: what JSON can hold
        """
        return {}

    @abstractmethod
    def fly(self, recipe: Recipe, finished: Sequence[Cell]) -> pd.DataFrame:
        """Make the rows.

        :param recipe: the recipe
        :param finished: the cells whose runs are finished
        :return: the rows
        :raises UserError: if they cannot be made; why is told by the claim
        """

    @abstractmethod
    def columns(self, recipe: Recipe, finished: Sequence[Cell]) -> Columns:
        """What each column of the file may hold.

        :param recipe: the recipe
        :param finished: the cells whose runs are finished
        :return: the columns, in order
        """


class EvaluationCheck(Check):
    """A player flies the test missions, as methods do; the file holds the raw rows of its evaluation."""

    @abstractmethod
    def player(self) -> Player:
        """Who flies."""

    def fly(self, recipe: Recipe, finished: Sequence[Cell]) -> pd.DataFrame:
        """Let it fly."""
        return evaluate(self.player(), self.game(recipe), recipe.evaluation.episodes, recipe.evaluation.seed)

    def columns(self, recipe: Recipe, finished: Sequence[Cell]) -> Columns:
        """Those of every evaluation."""
        return evaluation_columns(self.game(recipe), recipe.evaluation.episodes)
