"""Whoever a command lets fly: a finished run or a player without training, on a game of its own or on another one."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from lawn_sb3.config import parse_overrides
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import fits_all_games
from lawn_sb3.experiment.registry import PLAYERS, check_player, find_player
from lawn_sb3.experiment.run_directory.configuration import load_finished_run
from lawn_sb3.scenario import Scenario, load_scenario

if TYPE_CHECKING:
    from lawn_sb3.game.player import Player


class Flyer(NamedTuple):
    """Who is to fly, checked but not loaded."""

    name: str
    """Its key in a recipe, or the player's own name."""
    label: str
    """What tables call it."""
    game: Scenario
    """What it is to fly."""
    seed: int
    """Of its own randomness: the run's; 0 for a player without training."""
    player: str | None
    """The player that needs no training, if it is one, in a run too."""
    cell: Cell | None
    """The run."""

    @property
    def flies_alone(self) -> bool:
        """Whether it gives every UAV a game of its own."""
        return self.player is not None and PLAYERS[self.player].flies_alone

    def load(self, sample: bool = False) -> "Player":
        """Load it.

        :param sample: sample actions instead of taking the likeliest
        :return: the player
        """
        if self.cell is None:
            return find_player(self.name)

        from lawn_sb3.experiment.players import load_player

        return load_player(self.cell, not sample, self.game)


def run_flyer(run: Path, scenario: str | None, changes: list[str], trusted: list[str]) -> Flyer:
    """A finished run.

    :param run: its folder
    :param scenario: the game to fly; by default the run's own
    :param changes: what is changed in it
    :param trusted: policies of the user that it may name
    :return: who flies
    :raises UserError: if it is not finished, or its model cannot fly the game
    """
    cell = load_finished_run(run, trusted)
    own = cell.scenario if scenario is None else load_scenario(scenario)
    game = own.changed(**parse_overrides(changes)) if changes else own
    same_moves = game.max_voxel_steps == cell.scenario.max_voxel_steps
    if not same_moves or (game.num_gbs != cell.scenario.num_gbs and not _fits_any_num_gbs(cell)):
        raise UserError(f"{str(run)!r} was trained for {_sizes(cell.scenario)}; {game.name!r} has {_sizes(game)}")
    return Flyer(cell.key, cell.method.label, game, cell.seed, cell.method.player, cell)


def player_flyer(name: str, game: Scenario) -> Flyer:
    """A player without training, by its name."""
    check_player(name)
    return Flyer(name, name.replace("-", " ").capitalize(), game, 0, name, None)


def _fits_any_num_gbs(cell: Cell) -> bool:
    return cell.method.policy is not None and fits_all_games(cell.method)


def _sizes(scenario: Scenario) -> str:
    return f"{scenario.num_gbs} GBSs, v_max {scenario.max_voxel_steps}"
