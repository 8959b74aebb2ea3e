"""Evaluation: one raw row per episode and UAV, on missions that a seed fixes."""

import numpy as np
import pandas as pd
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.evaluation import evaluate, fly
from lawn_sb3.game.player import RandomPlayer
from lawn_sb3.planning import BoundPlayer
from lawn_sb3.scenario import PRESETS
from tests.game.wanderer import Wanderer

PAPER = PRESETS["paper"]


def test_every_player_flies_the_same_missions() -> None:
    random = evaluate(RandomPlayer(), PAPER, 50, seed=5)
    straight = evaluate(Wanderer(), PAPER, 50, seed=5)
    assert (random["min_slots"] == straight["min_slots"]).all()
    assert (evaluate(Wanderer(), PAPER, 50, seed=6)["min_slots"] != straight["min_slots"]).any()


def test_equal_seeds_give_equal_rows_and_the_player_has_a_seed_of_its_own() -> None:
    rows = evaluate(RandomPlayer(), PAPER, 20, seed=5, player_seed=1)
    pd.testing.assert_frame_equal(rows, evaluate(RandomPlayer(), PAPER, 20, seed=5, player_seed=1))
    assert (rows["reward"] != evaluate(RandomPlayer(), PAPER, 20, seed=5, player_seed=2)["reward"]).any()


def test_a_straight_flight_takes_the_least_time_and_its_utility_is_its_rate() -> None:
    rows = evaluate(Wanderer(), PAPER, 50, seed=5)
    assert rows["arrived"].all()
    assert (rows["slots"] == rows["min_slots"]).all()
    np.testing.assert_allclose(rows["utility_mbps"], rows["rate_mbps"])


def test_a_failed_mission_has_no_utility_and_flies_until_the_deadline_the_makespan_of_its_episode() -> None:
    rows = evaluate(RandomPlayer(), PAPER, 30, seed=5)
    assert (rows.groupby("episode")["slots"].max() == rows.groupby("episode")["makespan_slots"].first()).all()
    failed = rows[~rows["arrived"]]
    assert len(failed)
    assert (failed["slots"] == PAPER.max_slots).all()
    assert (failed["utility_mbps"] == 0.0).all()


def test_no_episode_is_refused() -> None:
    with pytest.raises(UserError, match="episodes = 0"):
        evaluate(RandomPlayer(), PAPER, 0, seed=5)


def test_paths_lead_from_origin_to_destination_one_row_a_slot() -> None:
    flights = fly(Wanderer(), PAPER, 6, seed=5, traced=2)
    assert set(flights.paths["episode"]) == {0, 1}
    for (episode, uav), path in flights.paths.groupby(["episode", "uav"]):
        row = flights.rows[(flights.rows["episode"] == episode) & (flights.rows["uav"] == uav)].iloc[0]
        assert list(path["slot"]) == list(range(row["slots"] + 1))
        steps = path[["x", "y", "z"]].diff().dropna().abs().sum(axis=1)
        assert steps.max() <= PAPER.max_voxel_steps
        # On a shortest path the L1 distance takes T_min slots of at most v_max steps.
        assert PAPER.max_voxel_steps * (row["min_slots"] - 1) < steps.sum() <= PAPER.max_voxel_steps * row["min_slots"]
        assert path["rate_mbps"].iloc[0] == 0.0


def test_the_load_of_a_uavs_cell_is_averaged_over_its_own_slots() -> None:
    flights = fly(RandomPlayer(), PAPER, 3, seed=5, traced=3)
    flown = flights.paths[flights.paths["slot"] > 0].groupby(["episode", "uav"])["cell_load"].mean()
    np.testing.assert_allclose(flights.rows["mean_cell_load"], flown)


def test_every_flying_uav_is_counted_once_by_cell_and_once_by_load() -> None:
    flights = fly(RandomPlayer(), PAPER, 10, seed=5, traced=10)
    by_gbs = flights.slots.filter(like="gbs_").sum(axis=1)
    by_load = flights.slots.filter(like="load_").sum(axis=1)
    flying = flights.paths[flights.paths["slot"] > 0].groupby("slot").size() / 10
    np.testing.assert_allclose(by_gbs, flying)
    np.testing.assert_allclose(by_load, flying)
    assert flights.slots["load_4"].max() > 0


def test_a_player_that_flies_alone_has_every_uav_in_a_game_of_its_own() -> None:
    bound = fly(BoundPlayer(), PAPER, 20, seed=5, traced=20)
    others = evaluate(Wanderer(), PAPER, 20, seed=5)
    assert (bound.rows["min_slots"] == others["min_slots"]).all()  # the same missions, in the same order
    assert (bound.rows["mean_cell_load"] == 1.0).all()
    assert (bound.paths["cell_load"] == 1).all()
    assert (bound.rows.groupby("episode")["slots"].max() == bound.rows.groupby("episode")["makespan_slots"].max()).all()
