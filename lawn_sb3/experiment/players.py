"""Trained models as players, of this process or of a finished run."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sb3_contrib import MaskablePPO
from stable_baselines3.common.base_class import BaseAlgorithm

from lawn_sb3.algos.iql import IQL
from lawn_sb3.envs import ObservationLayout, Observer
from lawn_sb3.envs.observation import NOT_BY_N
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import fits_all_games
from lawn_sb3.experiment.registry import find_player
from lawn_sb3.experiment.run_directory.configuration import load_run
from lawn_sb3.experiment.run_directory.files import MODEL_FILE, WEIGHTS_FILE
from lawn_sb3.experiment.weights import load_networks
from lawn_sb3.game.player import Player
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.game.state import State
from lawn_sb3.scenario import Scenario

FEWEST_ASKED = 4
"""Games that a model is asked about at least: with three rows or fewer BLAS may add in another order, and the last bits
of the answers be others."""


class ModelPlayer:
    """A trained model as a player.

    :param model: any SB3 model over the flat observation [o_i | x], with its training environment
    :param name: what tables call it
    :param deterministic: greedy actions; otherwise sampled
    """

    def __init__(self, model: BaseAlgorithm, name: str, deterministic: bool = True) -> None:
        assert model.env is not None
        self.model, self.name, self.deterministic = model, name, deterministic
        self._layout: ObservationLayout = model.env.get_attr("layout", [0])[0]
        self._slack: int | None = model.env.get_attr("slack", [0])[0]

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Get ready to observe the games; sampled actions are seeded.

        The games may have another number of UAVs than the model was trained with, as o_i is the same for every N: the
        model is then given zeros for x, which no actor reads.

        :param simulator: the games
        :param rng: source of the seed
        :raises UserError: if the model cannot play these games
        """
        trained = self._layout
        self._observer = Observer(simulator.scenario, trained.extras)
        asked = self._observer.layout
        self._is_moved = asked != trained
        if self._is_moved and not (self._knows_no_single_uavs() and asked.num_gbs == trained.num_gbs):
            sizes = (f"{layout.num_uavs} UAVs and {layout.num_gbs} GBSs" for layout in (trained, asked))
            raise UserError(f"{self.name} was trained for {' and cannot play with '.join(sizes)}")
        self._memory: Any = None
        if not self.deterministic:
            self.model.set_random_seed(int(rng.integers(2**31)))

    def _knows_no_single_uavs(self) -> bool:
        """Whether no network belongs to a single UAV, or knows it by its index."""
        sees = {*self._layout.extras, *getattr(self.model.policy, "sees", ())}
        return not isinstance(self.model, IQL) and NOT_BY_N.issuperset(sees)

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Ask the model, if it is greedy and remembers nothing only about games in which somebody flies.

        :param simulator: the games
        :return: indices into the action table [G, N]; 0 in games that the model was not asked about
        """
        state = simulator.state
        flat = self._flat(state)
        asked = self._asked(np.asarray(state.flying.any(axis=1)))
        more: dict[str, Any] = {}
        if isinstance(self.model, MaskablePPO):
            masks = simulator.allowed_moves(self._slack)[asked]
            more["action_masks"] = masks.reshape(-1, simulator.num_actions)
        answers, self._memory = self.model.predict(
            flat[asked].reshape(-1, flat.shape[-1]),
            state=self._memory,
            episode_start=(state.slot == 0)[asked].ravel(),
            deterministic=self.deterministic,
            **more,
        )
        actions = np.zeros(flat.shape[:2], dtype=np.int64)
        actions[asked] = np.reshape(answers, (-1, flat.shape[1]))
        return actions

    def _flat(self, state: State) -> NDArray[np.float32]:
        """Observations as the model knows them [G, N, flat_dim]."""
        if not self._is_moved:
            return self._observer.flat(state)
        seen = self._observer.seen(state)
        flat = np.zeros((*seen.shape[:2], self._layout.flat_dim), dtype=np.float32)
        flat[..., self._layout.seen(())] = seen
        return flat

    def _asked(self, flies: NDArray[np.bool_]) -> NDArray[np.int64]:
        """The games to ask about, in order: all, where what is drawn or remembered depends on how many there are."""
        if not self.deterministic or self._memory is not None:
            return np.arange(len(flies))
        return np.sort(np.argsort(~flies, kind="stable")[: max(int(flies.sum()), FEWEST_ASKED)])


def load_player(cell: Cell, deterministic: bool = True, game: Scenario | None = None) -> Player:
    """The player that a finished run left.

    The weights alone are read from the model file, never code: the networks are built from the configuration.

    :param cell: the cell
    :param deterministic: greedy actions; otherwise sampled
    :param game: the game that it is to fly, if it is another one; networks that fit all games are built for it
    :return: the player
    :raises UserError: if the model is missing or damaged
    """
    if cell.method.player is not None:
        return find_player(cell.method.player)
    if game is not None and fits_all_games(cell.method):
        # Nobody trains in it: one game will do, and one UAV.
        method = cell.method.model_copy(update={"num_games": 1, "fewest_uavs": None})
        cell = replace(cell, scenario=game.changed(num_uavs=1), method=method)
    model = build_model(cell, device="cpu")
    load_networks(model, cell.directory)
    if hasattr(model, "exploration_final_eps"):  # where training left it
        model.exploration_rate = model.exploration_final_eps  # type: ignore[attr-defined]
    return ModelPlayer(model, cell.key, deterministic)


def kept_player(folder: Path) -> Player | None:
    """The trained player of a method, by the first seed whose model is kept.

    :param folder: its runs, ``seed-K`` each
    :return: the player, greedy; none if no model is kept
    """
    for run in sorted(folder.glob("seed-*")):
        if (run / MODEL_FILE).exists() or (run / WEIGHTS_FILE).exists():
            return load_player(load_run(run))
    return None
