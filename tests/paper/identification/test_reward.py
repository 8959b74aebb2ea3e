"""The terms of J: weighed anew they give what a simulation with other constants gives."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.game.player import RandomPlayer
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.paper.identification.candidates import PAPER, candidates
from lawn_sb3.paper.identification.reward import TERMS, accumulated_reward, linear_table, other_rows, reward_terms
from lawn_sb3.paper.printed_values import TABLE_II
from tests.game.wanderer import Wanderer


@settings(max_examples=25)
@given(
    nav_weight=st.floats(0.0, 3.0),
    collision_penalty=st.floats(0.0, 3.0),
    fail_penalty=st.floats(0.0, 20.0),
    rate_unit=st.sampled_from(["lone-uav", "mbps"]),
    ema_beta=st.sampled_from([0.05, 0.1, 0.5]),
    bias_horizon=st.sampled_from(["completion", "deadline"]),
)
def test_reward_is_linear_in_its_constants(ema_beta: float, bias_horizon: str, **weights: float | str) -> None:
    flown = PAPER.changed(ema_beta=ema_beta, bias_horizon=bias_horizon, max_slots=30)
    paid = flown.changed(**weights)
    rows = evaluate(RandomPlayer(), paid, 20, seed=4)
    terms = reward_terms(RandomPlayer(), flown, 20, seed=4)
    np.testing.assert_allclose(accumulated_reward(terms, paid), rows["reward"], rtol=1e-9, atol=1e-9)


def test_terms_of_a_straight_flight_by_hand() -> None:
    # It progresses by its whole distance and fails never; U_i = R-hat_i and R-bar_i = R-hat_i (1 - 0.9^T_i).
    terms, rows = reward_terms(Wanderer(), PAPER, 20, seed=4), evaluate(Wanderer(), PAPER, 20, seed=4)
    assert (terms["failed"] == 0.0).all()
    expected = rows["rate_mbps"] * (2.0 - 0.9 ** rows["slots"])
    np.testing.assert_allclose(terms["rate_sum_mbps"], expected)
    assert (terms["progress_voxels"] >= 1.0 - 1e-9).all()
    np.testing.assert_allclose(terms["progress_voxels"] ** 2, (terms["progress_voxels"] ** 2).round())


def test_contributions_add_up_to_the_reward_of_random() -> None:
    table = linear_table(reward_terms(RandomPlayer(), PAPER, 50, seed=4), PAPER)
    rows = evaluate(RandomPlayer(), PAPER, 50, seed=4)
    assert table["contribution"].sum() == pytest.approx(rows["reward"].mean())


@pytest.mark.parametrize("constant", ["nav_weight", "collision_penalty", "fail_penalty"])
def test_the_needed_constant_gives_the_reward_of_the_paper(constant: str) -> None:
    table = linear_table(reward_terms(RandomPlayer(), PAPER, 200, seed=4), PAPER)
    low, needed, high = (
        float(table.loc[table["constant"] == constant, name].iloc[0])
        for name in ("needed_low", "needed", "needed_high")
    )
    rows = evaluate(RandomPlayer(), PAPER.changed(**{constant: needed}), 200, seed=4)
    assert rows["reward"].mean() == pytest.approx(TABLE_II["Random"].reward, abs=1e-9)
    assert low < needed < high


def test_standard_errors_are_those_of_episodes() -> None:
    terms = pd.DataFrame({"episode": [0, 0, 1, 1], **{name: [0.0, 2.0, 4.0, 6.0] for name in TERMS}})
    # The means of the episodes are 1 and 5: standard deviation sqrt(8), over two episodes an error of 2.
    assert linear_table(terms, PAPER)["standard_error"].tolist() == pytest.approx([2.0] * 4)


class PickyPlayer(Wanderer):
    """Flies straight, but only in the rate unit it knows; otherwise it hovers."""

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        actions = super().act(simulator)
        return actions if simulator.scenario.rate_unit == "lone-uav" else np.zeros_like(actions)


def test_others_fly_as_they_did_in_the_preset_whatever_they_are_paid() -> None:
    units = [candidate for candidate in candidates() if candidate.label in ("lone-uav", "mbps")]
    known, strange = other_rows("QMIX", PickyPlayer(), units, 20, seed=4)
    assert known["rate_mbps"] == strange["rate_mbps"]
    own = evaluate(Wanderer(), PAPER.changed(rate_unit="mbps"), 20, seed=4)
    assert strange["reward"] == pytest.approx(own["reward"].mean())
    assert strange["reward_difference"] == pytest.approx(own["reward"].mean() - 3.01)  # tab:perf
