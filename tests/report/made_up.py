"""Results made up by hand: one figure a UAV and episode where a test needs no more."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import pandas as pd

from lawn_sb3.experiment.recipe import Method, Recipe
from lawn_sb3.report.results import Results

MADE_UP = {
    "reward": 1.0, "rate_mbps": 30.0, "slots": 5, "min_slots": 5, "arrived": True, "utility_mbps": 20.0,
    "collisions": 0, "makespan_slots": 5, "mean_cell_load": 1.0,
}  # fmt: skip


def rows(method: str, seed: int, **columns: Sequence[float]) -> pd.DataFrame:
    """Raw rows of one evaluation: one UAV, an episode for each value given; other columns are made up."""
    count = max((len(values) for values in columns.values()), default=1)
    made = {"method": method, "seed": seed, "episode": range(count), "uav": 0, **MADE_UP, **columns}
    return pd.DataFrame(made)


def results(recipe: Recipe, *tables: pd.DataFrame, **more: pd.DataFrame) -> Results:
    """Results that hold these rows."""
    return Results(recipe, pd.concat(tables, ignore_index=True), **more)


def recipe_of(methods: Mapping[str, Method], **changes: object) -> Recipe:
    """A recipe of these methods."""
    return Recipe.model_validate({"name": "made-up", "seeds": [0, 1], "methods": dict(methods), **changes})


def learner(label: str, policy: str | None = None, algo: str = "mappo", paper_row: str | None = None) -> Method:
    """A method that trains."""
    values = {"label": label, "algo": algo, "policy": policy, "paper_row": paper_row, "env_steps": 1}
    return Method.model_validate(values)
