"""Evidence whose every number a reader can see: a method for each part, and figures seed by seed.

With two seeds the bounds of a bootstrap interval over a method's seeds are the seeds themselves: a resample draws the
same seed twice in half of all cases. Welch's interval of a difference to a method whose seeds are equal then reaches
12.71 standard errors to both sides, the 97.5 % quantile of Student's t with 1 degree of freedom.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Method, Recipe
from lawn_sb3.paper.claims import Evidence
from lawn_sb3.paper.claims.claim import ROLES
from lawn_sb3.results.results import Results

DULL: dict[str, Any] = {
    "reward": 1.0, "rate_mbps": 30.0, "slots": 5, "min_slots": 5, "arrived": True, "utility_mbps": 20.0,
    "collisions": 0, "makespan_slots": 5, "mean_cell_load": 1.0,
}  # fmt: skip
PAPER_ROWS = {"random": "Random", "iql": "IQL", "qmix": "QMIX", "mappo": "CTDE-MAPPO", "mappo-o": "CTDE-MAPPO"}
BUDGET = 150_000


def method(role: str, **changes: Any) -> Method:
    """A method that plays a part, labelled like it in capitals."""
    given = dict(ROLES[role])
    values = {name: given.pop(name) for name in ("player", "algo", "policy", "without_reward") if name in given}
    if values.get("algo") == "mappo-episodes":
        values["continuation"] = "episode"
    learner = {"env_steps": BUDGET, "settings": given} if "algo" in values else {}
    return Method.model_validate(
        {"label": role.upper(), "paper_row": PAPER_ROWS.get(role), **values, **learner, **changes}
    )


METHODS = {role: method(role) for role in ROLES}
"""Every part, under its own name as key."""


def recipe_of(methods: dict[str, Method] | None = None, changes: Sequence[str] = (), episodes: int = 6) -> Recipe:
    """A recipe of these methods, or of all."""
    values = {"name": "by-hand", "seeds": [0, 1], "set": changes, "evaluation": {"episodes": episodes}}
    return Recipe.model_validate({**values, "methods": METHODS if methods is None else methods})


def flown(role: str, num_uavs: int = 1, **seeds: Sequence[Sequence[Any]]) -> pd.DataFrame:
    """Raw rows of a method: for each column and seed the values UAV by UAV, episode by episode; others are dull."""
    parts = []
    for seed in range(len(next(iter(seeds.values())))):
        own = pd.DataFrame({name: values[seed] for name, values in seeds.items()})
        own = own.assign(**{name: value for name, value in DULL.items() if name not in own})
        labels = {"method": role, "seed": seed, "episode": own.index // num_uavs, "uav": own.index % num_uavs}
        parts.append(own.assign(**labels))
    return pd.concat(parts, ignore_index=True)


def trained(
    role: str, *seeds: Sequence[float], column: str = "greedy/success_percent", every: int = 50_000
) -> pd.DataFrame:
    """A learning curve: one point after every so many env steps."""
    parts = [
        {"method": role, "seed": seed, "time/env_steps": every * (k + 1), column: float(value)}
        for seed, values in enumerate(seeds)
        for k, value in enumerate(values)
    ]
    return pd.DataFrame(parts)


def evidence(
    *episodes: pd.DataFrame,
    curves: Sequence[pd.DataFrame] = (),
    cells: Sequence[Cell] = (),
    recipe: Recipe | None = None,
) -> Evidence:
    """What these rows and curves say; a method that has a curve alone is given one dull mission a seed."""
    flew = {own["method"].iloc[0] for own in episodes}
    dull = [
        flown(key, reward=[[1.0]] * own["seed"].nunique())
        for own in curves
        if (key := own["method"].iloc[0]) not in flew
    ]
    tables = [*episodes, *dull]
    results = Results(
        recipe_of() if recipe is None else recipe,
        pd.concat(tables, ignore_index=True) if tables else pd.DataFrame(),
        pd.concat(curves, ignore_index=True) if curves else pd.DataFrame(),
    )
    return Evidence(results, cells)
