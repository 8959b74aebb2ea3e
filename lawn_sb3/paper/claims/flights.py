"""Claims that take flights of their own: what an actor reads, and what hovering gives."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.envs import Observer
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.players import ModelPlayer, load_player
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.paper.claims.claim import CannotTellError, Evidence, Finding
from lawn_sb3.paper.claims.comparisons import combine
from lawn_sb3.paper.claims.table_rows import FAR
from lawn_sb3.paper.printed_values import TABLE_II, TEST_EPISODES
from lawn_sb3.planning import ShortestPathPlayer

GAMES, SLOTS, NOISES = 50, 10, 20
"""Observations of an actor's test: games, slots of random play before, and times that x is replaced."""


def ignores_state(evidence: Evidence, of: list[str]) -> Finding:
    """Whether trained actors act on o_i alone: the global state is replaced by noise, the actions must not change.

    :param evidence: what the runs left
    :param of: the parts; of each the first seed that was read
    :return: the finding
    :raises CannotTellError: if a trained model was not kept
    """
    flat, state = _observations(evidence)
    rng = np.random.default_rng(evidence.results.recipe.evaluation.seed)
    figures, held = [], []
    for role in of:
        model = _trained(evidence, role).model
        before, _ = model.predict(flat, deterministic=True)
        changed = 0
        for _ in range(NOISES):
            noisy = flat.copy()
            noisy[:, state] = rng.normal(0.0, 10.0, noisy[:, state].shape)
            after, _ = model.predict(noisy, deterministic=True)
            changed += int((after != before).sum())
        figures.append(f"{evidence.label(role)}: {changed:,}")
        held.append(changed == 0)
    return Finding(
        combine(held),
        f"actions changed by noise in x, of {NOISES * len(flat):,} each: {'; '.join(figures)}",
        "No action may change. That o_i itself holds the loads {n_b} of all cells, which the GBSs would have to "
        "broadcast, is not counted as communication here.",
    )


def _observations(evidence: Evidence) -> tuple[NDArray[np.float32], slice]:
    """Observations [B, flat_dim] after some slots of random play, and the columns of x in them."""
    recipe = evidence.results.recipe
    simulator = Simulator(recipe.game(), GAMES, seed=recipe.evaluation.seed)
    rng = np.random.default_rng(recipe.evaluation.seed)
    for _ in range(SLOTS):
        simulator.step(rng.integers(0, simulator.num_actions, simulator.state.flying.shape))
        simulator.go_on()
    observer = Observer(recipe.game())
    return observer.flat(simulator.state).reshape(-1, observer.layout.flat_dim), observer.layout.state


def _trained(evidence: Evidence, role: str) -> ModelPlayer:
    key = evidence.key(role)
    seed = evidence.results.seeds(key)[0]
    cell = next((cell for cell in evidence.cells if (cell.key, cell.seed) == (key, seed)), None)
    if cell is None:
        raise CannotTellError(f"needs the trained model of {evidence.label(role)}")
    try:
        player = load_player(cell)
    except UserError as error:
        raise CannotTellError(f"needs the trained model of {evidence.label(role)}: {error}") from None
    assert isinstance(player, ModelPlayer)
    return player


class HoveringPlayer:
    """Some UAVs fly straight to their destinations, the others to the best voxel within one slot, where they stay.

    The best voxel is the one that promises the highest rate by the cell loads at the start, as if nobody else moved.

    :param share_flying: share of the UAVs that fly, drawn one by one
    """

    name = "hover"

    def __init__(self, share_flying: float) -> None:
        self.share_flying = share_flying
        self._straight = ShortestPathPlayer()

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Draw who flies, and find where the others hover.

        :param simulator: the games
        :param rng: source of the draw
        """
        rules, state = simulator.rules, simulator.state
        ends = np.clip(state.position[:, :, None] + rules.actions, 0, np.array(rules.grid) - 1)  # [G, N, A, 3]
        x, y, z = np.moveaxis(ends, -1, 0)
        cell = rules.cell[x, y, z]  # [G, N, A]
        # Action 0 hovers, so that its cell is the own one, whose load counts this UAV already.
        load = state.cell_load[np.arange(len(cell))[:, None, None], cell] + (cell != cell[..., :1])
        # Of several moves to the best voxel the first is the shortest, which stays inside.
        self._next = (rules.num_rbs[cell] // load * rules.rb_rate_mbps[x, y, z]).argmax(axis=-1)  # [G, N]
        self._flies = rng.random(state.flying.shape) < self.share_flying
        self._straight.start(simulator, rng)

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Move once to hover, or on to the destination.

        :param simulator: the games
        :return: indices into the action table [G, N]
        """
        move = np.where(self._flies, self._straight.act(simulator), self._next)
        self._next = np.zeros_like(self._next)  # action 0 hovers
        return move


def hovering_explains_rate(evidence: Evidence, row: str, role: str) -> Finding:
    """Whether UAVs that hover near their start can have the corrected rate that the paper prints of a failing method.

    :param evidence: what the runs left
    :param row: the method's row in Table II
    :param role: its part, whose own runs are told beside, where there are any, and decide nothing
    :return: the finding
    """
    recipe, printed = evidence.results.recipe, TABLE_II[row]
    player = HoveringPlayer(printed.success_percent / 100.0)
    rows = evaluate(player, recipe.game(), recipe.evaluation.episodes, recipe.evaluation.seed)
    rates = rows.groupby("episode")["rate_mbps"].mean()
    error = float(np.nan_to_num(rates.std(ddof=1))) * np.sqrt(1 / len(rates) + 1 / TEST_EPISODES)
    short = printed.rate_mbps - float(rates.mean())
    explained = short <= FAR * error
    return Finding(
        "reproduced" if explained else "not reproduced",
        f"R̂ {rates.mean():.1f} ± {error:.1f} Mbps (one standard error; paper {printed.rate_mbps:g}) where "
        f"{printed.success_percent:g} % of the UAVs fly straight, and all others hover within one slot of their "
        "origin, where link and loads, as seen at the start, promise most",
        "Hovering near the start has to give the printed rate, within three standard errors: "
        + ("it can, so the explanation is possible" if explained else f"it falls short by {short:.1f} Mbps")
        + _own_rate(evidence, role, printed.rate_mbps - FAR * error),
    )


def _own_rate(evidence: Evidence, role: str, at_least_mbps: float) -> str:
    """End of a sentence: whether our own runs of a method show the rate that another explains."""
    if role not in evidence.roles:
        return "."
    rate, success = (float(evidence.scores(role, name).mean()) for name in ("rate_mbps", "success_percent"))
    shown = "shows the rate" if rate >= at_least_mbps else "does not show it"
    return f"; our own {evidence.label(role)} {shown}: R̂ {rate:.1f} Mbps, success {success:.1f} %."
