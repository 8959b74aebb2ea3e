"""Runs wherever they lie: which there are below a folder, how each stands, and which of them can be compared."""

import json
from collections.abc import Collection, Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.experiment.run_directory.configuration import is_finished, load_finished_run, load_run
from lawn_sb3.experiment.run_directory.files import (
    CHECKPOINT_BEFORE_FILE,
    CHECKPOINT_FILE,
    CONFIG_FILE,
    FINISHED_FILE,
    PROVENANCE_FILE,
)
from lawn_sb3.experiment.run_directory.reading import read_evaluation
from lawn_sb3.experiment.run_directory.writer import who_writes
from lawn_sb3.results.pairing import Marks
from lawn_sb3.results.results import score_matrix
from lawn_sb3.results.statistics import Interval, Tested, crossed_t, mean_interval, mean_t, paired_p, paired_t

COMPARED = ("reward", "rate_mbps", "makespan_slots", "success_percent", "utility_mbps")
"""Quantities that a comparison shows."""
DIFFERENCES = ("reward", "utility_mbps")
"""Those of which it shows differences too."""


class Listed(NamedTuple):
    """A run in a list."""

    run: str
    """Its folder."""
    method: str
    """Its key."""
    flown_by: str
    """Algorithm and policy, or the player."""
    game: str
    seed: int | None
    state: str
    """``finished``; ``running``; ``interrupted``, with a checkpoint; ``begun``, without; or why it cannot be read."""
    reward: float | None
    utility_mbps: float | None
    success_percent: float | None
    began: str | None
    """When it was begun: ISO 8601."""


def runs_below(folder: Path, trusted: Collection[str] = ()) -> Iterator[Listed]:
    """List the runs in a folder and in all folders below it, by their paths.

    :param folder: where to look
    :param trusted: policies that runs may name though they do not come with the kit
    :return: every run
    :raises UserError: if there is no such folder
    """
    if not folder.is_dir():
        raise UserError(f"{str(folder)!r} is no folder")
    for path in sorted(folder.rglob(CONFIG_FILE)):
        yield _listed(path.parent, trusted)


def _listed(run: Path, trusted: Collection[str]) -> Listed:
    try:
        cell = load_run(run, trusted)
    except UserError as error:
        return Listed(str(run), "", "", "", None, str(error), None, None, None, _began(run))
    method = cell.method
    state, figures = _state(cell), dict[str, float]()
    if state == "finished":
        try:
            figures = summarize(read_evaluation(cell))
        except UserError as error:
            state = str(error)
    return Listed(
        run=str(run),
        method=cell.key,
        flown_by=method.player or f"{method.algo}, {method.policy}",
        game=cell.scenario.title,
        seed=cell.seed,
        state=state,
        reward=figures.get("reward"),
        utility_mbps=figures.get("utility_mbps"),
        success_percent=figures.get("success_percent"),
        began=_began(run),
    )


def _state(cell: Cell) -> str:
    run = cell.directory
    if who_writes(run) is not None:
        return "running"
    if (run / FINISHED_FILE).exists():
        return "finished" if is_finished(cell) else "finished, but its policy or the version has changed since"
    checkpoints = (run / name for name in (CHECKPOINT_FILE, CHECKPOINT_BEFORE_FILE))
    return "interrupted" if any(path.exists() for path in checkpoints) else "begun"


def _began(run: Path) -> str:
    """When a run was begun: by its own words, or by its first file."""
    try:
        return str(json.loads((run / PROVENANCE_FILE).read_text(encoding="utf-8"))["started"])
    except (OSError, ValueError, KeyError, TypeError):  # it has not come so far
        since = datetime.fromtimestamp((run / CONFIG_FILE).stat().st_mtime, UTC)
        return since.isoformat(timespec="seconds")


class Contestant(NamedTuple):
    """Runs of one method that differ in their seeds alone."""

    key: str
    title: str
    seeds: list[int]
    rows: pd.DataFrame
    """The raw rows of all of them, with the columns ``method``, which is the title, and ``seed``."""

    def scores(self, name: str) -> NDArray[np.float64]:
        """One column of the evaluations, means over the UAVs of an episode [S, E]."""
        return score_matrix(self.rows, self.title, name)

    def mean(self, name: str) -> Interval:
        """Its mean: bootstrap interval over seeds, or Student's t over missions where there is one seed."""
        scores = self.scores(name)
        return mean_t(scores[0]) if len(scores) == 1 else mean_interval(scores.mean(axis=1))

    def beyond(self, other: "Contestant", name: str) -> Tested:
        """Its mean less that of another on the same missions.

        Where both have several seeds other seeds and other missions count, else the missions alone, in pairs.
        """
        own, others = self.scores(name), other.scores(name)
        if min(len(own), len(others)) > 1:
            return crossed_t(own, others)
        missions = own.mean(axis=0), others.mean(axis=0)
        return Tested(paired_t(*missions), paired_p(*missions))


def contestants(folders: Sequence[Path], trusted: Collection[str] = ()) -> list[Contestant]:
    """Read runs that are to be compared.

    :param folders: each a finished run, or a folder of finished runs that differ in their seeds alone
    :param trusted: policies that they may name though they do not come with the kit
    :return: who is compared, in the same order
    :raises UserError: if a run is not finished, or they have not flown the same missions
    """
    groups = [[load_finished_run(run, trusted) for run in _runs_in(folder)] for folder in folders]
    first = groups[0][0]
    for folder, group in zip(folders, groups, strict=True):
        for cell in group:
            if cell.method != group[0].method:
                raise UserError(f"{str(folder)!r} holds runs of several methods: name one folder for each")
            flown, others = _missions(cell), _missions(first)
            if flown != others:
                raise UserError(
                    f"{str(cell.directory)!r} has flown other missions than {str(first.directory)!r}: {flown}, not "
                    f"{others}; lawn-sb3 evaluate flies any run on any"
                )
        seeds = [cell.seed for cell in group]
        if len(set(seeds)) < len(seeds):
            raise UserError(f"{str(folder)!r} holds two runs of the same seed")
    titles = _titles([group[0].method.label for group in groups], [str(folder) for folder in folders])
    return [_contestant(group, title) for group, title in zip(groups, titles, strict=True)]


def marks_among(compared: Sequence[Contestant]) -> tuple[Marks, dict[tuple[str, str], Tested]]:
    """All differences to the first of some contestants, and which of them count among so many.

    :param compared: at least two
    :return: the marks, and the differences by title and quantity
    """
    first, *others = compared
    tests = {(one.title, name): one.beyond(first, name) for one in others for name in DIFFERENCES}
    return Marks(list(tests.values())), tests


def _runs_in(folder: Path) -> list[Path]:
    if (folder / CONFIG_FILE).exists():
        return [folder]
    runs = sorted(path.parent for path in folder.glob(f"*/{CONFIG_FILE}"))
    if not runs:
        raise UserError(f"{str(folder)!r} holds no run: {CONFIG_FILE} is neither in it nor in a folder in it")
    return runs


def _missions(cell: Cell) -> str:
    chosen = cell.evaluation
    return f"{chosen.episodes} episodes of seed {chosen.seed} on {cell.scenario.title!r}"


def _titles(labels: Sequence[str], folders: Sequence[str]) -> list[str]:
    """Labels, and those that several have with their folders."""
    pairs = zip(labels, folders, strict=True)
    return [f"{label} ({folder})" if labels.count(label) > 1 else label for label, folder in pairs]


def _contestant(group: Sequence[Cell], title: str) -> Contestant:
    tables = [read_evaluation(cell).assign(method=title, seed=cell.seed) for cell in group]
    return Contestant(group[0].key, title, [cell.seed for cell in group], pd.concat(tables, ignore_index=True))
