"""How evenly a quantity is spread over the UAVs of a game: Jain's index, the Gini coefficient, the Nash welfare.

The welfare, Eq. (10), eq:welfare, does not say who gets what, and the paper leaves fairness to future work. These three
look at the utilities, or any other quantity that is 0 or more, of the N UAVs of one game.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lawn_sb3.errors import UserError


def jain_index(values: ArrayLike) -> NDArray[np.float64]:
    """Jain's fairness index: k of N UAVs with equal parts, and nothing for the others, give k/N.

    J = (sum_i x_i)^2 / (N sum_i x_i^2)

    :param values: x_i, a quantity of every UAV, 0 or more, in any unit [..., N]
    :return: from 1/N (one UAV has everything) to 1 (all equal) [...]; 1 if all have 0
    :raises UserError: if a value is negative or not finite, or there is no UAV

    >>> jain_index([5.0, 0.0, 5.0, 0.0])
    array(0.5)
    """
    parts = _relative(values)
    total, squares = parts.sum(axis=-1), np.square(parts).sum(axis=-1)
    index = np.divide(total**2, parts.shape[-1] * squares, out=np.ones_like(total), where=squares > 0)
    return np.asarray(index)


def gini(values: ArrayLike) -> NDArray[np.float64]:
    """Gini coefficient: the mean difference of two UAVs, each drawn from all N, over twice the mean.

    G = sum_i sum_j ``|x_i - x_j|`` / (2 N sum_i x_i)

    :param values: x_i, a quantity of every UAV, 0 or more, in any unit [..., N]
    :return: from 0 (all equal) to (N - 1)/N (one UAV has everything) [...]; 0 if all have 0
    :raises UserError: if a value is negative or not finite, or there is no UAV

    >>> gini([1.0, 0.0, 0.0, 0.0])
    array(0.75)
    """
    parts = _relative(values)
    total = parts.sum(axis=-1)
    differences = np.abs(parts[..., :, None] - parts[..., None, :]).sum(axis=(-2, -1))
    coefficient = np.divide(differences, 2 * parts.shape[-1] * total, out=np.zeros_like(total), where=total > 0)
    return np.asarray(coefficient)


def nash_welfare(values: ArrayLike) -> NDArray[np.float64]:
    """Nash welfare: the geometric mean, which is 0 if one UAV is left with nothing.

    NW = (prod_i x_i)^(1/N)

    :param values: x_i, a quantity of every UAV, 0 or more [..., N]
    :return: in the unit of the values [...]
    :raises UserError: if a value is negative or not finite, or there is no UAV
    """
    with np.errstate(divide="ignore"):  # log 0 = -inf, and exp takes it back to 0
        return np.asarray(np.exp(np.log(_checked(values)).mean(axis=-1)))


def _relative(values: ArrayLike) -> NDArray[np.float64]:
    """Values as parts of the largest of their game, so that no square leaves the range of a float."""
    array = _checked(values)
    largest = array.max(axis=-1, keepdims=True)
    return np.asarray(np.divide(array, largest, out=np.zeros_like(array), where=largest > 0))


def _checked(values: ArrayLike) -> NDArray[np.float64]:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] == 0:
        raise UserError(f"values have shape {array.shape}: must be [..., N], with at least one UAV")
    if not np.isfinite(array).all() or (array < 0).any():
        wrong = array[~np.isfinite(array) | (array < 0)].flat[0]
        raise UserError(f"values hold {wrong}: must be finite and 0 or more")
    return array
