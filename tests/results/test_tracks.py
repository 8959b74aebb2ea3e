"""Tracks show episodes as they were flown: their numbers are those of the raw rows and of the game's own state."""

from typing import Any

import numpy as np
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.evaluation import evaluation_games, fly
from lawn_sb3.game.player import Player, RandomPlayer
from lawn_sb3.planning import ShortestPathPlayer
from lawn_sb3.results.tracks import tracks_of
from lawn_sb3.scenario import PRESETS

PAPER = PRESETS["paper"].changed(max_slots=12)
"""Who flies straight arrives in time, UAVs of an episode in different slots; who moves at random seldom does."""
EPISODES = 5
CHANGES: list[dict[str, Any]] = [{}, {"arrived_uav": "stays"}, {"bias_horizon": "deadline"}]


PLAYERS = [RandomPlayer, ShortestPathPlayer]


@pytest.mark.parametrize("player", PLAYERS)
@pytest.mark.parametrize("changes", CHANGES, ids=str)
def test_the_last_averages_and_utilities_are_those_of_the_raw_rows(
    player: type[Player], changes: dict[str, Any]
) -> None:
    game = PAPER.changed(**changes)
    flights = fly(player(), game, EPISODES, seed=3, traced=EPISODES)
    for track in tracks_of(game, flights.rows, flights.paths, range(EPISODES)):
        for uav, row in enumerate(track.rows.to_dict("records")):
            assert track.ema_rate_mbps[row["slots"], uav] == pytest.approx(row["rate_mbps"], rel=1e-12)
            assert np.isnan(track.utility_mbps[: row["slots"], uav]).all()
            assert (track.utility_mbps[row["slots"] :, uav] == row["utility_mbps"]).all()
            assert track.flying[:, uav].sum() == row["slots"] + 1
            assert track.slots == row["makespan_slots"]


@pytest.mark.parametrize("player", PLAYERS)
@pytest.mark.parametrize("changes", CHANGES, ids=str)
def test_cell_loads_are_those_that_the_game_shared_its_rbs_by(player: type[Player], changes: dict[str, Any]) -> None:
    game = PAPER.changed(**changes)
    flights = fly(player(), game, EPISODES, seed=3, traced=EPISODES)
    shown = list(tracks_of(game, flights.rows, flights.paths, range(EPISODES)))
    for row in flights.paths.to_dict("records"):
        track = shown[row["episode"]]
        assert track.cell_load[row["slot"], row["cell"]] == row["cell_load"]
        assert track.voxels[row["slot"], row["uav"]].tolist() == [row["x"], row["y"], row["z"]]
    if not changes:
        for track in shown:
            assert track.cell_load.sum(axis=1).tolist() == track.flying.sum(axis=1).tolist()


def test_uavs_that_are_done_stay_where_they_ended() -> None:
    game, destinations = PAPER, evaluation_games(PAPER, EPISODES, 3).state.destination
    flights = fly(ShortestPathPlayer(), game, EPISODES, seed=3, traced=EPISODES)
    for track in tracks_of(game, flights.rows, flights.paths, [4, 0]):
        assert track.voxels[-1].tolist() == destinations[track.episode].tolist()
        assert np.isnan(track.rate_mbps[0]).all()


def test_an_episode_without_paths_is_refused() -> None:
    flights = fly(RandomPlayer(), PAPER, EPISODES, seed=3, traced=2)
    with pytest.raises(UserError, match="episode 2 has no paths: from 0 to 1 have some"):
        list(tracks_of(PAPER, flights.rows, flights.paths, [2]))
