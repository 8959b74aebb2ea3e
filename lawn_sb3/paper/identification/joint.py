"""Which games the paper's figures allow together: every reading and a range of grids, with the free constants fitted.

One constant at a time (:mod:`lawn_sb3.paper.identification.identify`) rules out what a change of the others rescues.
Here the free constants follow: the link budget is fitted to R-hat of Random, and omega, rho_col and r_fail to the J of
Random and to what J of CTDE-MAPPO is possible. So those figures can test no reading by themselves. What is left to test
one is success and T-bar of Random and the least T-bar, which depend on flights alone, and whether the constants are any
that could be meant.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
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
from lawn_sb3.paper.identification.bounds import draw_legs, rate_ceiling_mbps, rate_terms_mbps, rewards
from lawn_sb3.paper.identification.candidates import PAPER, PRINTED, link_budget_db
from lawn_sb3.paper.identification.findings import SYMBOLS
from lawn_sb3.paper.identification.random_row import LEAST, TESTED, episode_figures, z_scores
from lawn_sb3.paper.identification.reward import reward_terms
from lawn_sb3.paper.printed_values import ROUNDING, TABLE_II
from lawn_sb3.paper.standard_error import DISFAVOURED_Z, verdict
from lawn_sb3.scenario import Scenario

WIDTHS = (6, 7, 8, 9, 10, 11, 12, 14)
LAYERS = (1, 2, 3, 4, 5, 7)
STEPS_DB = (-8.0, 0.0, 8.0)
"""Around the preset's link budget: where R-hat is taken, to find the budget with which it is the paper's."""
OF_FLIGHTS = ("makespan_slots", "success_percent", LEAST)
"""Figures that no free constant moves, so that they test a reading: T-bar and success of Random, and mean T_min."""
FAR_OFF_Z = 6.0
MEANT = {
    "link_budget_db": (91.0, 131.0),
    "nav_weight": (0.0, 5.0),
    "collision_penalty": (0.0, 20.0),
    "fail_penalty": (0.0, 50.0),
}
"""What a fitted constant must lie between to be one that could be meant: 20 dB and a factor of ten around the preset's,
and no reward for colliding or failing."""
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
    episodes: int, seed: int, progress: Callable[[int, int], None], tried: Sequence[Reading] | None = None
) -> pd.DataFrame:
    """Fit the free constants of every reading.

    :param episodes: joint episodes of the Random player for each reading that is not far off
    :param seed: picks the missions
    :param progress: called with the number of readings done and their total
    :param tried: the readings; default: all
    :return: one row for each reading, and for those not far off for each GBS layout and horizon of the bias
        correction: the figures of Random with the fitted constants, the distances z of those that test the reading, the
        constants, the verdict, and what speaks against it
    """
    tried = list(readings()) if tried is None else tried
    preset = episode_figures(evaluate(RandomPlayer(), PAPER, episodes, seed))
    rows = []
    for done, reading in enumerate(tried, start=1):
        few = min(FEW, episodes)
        figures = episode_figures(evaluate(reading.player, reading.game(), few, seed))
        if _farthest(z_scores(figures, preset)) > FAR_OFF_Z:
            rows.append(_row(reading, figures, z_scores(figures, preset), {}))
        else:
            z = z_scores(episode_figures(evaluate(reading.player, reading.game(), episodes, seed)), preset)
            for layout, horizon in product(("tile-centres", "corners"), ("completion", "deadline")):
                rows.append(_fitted(reading, {"gbs_layout": layout, "bias_horizon": horizon}, few, seed, z))
        progress(done, len(tried))
    return pd.DataFrame(rows)


def _farthest(z: Mapping[str, float]) -> float:
    """The largest distance of a figure that no free constant moves."""
    return max(abs(z[name]) for name in OF_FLIGHTS)


def _fitted(
    reading: Reading, rates: Mapping[str, str], episodes: int, seed: int, z: Mapping[str, float]
) -> dict[str, object]:
    """One reading with the constants that give R-hat and J of Random, and J of CTDE-MAPPO if it can be had."""
    game, power_dbm = reading.game(**rates), PAPER.tx_power_dbm
    powers = [power_dbm + step for step in STEPS_DB]
    means = [
        float(evaluate(reading.player, game.changed(tx_power_dbm=power), episodes, seed)["rate_mbps"].mean())
        for power in powers
    ]
    # Rates are nearly linear in dB: a quadratic through three of them is near enough for the fourth to agree.
    power_dbm = float(np.polyval(np.polyfit(means, powers, 2), TABLE_II["Random"].rate_mbps))
    game = game.changed(tx_power_dbm=round(power_dbm, 2))
    terms = reward_terms(reading.player, game, episodes, seed).drop(columns=["episode", "uav"]).mean()
    fitted, against = _weights(game, terms, episodes, seed)
    game = game.changed(**fitted)
    figures = episode_figures(evaluate(reading.player, game, episodes, seed))
    constants = {name: getattr(game, name) for name in ("gbs_layout", "bias_horizon", "tx_power_dbm", *fitted)}
    return _row(reading, figures, z, constants, against)


def _weights(game: Scenario, terms: pd.Series, episodes: int, seed: int) -> tuple[dict[str, float], list[str]]:
    """omega, rho_col and r_fail as near to the preset's as J of Random and of CTDE-MAPPO let them; what does not fit.

    omega is the preset's, or the nearest with which CTDE-MAPPO can have its J; then r_fail gives Random its J, and
    where it would have to be below 0, rho_col does.
    """
    unit, nav_weight, against = rate_unit_mbps(game), PAPER.nav_weight, []
    printed = TABLE_II["CTDE-MAPPO"]
    latest = printed.makespan_slots + ROUNDING.makespan_slots
    if rate_ceiling_mbps(game, latest) < printed.rate_mbps - ROUNDING.rate_mbps:
        against.append("R̂ of CTDE-MAPPO")
    elif game.bias_horizon == "completion":  # the bounds on J are for this reading
        legs = draw_legs(game, episodes, seed)
        try:
            most, least = (
                rewards(legs, rate_terms_mbps(game, legs.min_slots, printed.rate_mbps, latest, largest), 0.0, unit)
                for largest in (True, False)
            )
        except ValueError:
            against.append("R̂ and T̄ of CTDE-MAPPO")
        else:
            reach, collided = float(legs.distance_voxels.mean()), PAPER.collision_penalty * terms["collisions"]
            low, high = ((printed.reward - end) / reach for end in (most.mean(), least.mean() - collided))
            nav_weight = float(np.clip(nav_weight, low, high))
    others = nav_weight * terms["progress_voxels"] + terms["rate_sum_mbps"] / unit - TABLE_II["Random"].reward
    collision_penalty = PAPER.collision_penalty
    fail_penalty = (others - collision_penalty * terms["collisions"]) / terms["failed"]
    if fail_penalty < 0.0:
        fail_penalty, collision_penalty = 0.0, others / terms["collisions"]
    fitted = {"nav_weight": nav_weight, "collision_penalty": collision_penalty, "fail_penalty": fail_penalty}
    against += [f"{name} {value:.2f}" for name, value in fitted.items() if value < 0.0]
    return {name: round(max(value, 0.0), 3) for name, value in fitted.items()}, against


def _row(
    reading: Reading,
    figures: pd.DataFrame,
    z: Mapping[str, float],
    constants: Mapping[str, object],
    against: Sequence[str] = (),
) -> dict[str, object]:
    """A row of the table: figures, distances of those that test the reading, constants, and the verdict."""
    reasons = list(against)
    if constants:
        budget_db = link_budget_db(PAPER.changed(tx_power_dbm=constants["tx_power_dbm"]))
        values: dict[str, Any] = {**constants, "link_budget_db": budget_db}
        reasons += [
            f"{name} {values[name]:.4g}" for name, (low, high) in MEANT.items() if not low <= values[name] <= high
        ]
    ruled_out = bool(reasons)
    reasons += [f"{SYMBOLS[name]} (z = {z[name]:+.1f})" for name in OF_FLIGHTS if abs(z[name]) > DISFAVOURED_Z]
    return {
        **reading._asdict(),
        **dict.fromkeys(("gbs_layout", "bias_horizon"), "any"),
        **dict.fromkeys(("tx_power_dbm", "nav_weight", "collision_penalty", "fail_penalty"), float("nan")),
        **constants,
        **{name: float(figures[name].mean()) for name in TESTED},
        **{f"z_{name}": z[name] for name in OF_FLIGHTS},
        "verdict": "ruled out" if ruled_out else verdict(_farthest(z)).replace("agrees", "consistent"),
        "against": ", ".join(reasons),
    }
