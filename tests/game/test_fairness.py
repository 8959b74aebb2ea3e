"""Fairness: figures on paper, and laws of every index."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from numpy.typing import ArrayLike, NDArray

from lawn_sb3.errors import UserError
from lawn_sb3.game.fairness import gini, jain_index, nash_welfare

Index = Callable[[ArrayLike], NDArray[np.float64]]
INDICES = [jain_index, gini, nash_welfare]
SHARES = st.lists(st.one_of(st.just(0.0), st.floats(1e-9, 1e9)), min_size=1, max_size=8)


def test_jain_index_is_the_square_of_the_sum_over_n_times_the_sum_of_squares() -> None:
    # (1 + 2 + 3)^2 / (3 * (1 + 4 + 9)) = 36 / 42 = 6/7
    assert jain_index([1.0, 2.0, 3.0]) == pytest.approx(6 / 7)


@given(shares=SHARES)
def test_jain_index_lies_between_one_over_n_and_one(shares: list[float]) -> None:
    assert 1 / len(shares) - 1e-12 <= jain_index(shares) <= 1 + 1e-12


def test_gini_is_the_mean_difference_over_twice_the_mean() -> None:
    # Of the nine ordered pairs of 1, 2, 3 four differ by 1 and two by 2: (4 + 4) / 9, over 2 * 2: 2/9
    assert gini([1.0, 2.0, 3.0]) == pytest.approx(2 / 9)


@given(shares=SHARES)
def test_gini_lies_between_zero_and_n_minus_one_over_n(shares: list[float]) -> None:
    assert 0.0 <= gini(shares) <= 1 - 1 / len(shares) + 1e-12


def test_nash_welfare_is_the_geometric_mean() -> None:
    # (1 * 2 * 4)^(1/3) = 2 and (4 * 9 * 6)^(1/3) = 6
    np.testing.assert_allclose(nash_welfare([[1.0, 2.0, 4.0], [4.0, 9.0, 6.0]]), [2.0, 6.0])


@pytest.mark.filterwarnings("error")
def test_nash_welfare_is_zero_if_one_uav_has_nothing() -> None:
    assert nash_welfare([50.0, 0.0, 50.0]) == 0.0


@given(shares=SHARES)
def test_nash_welfare_is_at_least_the_worst_share_and_at_most_the_mean(shares: list[float]) -> None:
    assert min(shares) * (1 - 1e-9) <= nash_welfare(shares) <= np.mean(shares) * (1 + 1e-9)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("shape", [(4,), (2, 4)], ids=["one game", "two games"])
def test_games_where_all_have_nothing_are_even_and_worth_nothing(shape: tuple[int, ...]) -> None:
    assert (jain_index(np.zeros(shape)) == 1.0).all()
    assert (gini(np.zeros(shape)) == 0.0).all()
    assert (nash_welfare(np.zeros(shape)) == 0.0).all()


@given(shares=SHARES, scale=st.floats(1e-200, 1e200))
def test_unit_changes_neither_jain_nor_gini_and_scales_the_nash_welfare(shares: list[float], scale: float) -> None:
    scaled = scale * np.array(shares)
    assert jain_index(scaled) == pytest.approx(jain_index(shares), rel=1e-9)
    assert gini(scaled) == pytest.approx(gini(shares), rel=1e-9, abs=1e-12)
    assert nash_welfare(scaled) == pytest.approx(scale * nash_welfare(shares), rel=1e-9)


@pytest.mark.parametrize("index", INDICES)
@given(shares=SHARES, data=st.data())
def test_order_of_the_uavs_changes_nothing(index: Index, shares: list[float], data: st.DataObject) -> None:
    assert index(data.draw(st.permutations(shares))) == pytest.approx(index(shares), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("index", INDICES)
@given(values=arrays(np.float64, array_shapes(min_dims=2, max_dims=3, max_side=4), elements=st.floats(0.0, 1e3)))
def test_every_game_is_judged_by_itself(index: Index, values: NDArray[np.float64]) -> None:
    together = index(values)
    assert together.shape == values.shape[:-1]
    for game in np.ndindex(together.shape):
        assert together[game] == pytest.approx(index(values[game]), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("index", INDICES)
@pytest.mark.parametrize("bad", [-1.0, float("nan"), float("inf")])
def test_negative_and_unknown_values_are_refused(index: Index, bad: float) -> None:
    with pytest.raises(UserError, match=f"values hold {bad}: must be finite and 0 or more"):
        index([[1.0, 2.0], [3.0, bad]])


@pytest.mark.parametrize("index", INDICES)
def test_values_of_no_uav_are_refused(index: Index) -> None:
    for wrong in (3.0, np.ones((2, 0))):
        with pytest.raises(UserError, match=r"must be \[..., N\], with at least one UAV"):
            index(wrong)
