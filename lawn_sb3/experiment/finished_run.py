"""A finished run read back: its cell, its networks, and the player that it left."""

from __future__ import annotations

import pickle
import zipfile
from collections.abc import Mapping
from pathlib import Path

import yaml
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.save_util import load_from_zip_file

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.players import ModelPlayer
from lawn_sb3.experiment.recipe import Evaluation, Method
from lawn_sb3.experiment.registry import find_player
from lawn_sb3.experiment.run_directory.files import CONFIG_FILE, MODEL_FILE, WEIGHTS_FILE
from lawn_sb3.experiment.weights import load_weights
from lawn_sb3.game.player import Player
from lawn_sb3.scenario import Scenario


def load_run(directory: Path) -> Cell:
    """Read back which cell a run directory holds.

    :param directory: the run
    :return: its cell
    :raises UserError: if it holds no run, or another version's
    """
    path = directory / CONFIG_FILE
    try:
        values = yaml.safe_load(path.read_text(encoding="utf-8"))
        if not isinstance(values["seed"], int) or values["seed"] < 0:
            raise ValueError(f"seed = {values['seed']!r}: a whole number from 0 up")
        return Cell(
            key=values["key"],
            method=Method.model_validate(values["method"]),
            seed=values["seed"],
            scenario=Scenario.model_validate(values["scenario"]),
            evaluation=Evaluation.model_validate(values["evaluation"]),
            directory=directory,
        )
    except OSError as error:
        raise UserError(f"{str(directory)!r} holds no run: {path.name}: {error.strerror}") from None
    except (yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        raise UserError(f"{str(path)!r} is not the configuration of a run: {str(error).splitlines()[0]}") from None


def load_player(cell: Cell, deterministic: bool = True) -> Player:
    """The player that a finished run left.

    The weights alone are read from the model file, never code: the networks are built from the configuration.

    :param cell: the cell
    :param deterministic: greedy actions; otherwise sampled
    :return: the player
    :raises UserError: if the model is missing or damaged
    """
    if cell.method.player is not None:
        return find_player(cell.method.player)
    model = build_model(cell, device="cpu")
    load_networks(model, cell.directory)
    if hasattr(model, "exploration_final_eps"):  # where training left it
        model.exploration_rate = model.exploration_final_eps  # type: ignore[attr-defined]
    return ModelPlayer(model, cell.key, deterministic)


def load_networks(model: BaseAlgorithm, directory: Path) -> None:
    """Give a model the networks that a run left: ``model.zip``, or ``weights.npz`` where there is no such file.

    :param model: a model of the run's method
    :param directory: the run
    :raises UserError: if the file is missing, damaged or another method's
    """
    path = directory / MODEL_FILE
    if not path.exists() and (directory / WEIGHTS_FILE).exists():
        load_weights(model, directory / WEIGHTS_FILE)
        return
    try:
        _, parameters, _ = load_from_zip_file(path, device="cpu", load_data=False)
        model.set_parameters(parameters, device="cpu")
    except FileNotFoundError:
        raise UserError(f"{str(path)!r} is missing: the run has not finished, or its model was not kept") from None
    except (zipfile.BadZipFile, ValueError, RuntimeError, KeyError, EOFError, pickle.UnpicklingError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise UserError(f"{str(path)!r} is not a whole model of this method: {reason}") from None


def trained_players(folder: Path, methods: Mapping[str, str]) -> dict[str, Player]:
    """The players that some methods left, each with the first seed whose networks are kept.

    :param folder: runs of a recipe, ``METHOD/seed-K`` each
    :param methods: the methods, by what to call their players
    :return: greedy players, of those methods that left any
    """
    found: dict[str, Player] = {}
    for name, method in methods.items():
        runs = sorted((folder / method).glob("seed-*"))
        kept = [run for run in runs if (run / MODEL_FILE).exists() or (run / WEIGHTS_FILE).exists()]
        if kept:
            found[name] = load_player(load_run(kept[0]))
    return found
