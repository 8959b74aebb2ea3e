"""Running one cell: train, save, evaluate, and leave a run directory that tells how it came about."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import yaml
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.logger import Logger, TensorBoardOutputFormat

from lawn_sb3.experiment.checkpoint import PENDING, Checkpoints, checkpoint_path, read_checkpoint, resume_model
from lawn_sb3.experiment.evaluation import evaluate, fly
from lawn_sb3.experiment.players import ModelPlayer, build_model, training_env
from lawn_sb3.experiment.probe import check_policy
from lawn_sb3.experiment.provenance import provenance, whole_file, write_json, write_text
from lawn_sb3.experiment.recipe import NOT_IN_RESULTS, Cell
from lawn_sb3.experiment.registry import find_player
from lawn_sb3.experiment.watching import ProgressCSV, Watch
from lawn_sb3.game.player import Player

FLIGHT_FILES = ("evaluation.csv", "slots.csv", "paths.csv")
"""Where the parts of :class:`lawn_sb3.experiment.evaluation.Flights` go."""
SAMPLED_FILE = "evaluation_sampled.csv"
"""The test missions flown once more by a greedy method, with sampled actions."""
SCALING_FILE = "scaling.csv"
"""What came out with other numbers of UAVs, if the recipe asks for it."""
REGRET_FILE = "regret.csv"
"""What each UAV could have gained by deviating alone, if the recipe asks for it."""
RESULT_FILES = (*FLIGHT_FILES, SAMPLED_FILE, SCALING_FILE, REGRET_FILE, "progress.csv", "provenance.json")
"""All that the report reads, besides the configuration."""


def is_finished(cell: Cell) -> bool:
    """Whether a cell's run is complete and was made with the same configuration.

    :param cell: the cell
    :return: true if there is nothing left to do
    """
    marker = cell.directory / "finished"
    try:
        if marker.read_text(encoding="utf-8").strip() != cell.fingerprint():
            return False
        kept = yaml.safe_load((cell.directory / "config.yaml").read_text(encoding="utf-8"))
        return all(_agree(kept[part], cell.configuration()[part]) for part in ("method", "scenario", "evaluation"))
    except (OSError, ValueError, KeyError, AttributeError, yaml.YAMLError):
        return False


def _agree(kept: dict[str, Any], now: dict[str, Any]) -> bool:
    """Whether the fields that both know have the same values: a changed default is another configuration."""
    return all(kept[name] == now[name] for name in kept.keys() & now.keys() - set(NOT_IN_RESULTS))


def claim_directory(cell: Cell) -> None:
    """Make the run directory the cell's own: what another configuration left in it goes, a checkpoint to resume stays.

    :param cell: the cell
    """
    cell.directory.mkdir(parents=True, exist_ok=True)
    if read_checkpoint(cell) is None:
        for name in ("finished", "model.zip", "checkpoint.pt", *RESULT_FILES):
            (cell.directory / name).unlink(missing_ok=True)
        shutil.rmtree(cell.directory / "tensorboard", ignore_errors=True)
    write_text(cell.directory / "config.yaml", yaml.safe_dump(cell.configuration(), sort_keys=False))


def run_cell(cell: Cell, progress: Callable[[int], None]) -> None:
    """Train (or resume) and evaluate a cell.

    :param cell: the cell
    :param progress: called with the env steps trained so far
    """
    claim_directory(cell)
    record = provenance()
    player: Player
    model: BaseAlgorithm | None = None
    if cell.method.player is not None:
        player = find_player(cell.method.player)
        record["train_seconds"] = 0.0
    else:
        model, watch, resumed_at = _train(cell, progress)
        record["resumed_at_env_steps"] = resumed_at
        record["train_seconds"] = round(watch.seconds, 1)
        player = ModelPlayer(model, cell.key, cell.evaluation.deterministic)
    start = time.perf_counter()
    chosen = cell.evaluation
    flights = fly(player, cell.scenario, chosen.episodes, chosen.seed, cell.seed, chosen.traced_episodes)
    for name, rows in zip(FLIGHT_FILES, flights, strict=True):
        write_rows(cell.directory / name, rows)
    if model is not None and chosen.deterministic:
        sampling = ModelPlayer(model, cell.key, deterministic=False)
        rows = evaluate(sampling, cell.scenario, chosen.episodes, chosen.seed, cell.seed)
        write_rows(cell.directory / SAMPLED_FILE, rows)
    record["evaluate_seconds"] = round(time.perf_counter() - start, 1)
    write_json(cell.directory / "provenance.json", record)
    write_text(cell.directory / "finished", cell.fingerprint() + "\n")
    checkpoint_path(cell).unlink(missing_ok=True)


def try_method(cell: Cell) -> None:
    """Build the model of a cell and check its policy, before anything is written.

    :param cell: a cell whose method trains
    :raises UserError: if the policy breaks a promise, or the algorithm refuses its settings
    """
    assert cell.method.policy is not None
    check_policy(build_model(cell), cell.method.policy)


def write_rows(path: Path, rows: pd.DataFrame) -> None:
    """Write the raw rows of an evaluation in one go.

    :param path: the file
    :param rows: a table of :class:`lawn_sb3.experiment.evaluation.Flights`
    """
    write_text(path, rows_as_text(rows))


def rows_as_text(rows: pd.DataFrame) -> str:
    """Raw rows as they are kept.

    :param rows: a table of :class:`lawn_sb3.experiment.evaluation.Flights`
    :return: CSV with nine digits
    """
    return rows.to_csv(index=False, float_format="%.9g", lineterminator="\n")


def _train(cell: Cell, progress: Callable[[int], None]) -> tuple[BaseAlgorithm, Watch, int]:
    """Train a cell from its start or its checkpoint; save the model. Returns it, its watch and where it began."""
    num_uavs, method = cell.scenario.num_uavs, cell.method
    checkpoint = read_checkpoint(cell)
    model = build_model(cell) if checkpoint is None else resume_model(cell, checkpoint, training_env(cell))
    began = model.num_timesteps // num_uavs
    watch = Watch(cell, progress)
    if checkpoint is not None:
        watch.restore(checkpoint["watch"])
    before = checkpoint["progress"] if checkpoint else ""
    table = ProgressCSV(cell.directory / "progress.csv", before)
    model.set_logger(Logger(str(cell.directory), [table, TensorBoardOutputFormat(str(cell.directory / "tensorboard"))]))
    for name, values in zip(PENDING, checkpoint["pending"] if checkpoint else (), strict=False):
        getattr(model.logger, name).update(values)
    progress(began)
    model.learn(
        total_timesteps=method.env_steps * num_uavs - model.num_timesteps,
        callback=[watch, Checkpoints(cell, watch)],
        log_interval=None,  # type: ignore[arg-type]  # the watch writes the rows
        reset_num_timesteps=checkpoint is None,
    )
    model.logger.close()
    assert method.policy is not None
    check_policy(model, method.policy)  # what training has made of it
    with whole_file(cell.directory / "model.zip") as part:
        model.save(part)
    return model, watch, began
