"""The search for settings: every method gets as many trials, and as much CPU time, on seeds that are not reported."""

import json
import math
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import NamedTuple

import optuna
import pandas as pd
import torch as th
from optuna.distributions import BaseDistribution, CategoricalDistribution
from rich.console import Console

from lawn_sb3.errors import FailedRunsError
from lawn_sb3.experiment.backends.job import Backend, Failed, Finished, Job, Noted
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.experiment.recipe import Evaluation, Method, parse_method
from lawn_sb3.experiment.run_directory.files import EVALUATION_FILE
from lawn_sb3.experiment.search import Search, Setting
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.scenario import load_scenario
from lawn_sb3.whole_files import write_text

COLUMNS = ("method", "settings", "seed", "env_steps", "reward", "cpu_seconds")
"""Of the file of trainings: ``settings`` as JSON, ``reward`` the mean greedy J of a UAV, ``cpu_seconds`` it took."""
ROUND = 4
"""Settings that are proposed at a time, however many are trained side by side: the search does not depend on that."""


class Training(NamedTuple):
    """One training that the search asks for."""

    method: str
    settings: Mapping[str, Setting]
    seed: int


def run_search(search: Search, methods: Mapping[str, Method], file: Path, backend: Backend, console: Console) -> None:
    """Try settings of every method with the first seed, then train the best with all; earlier calls count.

    :param search: the search
    :param methods: the methods to search for
    :param file: where the trainings are kept, one row each
    :param backend: who trains
    :param console: where progress goes
    :raises FailedRunsError: if a training failed; those before it are kept
    """
    while batch := _next_trainings(search, methods, read_trainings(file)):
        titles = [f"{one.method} seed {one.seed} with {dict(one.settings)}" for one in batch]
        jobs = [
            Job(title, partial(_score, search, methods[one.method], one), gpus=methods[one.method].gpus)
            for title, one in zip(titles, batch, strict=True)
        ]
        scores: dict[int, tuple[float, float]] = {}
        written = 0
        with closing(backend.run(jobs)) as events:
            for event in events:
                if isinstance(event, Failed):
                    raise FailedRunsError(f"{titles[event.job]}: {event.reason}")
                if isinstance(event, Noted):
                    console.print(f"{titles[event.job]}: {event.text}", markup=False, soft_wrap=True)
                if isinstance(event, Finished):
                    scores[event.job] = event.value
                while written in scores:  # in the order in which they were proposed, whoever is done first
                    _keep(search, batch[written], scores[written], file, console)
                    written += 1


def _keep(search: Search, one: Training, score: tuple[float, float], file: Path, console: Console) -> None:
    """Write down what a training came to."""
    reward, seconds = score
    row = (one.method, json.dumps(one.settings), one.seed, search.env_steps, reward, round(seconds, 1))
    rows = pd.concat([read_trainings(file), pd.DataFrame([row], columns=COLUMNS)])
    write_text(file, rows.to_csv(index=False, lineterminator="\n"))
    console.print(f"{one.method} seed {one.seed}: J {reward:.3f} with {dict(one.settings)}", soft_wrap=True)


def read_trainings(file: Path) -> pd.DataFrame:
    """The trainings of a search so far.

    :param file: where they are kept
    :return: one row each, with the columns :data:`COLUMNS`; none if there is no file
    """
    if not file.exists():
        return pd.DataFrame(columns=COLUMNS)
    return pd.read_csv(file)


def ranked_settings(search: Search, file: Path) -> pd.DataFrame:
    """All settings that were tried, the best of each method first; those trained with all seeds before the others.

    :param search: the search
    :param file: where its trainings are kept
    :return: the columns ``method, rank, seeds, reward, at_edge, settings``: mean reward over the seeds, and names of
        settings whose value is the first or last of its list
    """
    rows = []
    for key, space in search.space.items():
        for rank, (text, seeds, reward) in enumerate(
            _ranked(_trainings_of(search, read_trainings(file), key)), start=1
        ):
            settings = json.loads(text)
            at_edge = [name for name, values in space.items() if _is_at_edge(settings[name], values)]
            rows.append((key, rank, seeds, reward, at_edge, settings))
    return pd.DataFrame(rows, columns=["method", "rank", "seeds", "reward", "at_edge", "settings"])


def _trainings_of(search: Search, trainings: pd.DataFrame, key: str) -> pd.DataFrame:
    """Those of a method that are the search's: its seeds and budget, and settings that its space offers."""
    space = search.space[key]

    def offered(text: str) -> bool:
        settings = json.loads(text)
        return settings.keys() == space.keys() and all(settings[name] in values for name, values in space.items())

    mine = trainings[(trainings["method"] == key) & trainings["seed"].isin(search.seeds)]
    mine = mine[mine["env_steps"] == search.env_steps]
    return mine[mine["settings"].map(offered).astype(bool)]


def _ranked(mine: pd.DataFrame) -> list[tuple[str, int, float]]:
    """Settings of a method as JSON, how many seeds they were trained with, and the mean reward; the best first."""
    means = [
        (str(text), len(rows), float(rows["reward"].mean())) for text, rows in mine.groupby("settings", sort=False)
    ]
    return sorted(means, key=lambda one: (-one[1], -one[2]))


def _is_at_edge(value: Setting, values: Sequence[Setting]) -> bool:
    """Whether a value is the first or last of several that have an order."""
    ordered = len(values) > 2 and not isinstance(value, bool)
    return ordered and value in (values[0], values[-1])


def _next_trainings(search: Search, methods: Mapping[str, Method], trainings: pd.DataFrame) -> list[Training]:
    """What to train next, side by side: new settings of the method with the fewest, or the best with another seed."""
    done = {key: _trainings_of(search, trainings, key) for key in methods}
    first = {key: mine[mine["seed"] == search.seeds[0]] for key, mine in done.items()}
    missing = {key: _missing_trials(search, key, first[key]) for key in methods}
    if any(missing.values()):
        key = min((key for key in methods if missing[key]), key=lambda one: len(first[one]))
        new = _new_settings(search.space[key], methods[key], _ranked(done[key]), min(ROUND, missing[key]))
        return [Training(key, settings, search.seeds[0]) for settings in new]
    others = [
        Training(key, json.loads(text), seed)
        for key in methods
        for text in first[key].sort_values("reward", ascending=False, kind="stable")["settings"][: search.finalists]
        for seed in search.seeds
        if not ((done[key]["settings"] == text) & (done[key]["seed"] == seed)).any()
    ]
    return others[:ROUND]


def _missing_trials(search: Search, key: str, first: pd.DataFrame) -> int:
    """How many settings of a method are still to be tried with the first seed, at least."""
    left = math.prod(map(len, search.space[key].values())) - len(first)
    if len(first) >= search.trials and first["cpu_seconds"].sum() < 60.0 * search.cpu_minutes:
        return min(ROUND, left)
    return min(max(search.trials - len(first), 0), left)


def _new_settings(
    space: Mapping[str, Sequence[Setting]], method: Method, tried: list[tuple[str, int, float]], number: int
) -> list[dict[str, Setting]]:
    """Settings that were not tried: the recipe's own first, then those that Optuna's sampler proposes."""
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    choices: dict[str, BaseDistribution] = {name: CategoricalDistribution(values) for name, values in space.items()}
    # Seeded by the trials so far, so that a continued search does not draw the same settings again.
    study = optuna.create_study(
        direction="maximize", sampler=optuna.samplers.TPESampler(seed=len(tried), constant_liar=True)
    )
    for text, _, reward in tried:
        study.add_trial(optuna.trial.create_trial(params=json.loads(text), distributions=choices, value=reward))
    known = {text for text, _, _ in tried}
    new: list[dict[str, Setting]] = []
    own = {name: method.settings.get(name, values[0]) for name, values in space.items()}
    if json.dumps(own) not in known and all(own[name] in values for name, values in space.items()):
        study.enqueue_trial(own)
    while len(new) < number:
        settings = study.ask(choices).params
        if (text := json.dumps(settings)) not in known:
            known.add(text)
            new.append(settings)
    return new


def _score(search: Search, method: Method, one: Training, progress: Callable[[int], None]) -> tuple[float, float]:
    """Mean greedy reward J of a training, and its CPU seconds."""
    th.set_num_threads(1)  # as in a recipe: equal numbers everywhere
    values = {**method.model_dump(), "env_steps": search.env_steps, "settings": {**method.settings, **one.settings}}
    evaluation = Evaluation(episodes=search.episodes, seed=search.missions_seed, watch_every=10**9)
    began = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        cell = Cell(one.method, parse_method(values), one.seed, load_scenario("paper"), evaluation, Path(folder))
        try:
            run_cell(cell, progress)
            reward = summarize(pd.read_csv(Path(folder) / EVALUATION_FILE))["reward"]
        except ValueError:  # networks that are no numbers any more
            reward = -math.inf
    return reward, time.process_time() - began
