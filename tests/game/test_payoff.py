"""Section III: laws of EMA rate and utility, and the signs of the terms of the reward.

A figure for each equation is worked out beside it, in its docstring.
"""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lawn_sb3.game.payoff import corrected_rate, ema_rate, reward_col, reward_nav, reward_rate, reward_term, utility


def test_corrected_rate_of_no_slots_is_zero() -> None:
    assert corrected_rate(0.0, 0.1, 0) == 0.0


@given(rates=st.lists(st.floats(0.0, 1e3), min_size=1, max_size=30), beta=st.floats(0.01, 0.99))
def test_corrected_rate_lies_between_the_lowest_and_the_highest_rate(rates: list[float], beta: float) -> None:
    ema = 0.0
    for rate in rates:
        ema = ema_rate(ema, rate, beta)
    assert min(rates) - 1e-6 <= corrected_rate(ema, beta, len(rates)) <= max(rates) + 1e-6


@given(corrected=st.floats(0.0, 1e3), least=st.integers(1, 50), detour=st.integers(0, 50))
def test_utility_is_the_corrected_rate_on_a_shortest_path_and_never_above(
    corrected: float, least: int, detour: int
) -> None:
    assert utility(corrected, least, least) == pytest.approx(corrected)
    assert utility(corrected, least, least + detour) <= corrected * (1 + 1e-12)


def test_losses_of_rate_and_progress_collisions_and_nothing_at_all_are_rewarded_so() -> None:
    assert reward_rate(11.0, 10.0, 50.0) == pytest.approx(-0.02)  # (10 - 11) / 50
    assert reward_nav(5.0, 7.0, 0.5) == -1.0  # 0.5 * (5 - 7)
    assert reward_nav(5.0, 5.0, 0.5) == 0.0
    assert (reward_col(True, 1.5), reward_col(False, 1.5)) == (-1.5, 0.0)
    assert reward_term(False, False, 0.0, 50.0, 5.0) == 0.0  # on the way
