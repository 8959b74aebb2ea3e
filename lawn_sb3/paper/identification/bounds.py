"""Which J a method with 100 % success can have at all, whatever it flies: a check without any model of the method.

The accumulated reward of a UAV that arrives in slot T >= m = T_i^min is, as Eq. (14), eq:reward, telescopes,

    J_i = nav_weight * ||q_i^0 - d_i|| + R-bar_i(T)/u + U_i/u - collision_penalty * collisions_i
        = nav_weight * ||q_i^0 - d_i|| + R-hat_i * g(T, m)/u - collision_penalty * collisions_i

with the rate unit u and g(T, m) = c(H) + m/T, where c(T) = 1 - (1 - beta)^T and the bias correction has the horizon H,
which is T or T_max: for R-bar_i = R-hat_i c(H), and U_i = R-hat_i m/T by Eq. (9), eq:utility.

The paper prints the means of R-hat_i and of the makespan, which may go along with m in any way. So the bounds are the
smallest and the largest mean of R-hat * g over all distributions of (R-hat, T) for the UAVs of each m that have

- the printed mean of R-hat, each R-hat_i being c(T)/c(H) times an average of rates of single slots: between the
  smallest (floor(K/N) RBs in the worst voxel) and the largest (K RBs in the best);
- m <= T <= T_max, and a mean of T of at most the printed mean makespan, for no UAV is later than the last.

The mean of R-hat * g is linear in R-hat, so that only the two ends of its range matter: a linear program. With H = T
all fly the shortest way at the upper bound. For with x = (1 - beta)^m in (0, 1) and s = T/m >= 1, g(m, m) - g(T, m) is
(1 - 1/s) - (x - x^s), and x - x^s, largest at x = s^(-1/(s-1)), is x (1 - 1/s) <= 1 - 1/s there: g is largest at T = m.
Collisions only lower J, so the upper bound holds with them; the lower one is for a method without.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

from lawn_sb3.experiment.evaluation import evaluation_missions
from lawn_sb3.game.radio import radio_map
from lawn_sb3.scenario import Scenario

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Legs(NamedTuple):
    """How far the missions of some episodes lead."""

    distance_voxels: Floats
    """||q_i^0 - d_i||, Euclidean [E, N]."""
    min_slots: Ints
    """T_i^min [E, N]."""


def draw_legs(scenario: Scenario, episodes: int, seed: int) -> Legs:
    """How far the missions lead that :func:`lawn_sb3.experiment.evaluation.evaluate` flies with this seed."""
    missions = evaluation_missions(scenario, episodes, seed)
    way = missions.destinations - missions.origins
    least = -(-np.abs(way).sum(axis=-1) // scenario.max_voxel_steps)
    return Legs(np.linalg.norm(way, axis=-1), least)


def kept_and_whole(scenario: Scenario, slots: Any) -> tuple[Any, Any]:
    """c(T) = 1 - (1 - beta)^T of flights of T slots, and c(H) of the horizon that their bias correction runs to."""
    kept, whole = (1.0 - (1.0 - scenario.ema_beta) ** end for end in (slots, scenario.max_slots))
    return kept, kept if scenario.bias_horizon == "completion" else whole


def rate_weight(scenario: Scenario, slots: Ints, min_slots: Ints) -> Floats:
    """How often R-hat_i counts in J_i: g(T, m) = c(H) + m / T of the module's text, between 0 and 2."""
    return np.asarray(kept_and_whole(scenario, slots)[1] + min_slots / slots)


def rate_range_mbps(scenario: Scenario) -> tuple[float, float]:
    """The rate of a UAV in one slot at worst, with all others in its cell, and at best, alone in the best voxel."""
    rb_mbps = radio_map(scenario).rb_rate_mbps
    share = int(scenario.num_rbs.min()) // scenario.num_uavs
    return share * float(rb_mbps.min()), int(scenario.num_rbs.max()) * float(rb_mbps.max())


def rate_ceiling_mbps(scenario: Scenario, makespan_slots: float) -> float:
    """The largest mean corrected rate R-hat of a method with 100 % success and a given mean makespan.

    R-hat_i is at most the largest rate of a slot times c(T_i) / c(H). With ``bias_horizon: deadline`` T_i is at most
    its episode's makespan and c grows and is concave, so the mean of c(T_i) is at most c of the mean makespan.

    :param scenario: the scenario
    :param makespan_slots: mean makespan
    :return: the ceiling in Mbps
    """
    kept, whole = kept_and_whole(scenario, makespan_slots)
    return rate_range_mbps(scenario)[1] * float(kept / whole)


def rate_terms_mbps(
    scenario: Scenario, min_slots: Ints, rate_mbps: float, makespan_slots: float, largest: bool
) -> Floats:
    """The least or the largest mean of R-hat_i * g(T_i, m_i), by linear programming (see the module's text).

    :param scenario: its ``ema_beta``, ``bias_horizon``, deadline and link
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
    kept, whole = kept_and_whole(scenario, slots)
    rates = rates * (kept / whole)
    worth = rates * rate_weight(scenario, slots, lengths[of])
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


def rewards(legs: Legs, terms_mbps: Floats, nav_weight: float, unit_mbps: float) -> Floats:
    """J of every UAV that arrives and never collides [E, N], by its terms of :func:`rate_terms_mbps`.

    Only the mean of all is a bound.
    """
    return nav_weight * legs.distance_voxels + terms_mbps / unit_mbps
