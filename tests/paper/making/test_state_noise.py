"""Noise in the global state: actors of the kit do not heed it, and one that does is found."""

from pathlib import Path

import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell, cells
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.paper.checks.checks import CHECKS
from lawn_sb3.paper.making.state_noise import state_noise
from lawn_sb3.paper.roles import ROLES

STOCK = "stable_baselines3.common.policies:ActorCriticPolicy"


def test_actors_of_the_kit_ignore_the_global_state_and_sb3s_own_does_not(
    recipe: Recipe, small_cells: list[Cell], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # One seed of V([o_i, x]), of the paper's V(x), and of SB3's own actor, which reads all of [o_i | x].
    small = recipe.methods["mappo"]
    methods = {
        "state": small.model_copy(update={"policy": "state_critic", "label": "V(x)"}),
        "stock": small.model_copy(update={"policy": STOCK, "label": "Stock"}),
    }
    made = cells(recipe.model_copy(update={"methods": methods, "seeds": (0,)}), tmp_path / "more")
    monkeypatch.setattr("lawn_sb3.experiment.train.check_policy", lambda model, name: None)  # it refuses SB3's own
    for cell in made:
        run_cell(cell, lambda env_steps: None)
    monkeypatch.setitem(ROLES, "iql", {"algo": "mappo", "policy": STOCK})
    whole = recipe.model_copy(update={"methods": {**recipe.methods, **methods}})
    rows = state_noise(whole, [*small_cells, *made])
    assert rows.columns.tolist() == ["draw", "actions", "state", "mappo", "stock"]
    assert (len(rows), set(rows["actions"])) == (20, {200})  # 50 games of four UAVs, x replaced 20 times
    assert rows[["state", "mappo"]].sum().tolist() == [0, 0]
    assert (rows["stock"] > 0).all()


def test_without_its_model_an_actor_cannot_be_asked(recipe: Recipe, small_cells: list[Cell]) -> None:
    (check,) = (check for check in CHECKS if check.name == "state_noise")
    assert check.is_needed(recipe, small_cells)
    assert not check.is_needed(recipe, [cell for cell in small_cells if cell.key == "random"])
    for cell in small_cells:
        (cell.directory / "model.zip").unlink(missing_ok=True)
    with pytest.raises(UserError, match=r"needs the trained model of CTDE-MAPPO: .*model\.zip"):
        state_noise(recipe, small_cells)
