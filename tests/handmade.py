"""Results whose every number a reader can see.

With two seeds the bounds of a bootstrap interval over a method's seeds are the seeds themselves: a resample draws the
same seed twice in half of all cases. Welch's interval of a difference to a method whose seeds are equal then reaches
12.71 standard errors to both sides, the 97.5 % quantile of Student's t with 1 degree of freedom.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from lawn_sb3.experiment.recipe import Evaluation, Method, Recipe
from lawn_sb3.experiment.run_directory.columns import evaluation_columns
from lawn_sb3.paper.claims import Evidence
from lawn_sb3.paper.roles import ROLES
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
PAPER_ROWS = {"random": "Random", "iql": "IQL", "qmix": "QMIX", "mappo": "CTDE-MAPPO", "mappo-o": "CTDE-MAPPO"}


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
    values = {"label": label, "algo": algo, "policy": policy, "paper_row": paper_row, "env_steps": 1}
    return Method.model_validate(values)


def player(name: str) -> Method:
    return Method(label=name.capitalize(), player=name)


def recipe_with(methods: Mapping[str, Method], **changes: object) -> Recipe:
    return Recipe.model_validate({"name": "handmade", "seeds": [0, 1], "methods": dict(methods), **changes})


def method_of(role: str, **changes: Any) -> Method:
    """A method that plays a part in the claims, labelled like it in capitals."""
    given = dict(ROLES[role])
    fields = [name for name in ("player", "algo", "policy", "without_reward") if name in given]
    values: dict[str, Any] = {name: given.pop(name) for name in fields}
    if values.get("algo") == "mappo-episodes":
        values["continuation"] = "episode"
    learner = {"env_steps": 150_000, "settings": given} if "algo" in values else {}
    return Method.model_validate(
        {"label": role.upper(), "paper_row": PAPER_ROWS.get(role), **values, **learner, **changes}
    )


PARTS = {role: method_of(role) for role in ROLES}
"""A method for every part, under the part's name as key."""


def recipe_of_parts(methods: Mapping[str, Method] = PARTS, changes: Sequence[str] = (), episodes: int = 6) -> Recipe:
    """A recipe of these methods, or of one for every part."""
    return recipe_with(methods, set=changes, evaluation={"episodes": episodes})


def flown(method: str, seed: int, num_uavs: int = 1, **columns: Sequence[Any]) -> pd.DataFrame:
    """Rows of one evaluation, UAV by UAV and episode by episode; a column that is not named holds dull values."""
    count = len(next(iter(columns.values()))) if columns else 1
    rows = pd.DataFrame({**DULL, **columns}, index=range(count))
    rows.insert(0, "uav", [k % num_uavs for k in range(count)])
    rows.insert(0, "episode", [k // num_uavs for k in range(count)])
    assert set(rows) == set(evaluation_columns(PRESETS["paper"], 1))
    rows.insert(0, "seed", seed)
    rows.insert(0, "method", method)
    return rows


def flown_by_seed(method: str, num_uavs: int = 1, **columns: Sequence[Sequence[Any]]) -> pd.DataFrame:
    """Rows of several evaluations: the values of each column seed by seed."""
    seeds = range(len(next(iter(columns.values()))))
    return pd.concat(
        [flown(method, seed, num_uavs, **{name: values[seed] for name, values in columns.items()}) for seed in seeds],
        ignore_index=True,
    )


def trained(
    method: str, *seeds: Sequence[float], column: str = "greedy/success_percent", every: int = 50_000
) -> pd.DataFrame:
    """A learning curve, seed by seed: one point after every so many env steps."""
    parts = [
        {"method": method, "seed": seed, "time/env_steps": every * (k + 1), column: float(value)}
        for seed, values in enumerate(seeds)
        for k, value in enumerate(values)
    ]
    return pd.DataFrame(parts)


def responded(method: str, seed: int, had: pd.DataFrame, best_mbps: list[float]) -> pd.DataFrame:
    """Regrets of one evaluation: what the UAVs had, and what their best responses would have given."""
    rows = had[["episode", "uav", "utility_mbps"]].assign(best_mbps=best_mbps, best_slots=1)
    rows.insert(0, "seed", seed)
    rows.insert(0, "method", method)
    return rows


def results_of(recipe: Recipe, *episodes: pd.DataFrame, **tables: Any) -> Results:
    results = Results(recipe, pd.concat(episodes, ignore_index=True) if episodes else pd.DataFrame())
    for name, rows in tables.items():
        setattr(results, name, rows)
    return results


def evidence(
    *episodes: pd.DataFrame,
    curves: Sequence[pd.DataFrame] = (),
    recipe: Recipe | None = None,
    **checks: pd.DataFrame | str,
) -> Evidence:
    """What these rows, curves and checks say; a method that has a curve alone is given one dull mission per seed."""
    flew = {own["method"].iloc[0] for own in episodes}
    alone = [own for own in curves if own["method"].iloc[0] not in flew]
    dull = [flown(own["method"].iloc[0], seed) for own in alone for seed in own["seed"].unique()]
    tables = {"curves": pd.concat(curves, ignore_index=True)} if curves else {}
    return Evidence(results_of(recipe or recipe_of_parts(), *episodes, *dull, **tables, checks=checks))


def measured(column: str, num_uavs: int = 1, /, **methods: Sequence[Sequence[Any]]) -> Evidence:
    """What these values of one column say, by method, with an underscore for a hyphen, and by seed."""
    named = {name.replace("_", "-"): values for name, values in methods.items()}
    return evidence(*(flown_by_seed(name, num_uavs, **{column: values}) for name, values in named.items()))
