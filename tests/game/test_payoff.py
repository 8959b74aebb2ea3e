"""Section III: EMA rate, utility, welfare, and the terms of the reward."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lawn_sb3.game.payoff import (
    corrected_rate,
    ema_rate,
    reward_col,
    reward_nav,
    reward_rate,
    reward_term,
    utility,
    welfare,
)

BETAS = st.floats(0.01, 0.99)

# eq:ema and its bias correction


def test_ema_rate_moves_by_beta_towards_the_rate() -> None:
    # 0.9 * 10 + 0.1 * 20 = 11
    assert ema_rate(10.0, 20.0, 0.1) == pytest.approx(11.0)


def test_corrected_rate_undoes_the_start_from_zero() -> None:
    # 20 Mbps twice from 0 with beta 0.1: 2, then 0.9 * 2 + 0.1 * 20 = 3.8; 3.8 / (1 - 0.9^2) = 3.8 / 0.19 = 20
    assert corrected_rate(ema_rate(ema_rate(0.0, 20.0, 0.1), 20.0, 0.1), 0.1, 2) == pytest.approx(20.0)


def test_corrected_rate_of_no_slots_is_zero() -> None:
    assert corrected_rate(0.0, 0.1, 0) == 0.0


@given(rates=st.lists(st.floats(0.0, 1e3), min_size=1, max_size=30), beta=BETAS)
def test_corrected_rate_lies_between_the_lowest_and_the_highest_rate(rates: list[float], beta: float) -> None:
    ema = 0.0
    for rate in rates:
        ema = ema_rate(ema, rate, beta)
    assert min(rates) - 1e-6 <= corrected_rate(ema, beta, len(rates)) <= max(rates) + 1e-6


# eq:utility and eq:welfare


def test_utility_is_the_corrected_rate_times_the_time_efficiency() -> None:
    # 30 Mbps * 2 / 3 slots = 20 Mbps
    assert utility(30.0, 2, 3) == pytest.approx(20.0)


@given(corrected=st.floats(0.0, 1e3), least=st.integers(1, 50), detour=st.integers(0, 50))
def test_utility_is_the_corrected_rate_on_a_shortest_path_and_never_above(
    corrected: float, least: int, detour: int
) -> None:
    assert utility(corrected, least, least) == pytest.approx(corrected)
    assert utility(corrected, least, least + detour) <= corrected * (1 + 1e-12)


def test_welfare_sums_the_utilities_of_each_game() -> None:
    # 20 + 0 + 15.5 = 35.5 and 1 + 2 + 3 = 6
    assert welfare(np.array([[20.0, 0.0, 15.5], [1.0, 2.0, 3.0]])).tolist() == [35.5, 6.0]


# eq:reward_rate


def test_rate_reward_is_the_change_of_the_ema_rate_in_its_unit() -> None:
    # (11 - 10) / 50 = 0.02, and back
    assert reward_rate(10.0, 11.0, 50.0) == pytest.approx(0.02)
    assert reward_rate(11.0, 10.0, 50.0) == pytest.approx(-0.02)


# eq:reward_nav


def test_nav_reward_is_omega_times_the_progress() -> None:
    # 0.5 * (7 - 5) = 1, and back
    assert reward_nav(7.0, 5.0, 0.5) == pytest.approx(1.0)
    assert reward_nav(5.0, 7.0, 0.5) == pytest.approx(-1.0)
    assert reward_nav(5.0, 5.0, 0.5) == 0.0


# eq:reward_col


def test_collision_costs_rho_col() -> None:
    assert reward_col(True, 1.5) == -1.5
    assert reward_col(False, 1.5) == 0.0


# eq:terminal


def test_terminal_reward_is_the_utility_in_its_unit_on_arrival() -> None:
    # 20 Mbps / 50 Mbps
    assert reward_term(True, False, 20.0, 50.0, 5.0) == pytest.approx(0.4)


def test_terminal_reward_is_minus_r_fail_on_timeout() -> None:
    assert reward_term(False, True, 0.0, 50.0, 5.0) == -5.0


def test_terminal_reward_is_zero_on_the_way() -> None:
    assert reward_term(False, False, 0.0, 50.0, 5.0) == 0.0
