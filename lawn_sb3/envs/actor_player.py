"""What another project has trained, as a player: scored by the same evaluation as all others."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lawn_sb3.envs.observation import Floats32, Observer
from lawn_sb3.errors import UserError
from lawn_sb3.game.simulator import Simulator


class ActorPlayer:
    """Lets a function that chooses actions for local observations fly.

    :param choose: takes the local observations o_i of all N UAVs of G games, float32 [G, N, local_dim], and gives the
        index of an action for each [G, N], as an array or a tensor
    :param name: what tables call it

    >>> from lawn_sb3.scenario import PRESETS
    >>> simulator = Simulator(PRESETS["tiny"], num_games=3)
    >>> hovering = ActorPlayer(lambda o: np.zeros(o.shape[:2], dtype=np.int64))
    >>> hovering.start(simulator, np.random.default_rng(0))
    >>> hovering.act(simulator).shape
    (3, 2)
    """

    def __init__(self, choose: Callable[[Floats32], ArrayLike], name: str = "actor") -> None:
        self.choose, self.name = choose, name

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Get ready to observe the games.

        :param simulator: the games
        :param rng: not used; the function has its own source, if any
        """
        self._observer = Observer(simulator.scenario)

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Ask the function.

        :param simulator: the games
        :return: indices into the action table [G, N]
        :raises UserError: if it gives something else
        """
        local = self._observer.local(simulator.state)
        actions = np.asarray(self.choose(local))
        if actions.shape != local.shape[:2] or not np.issubdtype(actions.dtype, np.integer):
            raise UserError(
                f"{self.name} gave {actions.dtype} of shape {actions.shape} for observations of shape {local.shape}: "
                f"whole numbers of shape {local.shape[:2]}, one action for each UAV"
            )
        return actions.astype(np.int64)
