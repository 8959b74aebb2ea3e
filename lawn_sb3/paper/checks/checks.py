"""Every check as data: which recipes it is for, what it depends on, and what its file may hold."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.knowledge import has_ladder
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.experiment.run_directory.columns import EPISODE_KEY, episode_and_uav, evaluation_columns
from lawn_sb3.experiment.run_directory.csv_file import Columns, number, whole
from lawn_sb3.paper.comparable import printed_rows
from lawn_sb3.paper.printed_values import LATEST_SLOTS, TABLE_II
from lawn_sb3.paper.roles import FORMS, cast
from lawn_sb3.results.results import BOUND, EQUILIBRIA
from lawn_sb3.scenario import PRESETS, Scenario

CYCLE_MISSIONS = 50
"""Test missions whose first slots are looked at."""
SHARE_FLYING = TABLE_II["IQL"].success_percent / 100.0
"""As many UAVs fly as the paper's IQL brings to their destinations."""
NOISE_GAMES, NOISE_SLOTS, NOISE_DRAWS = 50, 10, 20
"""Observations: games, slots of random play before, and times that x is replaced."""
NOISE = 10.0
"""Standard deviation of what replaces x."""


def judges_claims(recipe: Recipe, finished: Sequence[Cell]) -> bool:
    """Whether the report judges the claims that need no other recipe."""
    return bool(printed_rows(recipe)) and not has_ladder({cell.key: cell.method for cell in finished})


@dataclass(frozen=True)
class Check:
    """Something to fly or plan for a recipe; its rows are kept in ``NAME.csv``.

    :param name: of the file
    :param columns: what each column may hold, in order; from the recipe and the cells whose runs are finished
    :param key: columns that no two rows have alike
    :param game: the game that is flown, on the recipe's test missions
    :param is_needed: whether the report asks for it
    :param depends_on: what the rows depend on besides game and missions, as JSON: with anything else they are stale
    :param since: the last version that changed what it leaves, as ``RESULTS_SINCE`` is for runs
    """

    name: str
    columns: Callable[[Recipe, Sequence[Cell]], Columns]
    key: tuple[str, ...] = tuple(EPISODE_KEY)
    game: Callable[[Recipe], Scenario] = Recipe.game
    is_needed: Callable[[Recipe, Sequence[Cell]], bool] = judges_claims
    depends_on: Callable[[Recipe, Sequence[Cell]], dict[str, Any]] = lambda recipe, finished: {}
    since: str = "0.2.0"


def _of_lengths(recipe: Recipe, finished: Sequence[Cell]) -> Columns:
    game, episodes = PRESETS["paper"], recipe.evaluation.episodes
    return {
        "min_slots": whole("length of the mission, T_i^min", "slots", 1, sum(game.grid)),
        "uavs": whole("UAVs of all test missions that have it", "UAVs", 1, episodes * game.num_uavs),
        "least_mbps": number("rate and terminal terms of J, at least", "Mbps", 0),
    }


def _of_hovering(recipe: Recipe, finished: Sequence[Cell]) -> Columns:
    seeks = whole("1 if those that hover move to the best voxel within one slot first", "", 0, 1)
    return {"seeks": seeks, **evaluation_columns(recipe.game(), recipe.evaluation.episodes)}


def _of_cycles(recipe: Recipe, finished: Sequence[Cell]) -> Columns:
    last_uav, last_gbs = recipe.game().num_uavs - 1, recipe.game().num_gbs - 1
    return {
        "episode": whole("test episode, from 0", "", 0, CYCLE_MISSIONS - 1),
        "uav": whole("the first UAV of the cycle", "", 0, last_uav),
        "to_gbs": whole("to whose cell it goes", "", 0, last_gbs),
        "other_uav": whole("the second UAV", "", 0, last_uav),
        "other_to_gbs": whole("to whose cell that goes", "", 0, last_gbs),
        "rate_gain_mbps": number("gains in rate, added up around the cycle", "Mbps"),
        "log_rate_gain": number("gains in the logarithm of the rate, added up"),
    }


def noise_models(recipe: Recipe, finished: Sequence[Cell]) -> list[Cell]:
    """Whose actors are asked with noise for x: the first finished seed of each method that plays a part."""
    there = {cell.key for cell in finished}
    playing = cast({key: method for key, method in recipe.methods.items() if key in there})
    keys = [playing[role] for role in (*FORMS, "qmix", "iql") if role in playing]
    return [min((cell for cell in finished if cell.key == key), key=lambda cell: cell.seed) for key in keys]


def _of_noise(recipe: Recipe, finished: Sequence[Cell]) -> Columns:
    actions = NOISE_GAMES * recipe.game().num_uavs
    changed = whole("actions of this method that changed", "", 0, actions)
    return {
        "draw": whole("draw of the noise, from 0", "", 0, NOISE_DRAWS - 1),
        "actions": whole("actions asked for", "", actions, actions),
        **{cell.key: changed for cell in noise_models(recipe, finished)},
    }


def _noise_depends_on(recipe: Recipe, finished: Sequence[Cell]) -> dict[str, Any]:
    models = [(cell.key, cell.fingerprint()) for cell in noise_models(recipe, finished)]
    return {"observations": (NOISE_GAMES, NOISE_SLOTS, NOISE_DRAWS, NOISE), "models": models}


def _of_guarantees(recipe: Recipe, finished: Sequence[Cell]) -> Columns:
    least = number("utility that no equilibrium gives less than", "Mbps", 0)
    return {**episode_and_uav(recipe.game(), recipe.evaluation.episodes), "guaranteed_mbps": least}


def _may_have_equilibria(recipe: Recipe, finished: Sequence[Cell]) -> bool:
    """Whether there may be certified equilibria, and a bound to hold them against."""
    players = {cell.method.player for cell in finished}
    return recipe.regret and BOUND in players and not players.isdisjoint(EQUILIBRIA)


CHECKS = (
    Check(
        "printed_grid",  # raw rows of Random on the grid that Table I prints: its least flight times
        columns=lambda recipe, finished: evaluation_columns(PRESETS["as-printed"], recipe.evaluation.episodes),
        game=lambda recipe: PRESETS["as-printed"],
    ),
    Check(
        "least_reward",
        columns=_of_lengths,
        key=("min_slots",),
        game=lambda recipe: PRESETS["paper"],
        depends_on=lambda recipe, finished: {
            "rate_mbps": TABLE_II["CTDE-MAPPO"].rate_mbps,
            "latest_slots": LATEST_SLOTS,
        },
    ),
    Check(
        "deviation_cycles",
        columns=_of_cycles,
        key=("episode", "uav", "to_gbs", "other_uav", "other_to_gbs"),
        depends_on=lambda recipe, finished: {"missions": CYCLE_MISSIONS},
    ),
    Check(
        "hovering",  # raw rows of the player that hovers, where it starts and in the best voxel nearby
        columns=_of_hovering,
        key=("seeks", *EPISODE_KEY),
        depends_on=lambda recipe, finished: {"share_flying": SHARE_FLYING, "seeks": [0, 1]},
    ),
    Check(
        "state_noise",
        columns=_of_noise,
        key=("draw",),
        is_needed=lambda recipe, finished: judges_claims(recipe, finished) and bool(noise_models(recipe, finished)),
        depends_on=_noise_depends_on,
    ),
    Check("guaranteed", columns=_of_guarantees, is_needed=_may_have_equilibria),
)
"""Each leaves ``NAME.csv``, and ``NAME.json`` with fingerprint, number of rows, the table's hash, and provenance."""
