"""What a trajectory is worth: EMA rate, utility, welfare, and the four terms of the reward (Sections III and IV-A)."""

import numpy as np
from numpy.typing import NDArray

from lawn_sb3.game.compiled import njit


@njit
def ema_rate(previous_mbps: float, rate_mbps: float, beta: float) -> float:
    """Exponential moving average (EMA) of the rate, Eq. (7), eq:ema.

    R-bar_i(t) = (1 - beta) R-bar_i(t-1) + beta R_i(t),  R-bar_i(0) = 0

    :param previous_mbps: R-bar_i(t-1) in Mbps
    :param rate_mbps: R_i(t) in Mbps
    :param beta: smoothing factor in (0, 1)
    :return: R-bar_i(t) in Mbps

    >>> ema_rate(10.0, 30.0, 0.5)  # 0.5 * 10 + 0.5 * 30
    20.0
    """
    return (1.0 - beta) * previous_mbps + beta * rate_mbps


@njit
def corrected_rate(ema_mbps: float, beta: float, slots: int) -> float:
    """Bias-corrected EMA rate, below Eq. (9), eq:utility.

    R-hat_i = R-bar_i / (1 - (1 - beta)^T-bar)

    :param ema_mbps: R-bar_i in Mbps
    :param beta: smoothing factor in (0, 1)
    :param slots: T-bar, the slots averaged over; 0 gives 0
    :return: R-hat_i in Mbps

    >>> corrected_rate(ema_rate(ema_rate(0.0, 20.0, 0.5), 20.0, 0.5), 0.5, 2)  # 20 Mbps twice: 15 / (1 - 0.25)
    20.0
    """
    if slots == 0:
        return 0.0
    return float(ema_mbps / (1.0 - (1.0 - beta) ** slots))


@njit
def utility(corrected_mbps: float, min_slots: int, slots: int) -> float:
    """Utility of a completed mission, Eq. (9), eq:utility.

    U_i = R-hat_i(T_i) T_i^min / T_i

    :param corrected_mbps: R-hat_i(T_i) in Mbps
    :param min_slots: T_i^min, least flight time in slots
    :param slots: T_i, slots flown
    :return: U_i in Mbps

    >>> utility(30.0, 2, 3)  # 30 Mbps at 2/3 of the greatest speed
    20.0
    """
    return corrected_mbps * min_slots / slots


@njit
def slot_weight(beta: float, slots_left: int, least: int, flown: int, horizon: int) -> float:
    """How much the rate of slot t counts in the utility: Eq. (9), eq:utility, with Eq. (7), eq:ema, written out.

    U_i = sum_t w(t) R_i(t),  w(t) = beta (1 - beta)^(T_i - t) / (1 - (1 - beta)^T-bar) T_i^min / T_i

    :param beta: smoothing factor of the EMA
    :param slots_left: T_i - t, slots between this one and the end of the flight
    :param least: T_i^min
    :param flown: T_i
    :param horizon: T-bar, the slots of the bias correction: T_i or T_max
    :return: w(t), without unit
    """
    return utility(corrected_rate(ema_rate(0.0, 1.0, beta) * (1.0 - beta) ** slots_left, beta, horizon), least, flown)


def welfare(utilities_mbps: NDArray[np.float64]) -> NDArray[np.float64]:
    """Social welfare, Eq. (10), eq:welfare.

    W = sum_i U_i

    :param utilities_mbps: U_i of every UAV in Mbps, 0 for a failed mission [..., N]
    :return: W in Mbps [...]

    >>> welfare(np.array([[20.0, 0.0, 15.5], [1.0, 2.0, 3.0]]))
    array([35.5,  6. ])
    """
    return np.asarray(np.sum(utilities_mbps, axis=-1))


@njit
def reward_rate(ema_before_mbps: float, ema_after_mbps: float, rate_unit_mbps: float) -> float:
    """Rate term of the reward, Eq. (15), eq:reward_rate.

    r_i^rate(t) = R-bar_i(t+1) - R-bar_i(t)

    :param ema_before_mbps: R-bar_i(t) in Mbps
    :param ema_after_mbps: R-bar_i(t+1) in Mbps
    :param rate_unit_mbps: the unit of rates inside rewards in Mbps
    :return: the change in that unit

    >>> reward_rate(10.0, 12.5, 50.0)
    0.05
    """
    return (ema_after_mbps - ema_before_mbps) / rate_unit_mbps


@njit
def reward_nav(distance_before: float, distance_after: float, nav_weight: float) -> float:
    """Navigation term of the reward, Eq. (16), eq:reward_nav.

    r_i^nav(t) = omega (||q_i(t) - d_i|| - ||q_i(t+1) - d_i||)

    :param distance_before: ||q_i(t) - d_i|| in voxels
    :param distance_after: ||q_i(t+1) - d_i|| in voxels
    :param nav_weight: omega per voxel
    :return: the weighted progress

    >>> reward_nav(7.0, 5.0, 0.5)
    1.0
    """
    return nav_weight * (distance_before - distance_after)


@njit
def reward_col(collided: bool, collision_penalty: float) -> float:
    """Collision term of the reward, Eq. (17), eq:reward_col.

    r_i^col(t) = -rho_col if q_j(t+1) = q_i(t+1) for some j != i, else 0

    :param collided: whether another UAV is in the same voxel at t+1
    :param collision_penalty: rho_col
    :return: minus the penalty, or 0
    """
    return -collision_penalty if collided else 0.0


@njit
def reward_term(
    arrived: bool, timed_out: bool, utility_mbps: float, rate_unit_mbps: float, fail_penalty: float
) -> float:
    """Terminal term of the reward, Eq. (18), eq:terminal.

    r_i^term(t) = U_i on arrival in time, -r_fail at the deadline, else 0

    :param arrived: the destination was reached in time
    :param timed_out: the deadline passed without
    :param utility_mbps: U_i of the completed mission in Mbps
    :param rate_unit_mbps: the unit of rates inside rewards in Mbps
    :param fail_penalty: r_fail
    :return: U_i in that unit, minus the penalty, or 0

    >>> reward_term(True, False, 20.0, 50.0, 5.0), reward_term(False, True, 0.0, 50.0, 5.0)
    (0.4, -5.0)
    """
    if arrived:
        return utility_mbps / rate_unit_mbps
    return -fail_penalty if timed_out else 0.0
