"""One cell, from nothing to a finished run: train or resume, evaluate, and leave a run directory."""

import shutil
import time
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.logger import Logger

from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.checkpoint import OF_OLD, PENDING, Checkpoints, read_checkpoint, resume_model
from lawn_sb3.experiment.evaluation import evaluate, fly
from lawn_sb3.experiment.model_card import model_card
from lawn_sb3.experiment.players import ModelPlayer
from lawn_sb3.experiment.policy_errors import line_of_user, policy_error
from lawn_sb3.experiment.probe import check_policy
from lawn_sb3.experiment.provenance import provenance
from lawn_sb3.experiment.registry import find_player
from lawn_sb3.experiment.run_directory import files
from lawn_sb3.experiment.run_directory.configuration import is_finished, mark_finished, write_configuration
from lawn_sb3.experiment.run_directory.csv_file import write_rows
from lawn_sb3.experiment.run_directory.log import logged
from lawn_sb3.experiment.run_directory.manifest import write_manifest
from lawn_sb3.experiment.run_directory.progress import ProgressCSV, TensorBoardCurve
from lawn_sb3.experiment.run_directory.writer import only_writer
from lawn_sb3.experiment.watching import Watch
from lawn_sb3.experiment.weights import save_tensors
from lawn_sb3.game.player import Player
from lawn_sb3.whole_files import whole_file, write_json, write_text

CHECKPOINTS = (files.CHECKPOINT_FILE, files.CHECKPOINT_BEFORE_FILE, OF_OLD)


def run_cell(cell: Cell, progress: Callable[[int], None], log: Path | None = None) -> None:
    """Train (or resume) and evaluate a cell, unless its finished run is there.

    :param cell: the cell
    :param progress: called with the env steps trained so far
    :param log: where what is printed goes, and the traceback of a failure; by default, where it always goes
    :raises HeldError: if somebody else is writing the run
    """
    with only_writer(cell.directory), logged(log) if log is not None else nullcontext():
        if not is_finished(cell):
            _run(cell, progress)


def _run(cell: Cell, progress: Callable[[int], None]) -> None:
    checkpoint = claim_directory(cell)
    record = provenance()
    player: Player
    model: BaseAlgorithm | None = None
    if cell.method.player is not None:
        player = find_player(cell.method.player)
        record["train_seconds"] = 0.0
    else:
        model, watch, resumed_at = _train(cell, checkpoint, progress)
        record["resumed_at_env_steps"] = resumed_at
        record["trained_env_steps"] = watch.env_steps
        record["train_seconds"] = round(watch.seconds, 1)
        player = ModelPlayer(model, cell.key, cell.evaluation.deterministic)
    start = time.perf_counter()
    chosen = cell.evaluation
    flights = fly(player, cell.scenario, chosen.episodes, chosen.seed, cell.seed, chosen.traced_episodes)
    for name, rows in zip((files.EVALUATION_FILE, files.SLOTS_FILE, files.PATHS_FILE), flights, strict=True):
        write_rows(cell.directory / name, rows)
    if model is not None and chosen.deterministic:
        sampling = ModelPlayer(model, cell.key, deterministic=False)
        rows = evaluate(sampling, cell.scenario, chosen.episodes, chosen.seed, cell.seed)
        write_rows(cell.directory / files.SAMPLED_FILE, rows)
    record["evaluate_seconds"] = round(time.perf_counter() - start, 1)
    write_json(cell.directory / files.PROVENANCE_FILE, record)
    if model is not None:
        write_text(cell.directory / files.CARD_FILE, model_card(cell, record, flights.rows))
    for name in CHECKPOINTS:  # all that they were for is done
        (cell.directory / name).unlink(missing_ok=True)
    write_manifest(cell.directory, {**record, "configuration": cell.configuration()})
    mark_finished(cell)


def claim_directory(cell: Cell) -> dict[str, Any] | None:
    """Make the run directory the cell's own: what another configuration left goes, a checkpoint to resume stays.

    :param cell: the cell
    :return: the checkpoint, if there is one
    """
    checkpoint = read_checkpoint(cell)
    if checkpoint is None:
        of_model = (files.MODEL_FILE, files.TENSORS_FILE, files.CARD_FILE)
        for name in (files.FINISHED_FILE, files.MANIFEST_FILE, *of_model, *CHECKPOINTS, *files.RESULT_FILES):
            (cell.directory / name).unlink(missing_ok=True)
        shutil.rmtree(cell.directory / files.TENSORBOARD_FOLDER, ignore_errors=True)
    write_configuration(cell)
    return checkpoint


def try_method(cell: Cell) -> None:
    """Build the model of a cell that trains and check its policy, before anything is written."""
    assert cell.method.policy is not None
    check_policy(build_model(cell), cell.method.policy)


def _train(
    cell: Cell, checkpoint: dict[str, Any] | None, progress: Callable[[int], None]
) -> tuple[BaseAlgorithm, Watch, int]:
    """Train a cell from its start or its checkpoint; save the model. Returns it, its watch and where it began."""
    num_uavs, method, folder = cell.scenario.num_uavs, cell.method, cell.directory
    model = build_model(cell) if checkpoint is None else resume_model(cell, checkpoint)
    began = model.num_timesteps // num_uavs
    watch = Watch(cell, progress)
    if checkpoint is not None:
        watch.restore(checkpoint["watch"])
    table = ProgressCSV(folder / files.PROGRESS_FILE, checkpoint["progress"] if checkpoint else "")
    model.set_logger(Logger(str(folder), [table, TensorBoardCurve(folder / files.TENSORBOARD_FOLDER, table.rows)]))
    for name, values in zip(PENDING, checkpoint["pending"] if checkpoint else (), strict=False):
        getattr(model.logger, name).update(values)
    progress(began)
    assert method.policy is not None
    try:
        model.learn(
            total_timesteps=method.env_steps * num_uavs - model.num_timesteps,
            callback=[watch, Checkpoints(cell, watch)],
            log_interval=None,  # type: ignore[arg-type]  # the watch writes the rows
            reset_num_timesteps=checkpoint is None,
        )
    except Exception as error:
        if line_of_user(error, model.policy_class):
            raise policy_error(error, model.policy_class, method.policy) from error
        raise
    model.logger.close()
    check_policy(model, method.policy)  # what training has made of it
    with whole_file(folder / files.MODEL_FILE) as part:
        model.save(part)
    save_tensors(model, folder / files.TENSORS_FILE)
    return model, watch, began
