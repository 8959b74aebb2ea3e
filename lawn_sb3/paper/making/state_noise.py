"""Whether trained actors act on o_i alone: the global state is replaced by noise, and changed actions are counted."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.envs import Observer
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.players import ModelPlayer, load_player
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.paper.checks.checks import NOISE, NOISE_DRAWS, NOISE_GAMES, NOISE_SLOTS, noise_models


def state_noise(recipe: Recipe, finished: Sequence[Cell]) -> pd.DataFrame:
    """One row per draw of the noise: how many actions there were, and of the first seed of each method that changed.

    :param recipe: the recipe
    :param finished: the cells whose runs are finished
    :return: the columns ``draw, actions`` and the key of each method
    :raises UserError: if a trained model is not there
    """
    flat, state = _observations(recipe)
    rng = np.random.default_rng(recipe.evaluation.seed)
    rows = pd.DataFrame({"draw": range(NOISE_DRAWS), "actions": len(flat)})
    for cell in noise_models(recipe, finished):
        model = _trained(cell).model
        before, _ = model.predict(flat, deterministic=True)
        changed = []
        for _ in range(NOISE_DRAWS):
            noisy = flat.copy()
            noisy[:, state] = rng.normal(0.0, NOISE, noisy[:, state].shape)
            after, _ = model.predict(noisy, deterministic=True)
            changed.append(int((after != before).sum()))
        rows[cell.key] = changed
    return rows


def _observations(recipe: Recipe) -> tuple[NDArray[np.float32], slice]:
    """Observations [B, flat_dim] after some slots of random play, and the columns of x in them."""
    simulator = Simulator(recipe.game(), NOISE_GAMES, seed=recipe.evaluation.seed)
    rng = np.random.default_rng(recipe.evaluation.seed)
    for _ in range(NOISE_SLOTS):
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
