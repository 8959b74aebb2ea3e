"""Measures of an evaluation: means worked out by hand, and what each UAV could have gained alone."""

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from lawn_sb3.experiment.evaluation import evaluate, evaluation_games, fly
from lawn_sb3.experiment.measures import regrets, standard_errors, summarize, summarize_regrets, trajectories
from lawn_sb3.experiment.run_directory.columns import evaluation_columns
from lawn_sb3.game.airspace import Missions
from lawn_sb3.game.player import RandomPlayer
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning import EquilibriumPlayer, ShortestPathPlayer
from lawn_sb3.planning.guarantee import guaranteed_utilities_mbps
from lawn_sb3.scenario import PRESETS
from tests.game.wanderer import Wanderer

PAPER = PRESETS["paper"]


def test_summary_by_hand() -> None:
    # Two episodes of two UAVs.
    rows = pd.DataFrame(
        [
            (0, 0, 1.0, 10.0, 2, 2, True, 10.0, 0, 4, 1.0),
            (0, 1, 2.0, 20.0, 4, 2, True, 10.0, 1, 4, 1.0),
            (1, 0, 3.0, 30.0, 8, 2, False, 0.0, 0, 8, 1.0),
            (1, 1, 4.0, 40.0, 2, 2, True, 40.0, 1, 8, 1.0),
        ],
        columns=list(evaluation_columns(PAPER, 2)),
    )
    assert summarize(rows) == {
        "reward": 2.5,  # (1 + 2 + 3 + 4) / 4
        "rate_mbps": 25.0,
        "makespan_slots": 6.0,  # (4 + 8) / 2
        "completion_slots": 4.0,  # (2 + 4 + 8 + 2) / 4
        "success_percent": 75.0,
        "utility_mbps": 15.0,  # 60 / 4
        "welfare_mbps": 30.0,  # (20 + 40) / 2
        "collisions": 0.5,
    }


def test_nobody_regrets_an_equilibrium() -> None:
    flights = fly(EquilibriumPlayer(), PAPER, 20, 3, traced=20)
    rows = regrets(flights, PAPER, 3)
    np.testing.assert_allclose(rows["best_mbps"], rows["utility_mbps"], atol=1e-9)
    assert summarize_regrets(rows, flights.rows)["equilibria_percent"] == 100.0


def test_a_failed_mission_is_regretted_by_all_that_could_have_been_had() -> None:
    flights = fly(RandomPlayer(), PAPER, 20, 3, traced=20)
    rows = regrets(flights, PAPER, 3)
    failed = ~flights.rows["arrived"]
    assert failed.any()
    assert (rows.loc[failed, "utility_mbps"] == 0.0).all()
    games = evaluation_games(PAPER, 20, 3)
    safe_mbps = guaranteed_utilities_mbps(games.rules, games.state, PAPER.max_slots)
    assert safe_mbps.min() > 0.0
    assert (rows["best_mbps"] >= safe_mbps.ravel() - 1e-9).all()
    assert (rows["best_slots"] >= flights.rows["min_slots"]).all()


def test_a_uav_alone_regrets_what_its_path_lacks_to_the_best_one() -> None:
    alone = PAPER.changed(num_uavs=1)
    flights = fly(ShortestPathPlayer(), alone, 30, 3, traced=30)
    rows = regrets(flights, alone, 3)
    bound = fly(EquilibriumPlayer(), alone, 30, 3).rows
    np.testing.assert_allclose(rows["best_mbps"], bound["utility_mbps"])
    assert (rows["best_mbps"] >= rows["utility_mbps"] - 1e-9).all()


class WaitingPlayer(Wanderer):
    """UAV 0 flies straight; UAV 1 waits for eleven slots first."""

    def act(self, simulator: Simulator) -> NDArray[np.int64]:
        waits = (np.arange(2) == 1) & (simulator.state.slot < 11)
        return np.where(waits, 0, super().act(simulator))


@pytest.mark.parametrize("arrived", ["leaves", "stays"])
def test_the_best_response_may_be_to_wait_for_the_other_to_leave(arrived: str, monkeypatch: pytest.MonkeyPatch) -> None:
    # One RB for 2 x 2 voxels that are all as near to the only GBS: two UAVs get nothing, one alone gets r. UAV 0 flies
    # from (0, 0) to (1, 0) in the first slot, UAV 1 from (0, 1) to (1, 1) in the twelfth. If UAV 1 leaves then, UAV 0
    # should have arrived after T slots with rate r in the last T - 12: with beta = 1/2 it has
    # r (1 - 2^(12 - T)) / (1 - 2^-T) / T, which is highest for T = 16. If it stays, nothing helps.
    scenario = PAPER.changed(
        num_uavs=2, width_voxels=2, length_voxels=2, max_altitude_m=10, gbs_grid=[1, 1], rbs_per_gbs=1, ema_beta=0.5,
        max_slots=30, max_voxel_steps=1, arrived_uav=arrived,
    )  # fmt: skip
    missions = Missions(np.array([[[0, 0, 0], [0, 1, 0]]]), np.array([[[1, 0, 0], [1, 1, 0]]]))
    monkeypatch.setattr("lawn_sb3.experiment.evaluation.draw_missions", lambda *_: missions)
    flights = fly(WaitingPlayer(), scenario, 1, 0, traced=1)
    assert flights.rows["slots"].tolist() == [1, 12]
    first = regrets(flights, scenario, 0).iloc[0]
    rate_mbps = float(evaluation_games(scenario, 1, 0).rules.rb_rate_mbps[0, 0, 0])
    if arrived == "leaves":
        assert first["best_slots"] == 16
        assert first["best_mbps"] == pytest.approx(rate_mbps * (1 - 2**-4) / (1 - 2**-16) / 16)
    else:
        assert first["best_mbps"] == 0.0


def test_trajectories_end_where_the_uavs_are_done() -> None:
    flights = fly(ShortestPathPlayer(), PAPER, 5, 3, traced=5)
    voxels = trajectories(flights, PAPER)
    state = evaluation_games(PAPER, 5, 3).state
    assert voxels.shape == (5, 4, PAPER.max_slots + 1, 3)
    np.testing.assert_array_equal(voxels[:, :, 0], state.position)
    for slot in range(int(flights.rows["slots"].max()), PAPER.max_slots + 1):
        np.testing.assert_array_equal(voxels[:, :, slot], state.destination)


def test_means_and_gaps_of_three_episodes_worked_out_by_hand() -> None:
    rows = pd.DataFrame(
        {
            "episode": [0, 0, 1, 1, 2, 2, 3, 3],
            "uav": [0, 1] * 4,
            "utility_mbps": [10.0, 20.0, 30.0, 30.0, 5.0, 40.0, 20.0, 20.0],
            "best_mbps": [13.0, 20.0, 30.0, 30.0, 11.0, 39.0, 20.0, 20.0],
        }
    )
    # Regrets 3, 0 | 0, 0 | 6, 0 | 0, 0: UAV 1 of episode 2 collided and had more than it could without. Largest: 3, 0,
    # 6, 0. Nobody could gain in episodes 1 and 3, but in the latter the UAVs collide.
    flown = rows.assign(collisions=[0, 0, 0, 0, 0, 1, 1, 1])
    assert summarize_regrets(rows, flown) == {
        "regret_mbps": 9.0 / 8.0,
        "nash_gap_mbps": 9.0 / 4.0,
        "largest_regret_mbps": 6.0,
        "equilibria_percent": 25.0,
    }


def test_standard_errors_are_those_of_means_over_episodes() -> None:
    rows = evaluate(RandomPlayer(), PAPER, 12, 3)
    errors = standard_errors(rows)
    assert errors.keys() == summarize(rows).keys()
    each = pd.DataFrame([summarize(episode) for _, episode in rows.groupby("episode")])
    assert errors == pytest.approx(dict(each.std() / np.sqrt(12)))
