"""The search for settings: equal trials, env steps and seeds for every method, apart from the reported seeds."""

import json
import multiprocessing
import tempfile
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import optuna
import pandas as pd
from optuna.distributions import BaseDistribution, CategoricalDistribution
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend
from pydantic import BaseModel, ConfigDict, Field
from rich.console import Console

from lawn_sb3.config import read_yaml_mapping, validated
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.experiment.recipe import Evaluation, Method, load_recipe, parse_method
from lawn_sb3.experiment.reproduce import prepare_worker
from lawn_sb3.experiment.run_directory.files import EVALUATION_FILE
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.scenario import load_scenario

Setting = str | int | float | bool


class Search(BaseModel):
    """What is searched: methods of a recipe, each with the values its settings may take."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    recipe: str = Field("paper.yaml", description="recipe beside this file that holds the methods")
    trials: int = Field(12, ge=1, description="settings tried for each method; the first are the recipe's own")
    env_steps: int = Field(50_000, ge=1, description="budget of a training")
    seeds: tuple[int, ...] = Field((100,), min_length=1, description="one training each per trial; none is reported")
    episodes: int = Field(200, ge=1, description="joint episodes each training is scored on")
    missions_seed: int = Field(30_000, ge=0, description="picks their missions, apart from the test's")
    space: dict[str, dict[str, list[Setting]]] = Field(min_length=1, description="method: setting: values")


def load_search(path: Path) -> tuple[Search, dict[str, Method]]:
    """Read a search and the methods that it is about.

    :param path: a file such as ``runs/tuning.yaml``
    :return: the search, and its methods as the recipe has them
    :raises UserError: one line naming what is wrong
    """
    search = validated(Search, read_yaml_mapping(path, "search"), str(path))
    recipe = load_recipe(path.parent / search.recipe)
    if set(search.seeds) & set(recipe.seeds):
        raise UserError(f"{path}: seeds {list(search.seeds)} are among those that {search.recipe} reports")
    if search.missions_seed == recipe.evaluation.seed:
        raise UserError(f"{path}: missions_seed = {search.missions_seed} is that of the test missions")
    for key in search.space:
        if key not in recipe.methods or recipe.methods[key].algo is None:
            raise UserError(f"{path}: space: {key!r} is no method of {search.recipe} that trains")
        for setting, choices in search.space[key].items():
            for choice in choices:
                values = recipe.methods[key].model_dump()
                parse_method({**values, "settings": {**values["settings"], setting: choice}})
    return search, {key: recipe.methods[key] for key in search.space}


def run_search(search: Search, methods: Mapping[str, Method], folder: Path, jobs: int, console: Console) -> None:
    """Try settings until every method has its number of different ones; those of an earlier call count.

    :param search: the search
    :param methods: the methods to search for
    :param folder: where the studies are kept, one file per method
    :param jobs: trainings side by side
    :param console: where progress goes
    """
    folder.mkdir(parents=True, exist_ok=True)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=prepare_worker) as pool, _stopping_workers():
        for key, method in methods.items():
            study = _study(folder, key)
            space: dict[str, BaseDistribution] = {
                name: CategoricalDistribution(values) for name, values in search.space[key].items()
            }
            own = {
                name: method.settings[name]
                for name, values in search.space[key].items()
                if method.settings.get(name) in values
            }
            if not study.trials and len(own) == len(space):
                study.enqueue_trial(own)
            while (left := search.trials - _distinct(study)) > 0:
                batch = [study.ask(space) for _ in range(min(jobs, left))]
                scores = pool.map(_score, *zip(*[(search, key, method, trial.params) for trial in batch], strict=True))
                for trial, score in zip(batch, scores, strict=True):
                    study.tell(trial, score)
                    console.print(f"{key} trial {trial.number}: J {score:.3f} with {trial.params}")


def ranked_trials(search: Search, folder: Path) -> pd.DataFrame:
    """All finished trials, the best of each method first.

    :param search: the search
    :param folder: where the studies are kept
    :return: the columns ``method, rank, reward, settings``
    """
    rows = []
    for key in search.space:
        trials = sorted(_finished(_study(folder, key)), key=_value, reverse=True)
        rows += [(key, rank, _value(trial), trial.params) for rank, trial in enumerate(trials, start=1)]
    return pd.DataFrame(rows, columns=["method", "rank", "reward", "settings"])


def _study(folder: Path, key: str) -> optuna.Study:
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    storage = JournalStorage(JournalFileBackend(str(folder / f"{key}.journal")))
    study = optuna.create_study(storage=storage, study_name=key, direction="maximize", load_if_exists=True)
    # Seeded by the trials so far, so that a continued search does not draw the same settings again.
    study.sampler = optuna.samplers.TPESampler(seed=len(study.trials), constant_liar=True)
    return study


def _distinct(study: optuna.Study) -> int:
    """How many different settings have been tried: the sampler may repeat itself, which does not count."""
    return len({json.dumps(trial.params, sort_keys=True) for trial in _finished(study)})


def _finished(study: optuna.Study) -> list[optuna.trial.FrozenTrial]:
    return study.get_trials(states=[optuna.trial.TrialState.COMPLETE])


def _value(trial: optuna.trial.FrozenTrial) -> float:
    return float("-inf") if trial.value is None else trial.value


def _score(search: Search, key: str, method: Method, settings: Mapping[str, Any]) -> float:
    """Mean greedy reward J of trainings with these settings."""
    values = {**method.model_dump(), "env_steps": search.env_steps, "settings": {**method.settings, **settings}}
    evaluation = Evaluation(episodes=search.episodes, seed=search.missions_seed, watch_every=10**9)
    rewards = []
    for seed in search.seeds:
        with tempfile.TemporaryDirectory() as folder:
            cell = Cell(key, parse_method(values), seed, load_scenario("paper"), evaluation, Path(folder))
            run_cell(cell, lambda env_steps: None)
            rewards.append(summarize(pd.read_csv(Path(folder) / EVALUATION_FILE))["reward"])
    return float(np.mean(rewards))


@contextmanager
def _stopping_workers() -> Iterator[None]:
    """End the workers at once when the search is interrupted."""
    try:
        yield
    except BaseException:
        for process in multiprocessing.active_children():
            process.terminate()
        raise
