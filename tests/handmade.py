"""Results whose every number a reader can see."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from lawn_sb3.experiment.recipe import Evaluation, Method, Recipe
from lawn_sb3.experiment.run_directory.files import evaluation_columns
from lawn_sb3.results.results import Results
from lawn_sb3.scenario import PRESETS

DULL: dict[str, Any] = {
    "reward": 0.0,
    "rate_mbps": 0.0,
    "slots": 1,
    "min_slots": 1,
    "arrived": True,
    "utility_mbps": 0.0,
    "collisions": 0,
    "makespan_slots": 1,
    "mean_cell_load": 1.0,
}


def recipe_of(num_uavs: int, methods: tuple[str, ...], seeds: int = 1, episodes: int = 1) -> Recipe:
    """A recipe of players named M1, M2..., on the paper's game with other UAVs."""
    return Recipe(
        name="handmade",
        set=(f"num_uavs={num_uavs}",),
        seeds=tuple(range(seeds)),
        evaluation=Evaluation(episodes=episodes),
        methods={key: Method(label=f"M{k}", player="random") for k, key in enumerate(methods, 1)},
    )


def learner(label: str, policy: str | None = None, algo: str = "mappo", paper_row: str | None = None) -> Method:
    """A method that trains."""
    values = {"label": label, "algo": algo, "policy": policy, "paper_row": paper_row, "env_steps": 1}
    return Method.model_validate(values)


def player(name: str) -> Method:
    """A player without training, labelled with its name."""
    return Method(label=name.capitalize(), player=name)


def recipe_with(methods: Mapping[str, Method], **changes: object) -> Recipe:
    """A recipe of these methods on the paper's game."""
    return Recipe.model_validate({"name": "handmade", "seeds": [0, 1], "methods": dict(methods), **changes})


def flown(method: str, seed: int, num_uavs: int = 1, **columns: list[Any]) -> pd.DataFrame:
    """Rows of one evaluation, UAV by UAV and episode by episode; a column that is not named holds dull values."""
    count = len(next(iter(columns.values()))) if columns else 1
    rows = pd.DataFrame({**DULL, **columns}, index=range(count))
    rows.insert(0, "uav", [k % num_uavs for k in range(count)])
    rows.insert(0, "episode", [k // num_uavs for k in range(count)])
    assert set(rows) == set(evaluation_columns(PRESETS["paper"], 1))
    rows.insert(0, "seed", seed)
    rows.insert(0, "method", method)
    return rows


def responded(method: str, seed: int, had: pd.DataFrame, best_mbps: list[float]) -> pd.DataFrame:
    """Regrets of one evaluation: what the UAVs had, and what their best responses would have given."""
    rows = had[["episode", "uav", "utility_mbps"]].assign(best_mbps=best_mbps, best_slots=1)
    rows.insert(0, "seed", seed)
    rows.insert(0, "method", method)
    return rows


def results_of(recipe: Recipe, *episodes: pd.DataFrame, **tables: Any) -> Results:
    """Results that hold these tables."""
    results = Results(recipe, pd.concat(episodes, ignore_index=True))
    for name, rows in tables.items():
        setattr(results, name, rows)
    return results
