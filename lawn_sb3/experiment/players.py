"""Trained models as players, and finished runs read back."""

from __future__ import annotations

import pickle
import zipfile
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from sb3_contrib import MaskablePPO
from sb3_contrib.common.maskable.policies import MaskableActorCriticPolicy
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.save_util import load_from_zip_file

from lawn_sb3.algos.iql import IQL, InTimeQPolicy
from lawn_sb3.algos.qmix import InTimeQMIXPolicy
from lawn_sb3.envs import FlatVecEnv, ObservationLayout, Observer, make_vec_env
from lawn_sb3.envs.observation import EXTRAS, NOT_BY_N
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.find_policy import find_policy
from lawn_sb3.experiment.probe import line_in_own_file, policy_error
from lawn_sb3.experiment.recipe import Cell, Evaluation, Method
from lawn_sb3.experiment.registry import find_algorithm, find_player
from lawn_sb3.experiment.run_directory.files import CONFIG_FILE, MODEL_FILE, WEIGHTS_FILE
from lawn_sb3.experiment.weights import load_weights
from lawn_sb3.game.player import Player
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.scenario import Scenario


class ModelPlayer:
    """A trained model as a player.

    :param model: any SB3 model over the flat observation [o_i | x]
    :param name: what tables call it
    :param deterministic: greedy actions; otherwise sampled
    """

    def __init__(self, model: BaseAlgorithm, name: str, deterministic: bool = True) -> None:
        self.model = model
        self.name = name
        self.deterministic = deterministic

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Get ready to observe the games; sampled actions are seeded.

        The games may have another number of UAVs than the model was trained with, as o_i is the same for every N: the
        model is then given zeros for x, which no actor reads.

        :param simulator: the games
        :param rng: source of the seed
        :raises UserError: if the model cannot play these games
        """
        self._layout = training_layout(self.model)
        self._observer = Observer(simulator.scenario, self._layout.extras)
        self._is_moved = self._observer.layout != self._layout
        if self._is_moved and not (can_be_moved(self.model) and self._same_cells()):
            trained, asked = (
                f"{layout.num_uavs} UAVs and {layout.num_gbs} GBSs" for layout in (self._layout, self._observer.layout)
            )
            raise UserError(f"{self.name} was trained for {trained} and cannot play with {asked}")
        self._memory: Any = None
        self._slack = training_slack(self.model)
        if not self.deterministic:
            self.model.set_random_seed(int(rng.integers(2**31)))

    def _same_cells(self) -> bool:
        return self._observer.layout.num_gbs == self._layout.num_gbs

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Ask the model.

        :param simulator: the games
        :return: indices into the action table [G, N]
        """
        state = simulator.state
        flat = self._observer.flat(state)
        if self._is_moved:
            seen = flat[..., self._observer.layout.seen(())]
            flat = np.zeros((*seen.shape[:2], self._layout.flat_dim), dtype=np.float32)
            flat[..., self._layout.seen(())] = seen
        more: dict[str, Any] = {}
        if isinstance(self.model, MaskablePPO):
            masks = simulator.allowed_moves(self._slack)
            more["action_masks"] = masks.reshape(-1, simulator.num_actions)
        actions, self._memory = self.model.predict(
            flat.reshape(-1, flat.shape[-1]),
            state=self._memory,
            episode_start=(state.slot == 0).ravel(),
            deterministic=self.deterministic,
            **more,
        )
        return np.asarray(actions, dtype=np.int64).reshape(flat.shape[:2])


def training_layout(model: BaseAlgorithm) -> ObservationLayout:
    """What the observations of a model look like.

    :param model: a model with its training environment
    :return: their layout
    """
    assert model.env is not None
    layout: ObservationLayout = model.env.get_attr("layout", [0])[0]
    return layout


def training_slack(model: BaseAlgorithm) -> int | None:
    """The slack that a model's moves were held to in training.

    :param model: a model with its training environment
    :return: slots; none if its moves need not be in time
    """
    assert model.env is not None
    slack: int | None = model.env.get_attr("slack", [0])[0]
    return slack


def can_be_moved(model: BaseAlgorithm) -> bool:
    """Whether the actor of a model can be flown with another number of UAVs than it was trained with.

    :param model: a model with its training environment
    :return: false if its networks belong to single UAVs, or know them by their index
    """
    sees = {*training_layout(model).extras, *getattr(model.policy, "sees", ())}
    return not isinstance(model, IQL) and NOT_BY_N.issuperset(sees)


def training_env(cell: Cell) -> FlatVecEnv:
    """The environment that a cell is trained in.

    :param cell: the cell
    :return: its vector environment
    """
    method = cell.method
    assert method.policy is not None
    policy = find_policy(method.policy)
    return make_vec_env(
        cell.scenario,
        method.num_games,
        seed=cell.seed,
        continuation=method.continuation,
        without_reward=method.without_reward,
        extras=[extra for extra in EXTRAS if extra in getattr(policy, "sees", ())],
        slack=method.slack,
        credit=method.credit,
        fewest_uavs=method.fewest_uavs,
    )


def build_model(cell: Cell, **arguments: Any) -> BaseAlgorithm:
    """Build the untrained model of a cell, with its training environment.

    :param cell: the cell
    :param arguments: what else to give the algorithm
    :return: the model
    :raises UserError: if the policy cannot be built, or the algorithm refuses its settings
    """
    method = cell.method
    assert method.algo is not None
    assert method.policy is not None
    policy = find_policy(method.policy)
    algorithm = find_algorithm(method.algo, policy)
    masked = (MaskableActorCriticPolicy, InTimeQMIXPolicy, InTimeQPolicy)
    if method.slack is not None and not issubclass(policy, masked):
        raise UserError(
            f"method {cell.key!r}: policy {method.policy} knows no in-time moves: no slack; those that derive from "
            "MaskableCTDEPolicy, InTimeQMIXPolicy or InTimeQPolicy do"
        )
    settings = {"device": "cpu", **method.arguments(), **arguments}
    try:
        return algorithm(policy, training_env(cell), seed=cell.seed, **settings)
    except UserError:
        raise
    except Exception as error:
        if isinstance(error, NotImplementedError) or line_in_own_file(error, policy) is not None:
            raise policy_error(error, policy, method.policy) from error
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise UserError(f"method {cell.key!r}: {method.algo} refuses its settings: {reason}") from error


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


def trained_players(folder: Path, rows: Collection[str]) -> dict[str, Player]:
    """The first trained player that is kept for some rows of the paper's Table II.

    :param folder: runs of a recipe, ``METHOD/seed-K`` each; of two methods for a row the last in alphabetical order
        counts, which for the names in ``runs/paper.yaml`` is the paper's own critic
    :param rows: the rows
    :return: greedy players by row
    """
    found: dict[str, Player] = {}
    for method in sorted(path for path in folder.iterdir() if path.is_dir()):
        for run in sorted(method.glob("seed-*")):
            if not (run / MODEL_FILE).exists() and not (run / WEIGHTS_FILE).exists():
                continue
            cell = load_run(run)
            if cell.method.algo is not None and cell.method.paper_row in rows:
                assert cell.method.paper_row is not None
                found[cell.method.paper_row] = load_player(cell)
                break
    return found
