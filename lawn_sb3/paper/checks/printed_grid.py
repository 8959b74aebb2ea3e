"""Random on the grid that the paper's Table I prints: its rows tell the least flight times there."""

from __future__ import annotations

from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.game.player import Player, RandomPlayer
from lawn_sb3.paper.checks.check import EvaluationCheck
from lawn_sb3.scenario import PRESETS, Scenario


class PrintedGrid(EvaluationCheck):
    """Raw rows of Random on the scenario ``as-printed``."""

    name = "printed_grid"

    def game(self, recipe: Recipe) -> Scenario:
        """The game as printed, whatever the recipe's."""
        return PRESETS["as-printed"]

    def player(self) -> Player:
        """Random."""
        return RandomPlayer()
