"""Which J a method with 100 % success can have at all, whatever it flies: a check without any model of the method.

The accumulated reward of a UAV that arrives in slot T >= m = T_i^min is, since its terms telescope,

    J_i = nav_weight * ||q_i^0 - d_i|| + R-bar_i(T)/u + U_i/u - collision_penalty * collisions_i
        = nav_weight * ||q_i^0 - d_i|| + R-hat_i * g(T, m)/u - collision_penalty * collisions_i

with the rate unit u, b = 1 - beta and g(T, m) = 1 - b^T + m/T, because R-bar_i = R-hat_i (1 - b^T) and
U_i = R-hat_i m/T. (That is the reading ``bias_horizon: completion``.)

The paper prints the means of R-hat_i and of the makespan, which may go along with m in any way. So the bounds are the
smallest and the largest mean of R-hat * g over all distributions of (R-hat, T) for the UAVs of each m that have

- the printed mean of R-hat, each R-hat_i an average of rates of single slots: between the smallest (floor(K/N) RBs in
  the worst voxel) and the largest (K RBs in the best);
- m <= T <= T_max, and a mean of T of at most the printed mean makespan, for no UAV is later than the last.

The mean of R-hat * g is linear in R-hat, so that only the two ends of its range matter: a linear program. At the upper
bound all fly the shortest way. For with x = b^m in (0, 1) and s = T/m >= 1, g(m, m) - g(T, m) is
(1 - 1/s) - (x - x^s), and x - x^s, largest at x = s^(-1/(s-1)), is x (1 - 1/s) <= 1 - 1/s there: g is largest at T = m.
Collisions only lower J, so the upper bound holds with them; the lower one is for a method without.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import linprog

from lawn_sb3.experiment.evaluation import evaluation_missions
from lawn_sb3.game.radio import radio_map, rate_unit_mbps
from lawn_sb3.paper.identification.candidates import ALTERNATIVES, PAPER
from lawn_sb3.paper.printed_values import ROUNDING, TABLE_II
from lawn_sb3.paper.standard_error import DISFAVOURED_Z, RULED_OUT_Z, standard_error
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Legs(NamedTuple):
    """How far the missions of some episodes lead."""

    distance_voxels: Floats
    """||q_i^0 - d_i||, Euclidean [E, N]."""
    min_slots: Ints
    """T_i^min [E, N]."""


class Bounds(NamedTuple):
    """Least and largest mean J of a method that always arrives and never collides."""

    lower: float
    upper: float


def draw_legs(scenario: Scenario, episodes: int, seed: int) -> Legs:
    """The missions that :func:`lawn_sb3.experiment.evaluation.evaluate` flies with this seed.

    :param scenario: the scenario
    :param episodes: number of joint episodes
    :param seed: picks the missions
    :return: their lengths
    """
    missions = evaluation_missions(scenario, episodes, seed)
    way = missions.destinations - missions.origins
    least = -(-np.abs(way).sum(axis=-1) // scenario.max_voxel_steps)
    return Legs(np.linalg.norm(way, axis=-1), least)


def rate_weight(slots: Ints, min_slots: Ints, ema_beta: float) -> Floats:
    """How often R-hat_i counts in J_i: g(T, m) of the module's text.

    :param slots: T_i
    :param min_slots: T_i^min
    :param ema_beta: beta
    :return: 1 - (1 - beta)^T + T_i^min / T_i, between 0 and 2
    """
    return np.asarray(1.0 - (1.0 - ema_beta) ** slots + min_slots / slots)


def rate_range_mbps(scenario: Scenario) -> tuple[float, float]:
    """The smallest and the largest rate a UAV can have in one slot.

    :param scenario: the scenario
    :return: all UAVs in one cell and the worst voxel; alone and in the best voxel
    """
    rb_mbps = radio_map(scenario).rb_rate_mbps
    share = int(scenario.num_rbs.min()) // scenario.num_uavs
    return share * float(rb_mbps.min()), int(scenario.num_rbs.max()) * float(rb_mbps.max())


def rate_ceiling_mbps(scenario: Scenario, makespan_slots: float) -> float:
    """The largest mean corrected rate R-hat of a method with 100 % success and a given mean makespan.

    With ``bias_horizon: deadline`` R-hat_i = R-bar_i / c(T_max), where c(T) = 1 - (1 - beta)^T, and R-bar_i is at most
    the largest rate of a slot times c(T_i). T_i is at most its episode's makespan and c grows and is concave, so the
    mean of c(T_i) is at most c of the mean makespan. With ``completion`` R-hat_i averages rates of slots.

    :param scenario: the scenario
    :param makespan_slots: mean makespan
    :return: the ceiling in Mbps
    """
    highest = rate_range_mbps(scenario)[1]
    if scenario.bias_horizon == "completion":
        return highest
    kept, whole = (1.0 - (1.0 - scenario.ema_beta) ** slots for slots in (makespan_slots, scenario.max_slots))
    return highest * min(kept / whole, 1.0)


def rate_terms_mbps(
    scenario: Scenario, min_slots: Ints, rate_mbps: float, makespan_slots: float, largest: bool
) -> Floats:
    """The least or the largest mean of R-hat_i * g(T_i, m_i), by linear programming (see the module's text).

    :param scenario: its ``ema_beta``, deadline and link
    :param min_slots: T_i^min [E, N]
    :param rate_mbps: mean corrected rate R-hat
    :param makespan_slots: mean makespan
    :param largest: the largest, or the least
    :return: R-hat * g in Mbps for every UAV [E, N], mean over those of equal T_i^min; only the whole mean is a bound
    :raises ValueError: if no method has these means
    """
    lengths, where, counts = np.unique(min_slots, return_inverse=True, return_counts=True)
    of, slots, rates = (
        grid.ravel()
        for grid in np.meshgrid(
            np.arange(len(lengths)), np.arange(1, scenario.max_slots + 1), rate_range_mbps(scenario), indexing="ij"
        )
    )
    early = slots >= lengths[of]
    of, slots, rates = of[early], slots[early], rates[early]
    worth = rates * rate_weight(slots, lengths[of], scenario.ema_beta)
    groups = (of == np.arange(len(lengths))[:, None]).astype(float)
    found = linprog(
        -worth if largest else worth,
        A_ub=slots[None],
        b_ub=[makespan_slots],
        A_eq=np.vstack([groups, rates]),
        b_eq=[*(counts / min_slots.size), rate_mbps],
    )
    if not found.success:
        raise ValueError(f"no method has a mean rate of {rate_mbps:g} Mbps and a makespan of {makespan_slots:g} slots")
    means = (groups @ (worth * found.x)) / (counts / min_slots.size)
    return np.asarray(means[where.reshape(min_slots.shape)])


def reward_bounds(scenario: Scenario, legs: Legs, rate_mbps: float, makespan_slots: float, unit_mbps: float) -> Bounds:
    """Between which values the mean J of a method with 100 % success lies if nobody collides.

    :param scenario: its ``nav_weight``, ``ema_beta``, deadline and link
    :param legs: the missions it flew
    :param rate_mbps: its mean corrected rate R-hat
    :param makespan_slots: its mean makespan
    :param unit_mbps: unit of rates inside rewards
    :return: the bounds
    """
    travelled = scenario.nav_weight * float(legs.distance_voxels.mean())
    ends = (
        rate_terms_mbps(scenario, legs.min_slots, rate_mbps, makespan_slots, largest).mean()
        for largest in (False, True)
    )
    return Bounds(*(travelled + float(end) / unit_mbps for end in ends))


def rate_units_mbps() -> dict[str, float]:
    """Units that rates inside the rewards might have.

    :return: Mbps by name, the preset's first
    """
    alone = rate_unit_mbps(PAPER)
    return {
        "lone UAV one voxel away": alone,
        "lone UAV in the best voxel": rate_range_mbps(PAPER)[1],
        "100 Mbps": 100.0,
        "10 Mbps": 10.0,
        "one RB one voxel away": alone / int(PAPER.num_rbs.max()),
        "1 Mbps": 1.0,
    }


def bounds_table(legs: Legs, random: Mapping[str, float]) -> pd.DataFrame:
    """Which weights of progress, rate units and ``ema_beta`` can give the J of the paper's CTDE-MAPPO row.

    The paper's missions are others than ours: the bounds have the standard error of a mean of its episodes. A choice is
    ruled out if the printed J lies above the upper bound, or if not even a collision of every UAV in every slot of the
    printed T-bar brings the lower bound down to it. It is disfavoured if it takes more collisions than Random has.

    :param legs: missions of the preset
    :param random: means a UAV of Random's reward terms (:data:`lawn_sb3.paper.identification.reward.TERMS`)
    :return: one row for each rate unit with each ``nav_weight``, then for each other ``ema_beta``: the bounds, their
        error, the collisions a UAV needed, the verdict; from which ``nav_weight`` on the paper's J is possible up to
        which without a collision and with Random's, NaN if there is none (sampling error apart); and the
        ``fail_penalty`` with which the choice gives the J of Random too, NaN where its rates are not known
    """
    units, betas = rate_units_mbps(), ALTERNATIVES["ema_beta"]
    weights = (PAPER.nav_weight, *ALTERNATIVES["nav_weight"])
    choices = [(PAPER.ema_beta, name, weight) for name in units for weight in weights]
    choices += [(beta, next(iter(units)), PAPER.nav_weight) for beta in betas]
    printed = TABLE_II["CTDE-MAPPO"]
    longest = printed.makespan_slots + ROUNDING.makespan_slots
    ends = {
        beta: [
            rate_terms_mbps(PAPER.changed(ema_beta=beta), legs.min_slots, printed.rate_mbps, longest, largest)
            for largest in (False, True)
        ]
        for beta in (PAPER.ema_beta, *betas)
    }
    rows: list[dict[str, object]] = []
    for beta, name, weight in choices:
        row = _bounds_row(legs, ends[beta], random, units[name], weight)
        choice = {"rate_unit": name, "rate_unit_mbps": units[name], "nav_weight": weight, "ema_beta": beta}
        rows.append({**choice, "is_preset": not rows, **row})
    table = pd.DataFrame(rows)
    table.loc[table["ema_beta"] != PAPER.ema_beta, "fail_penalty_of_random"] = float("nan")
    return table


def _bounds_row(
    legs: Legs, ends: list[Floats], random: Mapping[str, float], unit_mbps: float, nav_weight: float
) -> dict[str, object]:
    printed, penalty = TABLE_II["CTDE-MAPPO"], PAPER.collision_penalty
    usual, most = penalty * random["collisions"], penalty * printed.makespan_slots
    rewards = [nav_weight * legs.distance_voxels + end / unit_mbps for end in ends]
    error = max(standard_error(pd.Series(reward.mean(axis=1)), ROUNDING.reward) for reward in rewards)
    lower, upper = (float(reward.mean()) for reward in rewards)
    reach = float(legs.distance_voxels.mean())
    weights = [nav_weight + (printed.reward - bound) / reach for bound in (upper, lower, lower - usual)]
    first, last_clean, last = (weight if weight >= 0 else float("nan") for weight in (max(weights[0], 0), *weights[1:]))
    others = nav_weight * random["progress_voxels"] - usual + random["rate_sum_mbps"] / unit_mbps
    return {
        "lower": lower,
        "upper": upper,
        "standard_error": error,
        "collisions_needed": max(lower - printed.reward, 0.0) / penalty,
        "verdict": _verdict(printed.reward, Bounds(lower, upper), usual, most, error),
        "nav_weight_from": first if weights[2] >= 0 else float("nan"),
        "nav_weight_to_without_collisions": last_clean,
        "nav_weight_to": last,
        "fail_penalty_of_random": (others - TABLE_II["Random"].reward) / random["failed"],
    }


def _verdict(reward: float, bounds: Bounds, usual_cost: float, most_cost: float, error: float) -> str:
    above, below = reward - bounds.upper, bounds.lower - reward
    if max(above, below - most_cost) > RULED_OUT_Z * error:
        return "ruled out"
    return "disfavoured" if max(above, below - usual_cost) > DISFAVOURED_Z * error else "agrees"
