"""Which games the paper's figures allow together: every reading and a range of grids, with the free constants fitted.

One constant at a time (:mod:`lawn_sb3.paper.identification.identify`) rules out what a change of the others rescues.
Here the free constants follow: the link budget is fitted to R-hat of Random, and omega, rho_col and r_fail to the J of
Random and to what J of CTDE-MAPPO is possible. So those figures can test no reading by themselves. What is left to test
one is success and T-bar of Random and the least T-bar, which depend on flights alone, whether CTDE-MAPPO can have its
R-hat in its T-bar, and whether the constants are any that could be meant.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.game.airspace import moves_inside
from lawn_sb3.game.player import Player, RandomPlayer
from lawn_sb3.game.radio import rate_unit_mbps
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.paper.identification.bounds import Legs, draw_legs, rate_terms_mbps
from lawn_sb3.paper.identification.candidates import PAPER, PRINTED, link_budget_db
from lawn_sb3.paper.identification.findings import SYMBOLS
from lawn_sb3.paper.identification.random_row import LEAST, episode_figures, z_scores
from lawn_sb3.paper.identification.reward import TERMS, reward_terms
from lawn_sb3.paper.printed_values import LATEST_SLOTS, TABLE_II
from lawn_sb3.paper.standard_error import DISFAVOURED_Z, verdict
from lawn_sb3.scenario import Scenario

WIDTHS = (6, 7, 8, 9, 10, 11, 12, 14)
LAYERS = (1, 2, 3, 4, 5, 7)
STEPS_DB = (-8.0, 0.0, 8.0)
"""Around the preset's link budget: where R-hat is taken, to find the budget with which it is the paper's."""
OF_FLIGHTS = ("makespan_slots", "success_percent", LEAST)
"""Figures that no free constant moves, so that they test a reading: T-bar and success of Random, and mean T_min."""
WEIGHTS = ("nav_weight", "collision_penalty", "fail_penalty")
FAR_DB, FAR_FACTOR = 20.0, 10.0
MEANT = {
    "link_budget_db": (link_budget_db(PAPER) - FAR_DB, link_budget_db(PAPER) + FAR_DB),
    **{name: (0.0, FAR_FACTOR * getattr(PAPER, name)) for name in WEIGHTS},
}
"""What a fitted constant must lie between to be one that could be meant: no link budget far from the preset's, no
reward for colliding or failing, and no weight many times the preset's."""
FAR_OFF_Z = 6.0
FEW = 400
"""Episodes that show which readings are farther off than :data:`FAR_OFF_Z` standard errors and are not fitted, and to
which the constants of the others are fitted; what tests them is flown with all."""


class FeasibleRandomPlayer:
    """Every UAV picks, in every slot, one of the moves that stay inside the airspace, uniformly."""

    name = "random-feasible"

    def start(self, simulator: Simulator, rng: np.random.Generator) -> None:
        """Keep the source of randomness."""
        self._rng = rng

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        """Draw the next actions [G, N]."""
        inside = moves_inside(simulator.state.position, simulator.rules.actions, simulator.scenario.grid)
        drawn = np.where(inside, self._rng.random(inside.shape), -1.0)
        return np.asarray(drawn.argmax(axis=-1))


class Reading(NamedTuple):
    """One way to read what the paper leaves open about flights, rates aside."""

    grid: tuple[int, int, int]
    max_voxel_steps: int
    moves: str
    """What Random does at the border: ``clip``, ``hover``, or draws ``feasible`` moves alone."""
    arrived_uav: str
    arrival: str

    @property
    def player(self) -> Player:
        """Random, as it is read."""
        return FeasibleRandomPlayer() if self.moves == "feasible" else RandomPlayer()

    def game(self, **changes: Any) -> Scenario:
        """The preset, read this way."""
        width, length, layers = self.grid
        return PAPER.changed(
            width_voxels=width,
            length_voxels=length,
            max_altitude_m=PAPER.min_altitude_m + layers * PAPER.voxel_size_m,
            max_voxel_steps=self.max_voxel_steps,
            out_of_bounds="hover" if self.moves == "hover" else "clip",
            arrived_uav=self.arrived_uav,
            arrival=self.arrival,
            **changes,
        )


def readings() -> Iterator[Reading]:
    """All readings of all grids, the printed one included; of the printed v_max = 3 and of 2."""
    grids = [(width, width, layers) for width in WIDTHS for layers in LAYERS]
    moves, leaving, arrivals = ("clip", "hover", "feasible"), ("leaves", "stays"), ("slot-end", "fly-through")
    for one in product([*grids, PRINTED.grid], (3, 2), moves, leaving, arrivals):
        yield Reading(*one)


def joint_search(
    episodes: int, seed: int, advance: Callable[[], None], tried: Iterable[Reading] | None = None
) -> pd.DataFrame:
    """Fit the free constants of every reading.

    :param episodes: joint episodes of the Random player for each reading that is not far off
    :param seed: picks the missions
    :param advance: called after each reading
    :param tried: the readings; default: all
    :return: one row for each reading, and for those not far off for each GBS layout and horizon of the bias
        correction: the constants, the figures of Random that test the reading, their distances z, the verdict, and what
        speaks against the game
    """
    preset = episode_figures(evaluate(RandomPlayer(), PAPER, episodes, seed))
    few, rows = min(FEW, episodes), []
    for reading in readings() if tried is None else tried:
        flights = _flights(reading, few, seed, preset)
        if _farthest(flights) > FAR_OFF_Z:
            rows.append(_row(reading, {}, flights))
        else:
            flights = _flights(reading, episodes, seed, preset)
            for layout, horizon in product(("tile-centres", "corners"), ("completion", "deadline")):
                rates = {"gbs_layout": layout, "bias_horizon": horizon}
                constants, against = _fitted(reading, rates, few, seed)
                rows.append(_row(reading, {**rates, **constants}, flights, against))
        advance()
    return pd.DataFrame(rows)


def _flights(reading: Reading, episodes: int, seed: int, preset: pd.DataFrame) -> dict[str, float]:
    """The figures of Random that no free constant moves, and how far they lie from the paper's."""
    figures = episode_figures(evaluate(reading.player, reading.game(), episodes, seed))
    z = z_scores(figures, preset)
    return {name: float(figures[name].mean()) for name in OF_FLIGHTS} | {f"z_{name}": z[name] for name in OF_FLIGHTS}


def _farthest(flights: Mapping[str, float]) -> float:
    """The largest distance of a figure that no free constant moves."""
    return max(abs(flights[f"z_{name}"]) for name in OF_FLIGHTS)


def _fitted(reading: Reading, rates: Mapping[str, str], episodes: int, seed: int) -> tuple[dict[str, float], list[str]]:
    """The constants that give R-hat and J of Random, and J of CTDE-MAPPO if it can be had; what cannot."""
    game, powers = reading.game(**rates), [PAPER.tx_power_dbm + step for step in STEPS_DB]
    means = [
        float(evaluate(reading.player, game.changed(tx_power_dbm=power), episodes, seed)["rate_mbps"].mean())
        for power in powers
    ]
    # Rates are nearly linear in dB: a quadratic through three of them is near enough for the fourth to agree.
    power_dbm = round(float(np.polyval(np.polyfit(means, powers, 2), TABLE_II["Random"].rate_mbps)), 2)
    game = game.changed(tx_power_dbm=power_dbm)
    terms = reward_terms(reading.player, game, episodes, seed)[list(TERMS)].mean()
    weights, against = _weights(game, terms, draw_legs(game, episodes, seed))
    return {"tx_power_dbm": power_dbm, **weights}, against


def _weights(game: Scenario, terms: pd.Series, legs: Legs) -> tuple[dict[str, float], list[str]]:
    """omega, rho_col and r_fail as near to the preset's as J of Random and of CTDE-MAPPO let them; what does not fit.

    omega is the preset's, or the nearest with which CTDE-MAPPO, colliding no more than Random, can have its J; then
    r_fail gives Random its J, and where it would have to be below 0, a smaller rho_col does.
    """
    unit, nav_weight, against = rate_unit_mbps(game), PAPER.nav_weight, []
    printed, random = TABLE_II["CTDE-MAPPO"], TABLE_II["Random"]
    collided = PAPER.collision_penalty * terms["collisions"]
    earned = terms["rate_sum_mbps"] / unit - random.reward  # what progress adds to, and Random's penalties take away
    try:
        least, most = (
            float(rate_terms_mbps(game, legs.min_slots, printed.rate_mbps, LATEST_SLOTS, largest).mean()) / unit
            for largest in (False, True)
        )
    except ValueError:
        against.append("R̂ of CTDE-MAPPO in its T̄")
    else:
        reach, progress = float(legs.distance_voxels.mean()), terms["progress_voxels"]
        # Collisions bring least + omega * reach down to J: at the preset's rho_col, or what r_fail >= 0 leaves of it.
        high = min((printed.reward - least + collided) / reach, (printed.reward - least + earned) / (reach - progress))
        nav_weight = float(np.clip(nav_weight, (printed.reward - most) / reach, high))
    penalties = nav_weight * terms["progress_voxels"] + earned
    collided = min(collided, penalties)
    fitted = (nav_weight, collided / terms["collisions"], (penalties - collided) / terms["failed"])
    return {name: round(float(value), 3) for name, value in zip(WEIGHTS, fitted, strict=True)}, against


def _row(
    reading: Reading, constants: Mapping[str, Any], flights: Mapping[str, float], against: Sequence[str] = ()
) -> dict[str, object]:
    """A row of the table: constants, the figures that test the reading and their distances, and the verdict."""
    reasons = list(against)
    if constants:
        budget_db = link_budget_db(PAPER.changed(tx_power_dbm=constants["tx_power_dbm"]))
        values = {**constants, "link_budget_db": budget_db}
        reasons += [
            f"{name} {values[name]:.4g}" for name, (low, high) in MEANT.items() if not low <= values[name] <= high
        ]
    ruled_out = bool(reasons)
    z = {name: flights[f"z_{name}"] for name in OF_FLIGHTS}
    reasons += [f"{SYMBOLS[name]} (z = {off:+.1f})" for name, off in z.items() if abs(off) > DISFAVOURED_Z]
    return {
        **reading._asdict(),
        **dict.fromkeys(("gbs_layout", "bias_horizon"), "any"),
        **dict.fromkeys(("tx_power_dbm", *WEIGHTS), float("nan")),
        **constants,
        **flights,
        "verdict": "ruled out" if ruled_out else verdict(_farthest(flights)).replace("agrees", "consistent"),
        "against": ", ".join(reasons),
    }
