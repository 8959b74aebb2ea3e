"""What a trajectory is worth: EMA rate, utility, welfare, and the four terms of the reward (Section III)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.compiled import njit


@njit
def ema_rate(previous_mbps: float, rate_mbps: float, beta: float) -> float:
    """Exponential moving average R-bar_i(t) of the rate (eq:ema).

    :param previous_mbps: R-bar_i(t-1), 0 before the first slot
    :param rate_mbps: R_i(t)
    :param beta: smoothing factor in (0, 1)
    :return: R-bar_i(t) in Mbps
    """
    return (1.0 - beta) * previous_mbps + beta * rate_mbps


@njit
def corrected_rate(ema_mbps: float, beta: float, slots: int) -> float:
    """Bias-corrected EMA rate R-hat_i (below eq:utility).

    :param ema_mbps: R-bar_i in Mbps
    :param beta: smoothing factor in (0, 1)
    :param slots: slots averaged over; 0 gives 0
    :return: R-hat_i in Mbps
    """
    if slots == 0:
        return 0.0
    return float(ema_mbps / (1.0 - (1.0 - beta) ** slots))


@njit
def utility(corrected_mbps: float, min_slots: int, slots: int) -> float:
    """Utility U_i of a completed mission (eq:utility).

    :param corrected_mbps: R-hat_i(T_i) in Mbps
    :param min_slots: T_i^min
    :param slots: T_i
    :return: U_i in Mbps
    """
    return corrected_mbps * min_slots / slots


@njit
def slot_weight(beta: float, slots_left: int, least: int, flown: int, horizon: int) -> float:
    """What a rate counts in the utility (eq:utility with eq:ema): U_i is the sum of rates times their weights.

    :param beta: smoothing factor of eq:ema
    :param slots_left: slots between this one and the end of the flight, T_i - t
    :param least: T_i^min
    :param flown: T_i
    :param horizon: slots that the bias correction is over: T_i or T_max
    :return: weight, without unit
    """
    return utility(corrected_rate(ema_rate(0.0, 1.0, beta) * (1.0 - beta) ** slots_left, beta, horizon), least, flown)


def welfare(utilities_mbps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Social welfare W (eq:welfare).

    :param utilities_mbps: U_i of every UAV, 0 for a failed mission [..., N]
    :return: their sum in Mbps [...]
    """
    return np.asarray(np.sum(utilities_mbps, axis=-1))


@njit
def reward_rate(ema_before_mbps: float, ema_after_mbps: float, rate_unit_mbps: float) -> float:
    """Rate-quality reward (eq:reward_rate).

    :param ema_before_mbps: R-bar_i(t)
    :param ema_after_mbps: R-bar_i(t+1)
    :param rate_unit_mbps: unit of rates inside rewards
    :return: its change in that unit
    """
    return (ema_after_mbps - ema_before_mbps) / rate_unit_mbps


@njit
def reward_nav(distance_before: float, distance_after: float, nav_weight: float) -> float:
    """Navigation reward (eq:reward_nav).

    :param distance_before: ||q_i(t) - d_i|| in voxels
    :param distance_after: ||q_i(t+1) - d_i|| in voxels
    :param nav_weight: omega per voxel
    :return: weighted progress
    """
    return nav_weight * (distance_before - distance_after)


@njit
def reward_col(collided: bool, collision_penalty: float) -> float:
    """Collision reward (eq:reward_col).

    :param collided: whether another UAV is in the same voxel at t+1
    :param collision_penalty: rho_col
    :return: minus the penalty, or 0
    """
    return -collision_penalty if collided else 0.0


@njit
def reward_term(
    arrived: bool, timed_out: bool, utility_mbps: float, rate_unit_mbps: float, fail_penalty: float
) -> float:
    """Terminal reward (eq:terminal).

    :param arrived: the destination was reached in time
    :param timed_out: the deadline passed without
    :param utility_mbps: U_i of the completed mission
    :param rate_unit_mbps: unit of utilities inside rewards
    :param fail_penalty: r_fail
    :return: U_i in that unit, minus the penalty, or 0 while flying
    """
    if arrived:
        return utility_mbps / rate_unit_mbps
    return -fail_penalty if timed_out else 0.0
