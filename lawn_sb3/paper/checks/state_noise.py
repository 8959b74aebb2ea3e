"""Whether trained actors act on o_i alone: the global state is replaced by noise, and changed actions are counted."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.envs import Observer
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.players import ModelPlayer, load_player
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.experiment.run_directory.csv_file import Columns, whole
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.paper.checks.check import Check
from lawn_sb3.paper.roles import FORMS, cast

ROLES = (*FORMS, "qmix", "iql")
GAMES, SLOTS, DRAWS = 50, 10, 20
"""Observations: games, slots of random play before, and times that x is replaced."""
NOISE = 10.0
"""Standard deviation of what replaces x."""


class StateNoise(Check):
    """One row per draw of the noise: how many actions there were, and of the first seed of each method that changed."""

    name = "state_noise"
    key = ("draw",)

    def is_needed(self, recipe: Recipe, finished: Sequence[Cell]) -> bool:
        """Whether any method plays a part."""
        return super().is_needed(recipe, finished) and bool(_models(recipe, finished))

    def depends_on(self, recipe: Recipe, finished: Sequence[Cell]) -> dict[str, Any]:
        """The observations and the models."""
        models = [(cell.key, cell.fingerprint()) for cell in _models(recipe, finished)]
        return {"observations": (GAMES, SLOTS, DRAWS, NOISE), "models": models}

    def fly(self, recipe: Recipe, finished: Sequence[Cell]) -> pd.DataFrame:
        """Ask every actor with each draw."""
        flat, state = _observations(recipe)
        rng = np.random.default_rng(recipe.evaluation.seed)
        rows = pd.DataFrame({"draw": range(DRAWS), "actions": len(flat)})
        for cell in _models(recipe, finished):
            model = _trained(cell).model
            before, _ = model.predict(flat, deterministic=True)
            changed = []
            for _ in range(DRAWS):
                noisy = flat.copy()
                noisy[:, state] = rng.normal(0.0, NOISE, noisy[:, state].shape)
                after, _ = model.predict(noisy, deterministic=True)
                changed.append(int((after != before).sum()))
            rows[cell.key] = changed
        return rows

    def columns(self, recipe: Recipe, finished: Sequence[Cell]) -> Columns:
        """Counts of actions."""
        actions, models = GAMES * recipe.game().num_uavs, _models(recipe, finished)
        return {
            "draw": whole("draw of the noise, from 0", "", 0, DRAWS - 1),
            "actions": whole("actions asked for", "", actions, actions),
            **{cell.key: whole("actions of this method that changed", "", 0, actions) for cell in models},
        }


def _models(recipe: Recipe, finished: Sequence[Cell]) -> list[Cell]:
    """The first finished seed of each method that plays a part."""
    there = {cell.key for cell in finished}
    playing = cast({key: method for key, method in recipe.methods.items() if key in there})
    keys = [playing[role] for role in ROLES if role in playing]
    return [min((cell for cell in finished if cell.key == key), key=lambda cell: cell.seed) for key in keys]


def _observations(recipe: Recipe) -> tuple[NDArray[np.float32], slice]:
    """Observations [B, flat_dim] after some slots of random play, and the columns of x in them."""
    simulator = Simulator(recipe.game(), GAMES, seed=recipe.evaluation.seed)
    rng = np.random.default_rng(recipe.evaluation.seed)
    for _ in range(SLOTS):
        simulator.step(rng.integers(0, simulator.num_actions, simulator.state.flying.shape))
        simulator.go_on()
    observer = Observer(recipe.game())
    return observer.flat(simulator.state).reshape(-1, observer.layout.flat_dim), observer.layout.state


def _trained(cell: Cell) -> ModelPlayer:
    try:
        player = load_player(cell)
    except UserError as error:
        raise UserError(f"needs the trained model of {cell.method.label}: {error}") from None
    assert isinstance(player, ModelPlayer)
    return player
