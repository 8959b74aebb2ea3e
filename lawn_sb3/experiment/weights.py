"""The networks of a trained model: kept as plain arrays in a file that holds no code, and read back."""

import pickle
import zipfile
from pathlib import Path

import numpy as np
import torch as th
from safetensors.torch import save
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.save_util import load_from_zip_file

from lawn_sb3.errors import UserError, first_line
from lawn_sb3.experiment.run_directory.files import FINISHED_FILE, MODEL_FILE, WEIGHTS_FILE
from lawn_sb3.whole_files import whole_file

MOST_BYTES = 1_000_000
"""Weights that would take more than this in float32 are stored in float16: greedy play may then differ at near ties."""

TARGET = "_target"


def save_weights(model: BaseAlgorithm, path: Path) -> None:
    """Write the networks of a model; target networks and optimisers stay behind.

    :param model: the trained model
    :param path: the file
    """
    arrays = {name: value.numpy() for name, value in _networks(model).items()}
    if sum(array.nbytes for array in arrays.values()) > MOST_BYTES:
        arrays = {name: array.astype(np.float16) for name, array in arrays.items()}
    with whole_file(path) as part:
        np.savez_compressed(part, allow_pickle=False, **arrays)


def save_tensors(model: BaseAlgorithm, path: Path) -> None:
    """Write the networks of a model as safetensors, unrounded; target networks and optimisers stay behind.

    :param model: the trained model
    :param path: the file: tensors by the names that they have in the ``state_dict`` of the policy
    """
    apart = {name: value.contiguous().clone() for name, value in _networks(model).items()}  # none may share memory
    content = save(apart, {"format": "pt"})
    with whole_file(path) as part:
        part.write_bytes(content)


def _networks(model: BaseAlgorithm) -> dict[str, th.Tensor]:
    """The tensors of a policy, in main memory, without those of target networks."""
    return {name: value.detach().cpu() for name, value in model.policy.state_dict().items() if TARGET not in name}


def are_rounded(path: Path) -> bool:
    """Whether kept weights are in half precision, so that greedy play may differ at near ties."""
    with np.load(path, allow_pickle=False) as stored:
        return any(stored[name].dtype == np.float16 for name in stored.files)


def load_weights(model: BaseAlgorithm, path: Path) -> None:
    """Give a model the networks that :func:`save_weights` wrote; target networks become copies of them.

    :param model: a model of the same method
    :param path: the file
    :raises UserError: if the file is missing, damaged or another method's
    """
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name: th.as_tensor(stored[name].astype(np.float32)) for name in stored.files}
        own = model.policy.state_dict()
        model.policy.load_state_dict({name: arrays[name.replace(TARGET, "")] for name in own})
    except FileNotFoundError:
        raise UserError(f"{str(path)!r} is missing") from None
    except KeyError as error:
        raise UserError(f"{str(path)!r} is not a whole model of this method: it lacks {error}") from None
    except (zipfile.BadZipFile, ValueError, RuntimeError, EOFError, OSError, TypeError) as error:
        raise UserError(f"{str(path)!r} is not a whole model of this method: {first_line(error)}") from None


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
    except (zipfile.BadZipFile, ValueError, RuntimeError, KeyError, EOFError, OSError, pickle.UnpicklingError) as error:
        what = f"{str(path)!r} is not a whole model of this method: {first_line(error)}"
        raise UserError(f"{what}; without {str(directory / FINISHED_FILE)!r} the run is made anew") from None
