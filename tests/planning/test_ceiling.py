"""The ceiling of a tiny game: against all policies there are, in the order of what is known, and above every player."""

from itertools import pairwise, product

import numpy as np
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.ceilings import earned
from lawn_sb3.game.player import Player
from lawn_sb3.planning import BestRoutePlayer, ForecastPlayer, MeanFieldPlayer, ShortestPathPlayer, WelfarePlayer
from lawn_sb3.planning.ceiling import KNOWN, Ceiling, TinyGames, ceiling, joint_optimum_mbps, tiny_games
from lawn_sb3.scenario import PRESETS, Scenario

SQUARE = PRESETS["tiny"].changed(width_voxels=2, length_voxels=2, max_voxel_steps=1)
PLANE = PRESETS["tiny"].changed(width_voxels=3, length_voxels=3, max_voxel_steps=2)


@pytest.fixture(scope="module", params=[SQUARE, PLANE], ids=["square", "plane"])
def game(request: pytest.FixtureRequest) -> Scenario:
    scenario: Scenario = request.param
    return scenario


@pytest.fixture(scope="module")
def games(game: Scenario) -> TinyGames:
    return tiny_games(game)


@pytest.fixture(scope="module")
def found(games: TinyGames) -> dict[str, Ceiling]:
    return {name: ceiling(games, known) for name, known in KNOWN.items()}


def test_missions_and_flights_of_the_square_counted_by_hand() -> None:
    # 4 * 3 * 2 * 1 missions. Both fly a diagonal in 2 * 4 of them, the other way round or along: two ways each. One
    # cannot fly the diagonal alone: the four voxels are two origins and two destinations.
    games = tiny_games(SQUARE)
    assert len(games.origin) == 24
    diagonal = np.bincount(games.mission) == 4
    assert diagonal.sum() == 8
    assert len(games.mission) == 8 * 4 + 16


def test_the_square_against_all_pairs_of_policies() -> None:
    """Who knows nothing of the other has two ways on each of four diagonals: 16 policies, 256 pairs."""
    games = tiny_games(SQUARE)
    diagonals = [(0, 3), (1, 2), (2, 1), (3, 0)]
    best = -np.inf
    for ways in product(product((0, 1), repeat=4), repeat=2):
        taken = np.ones(len(games.mission), dtype=bool)
        for uav, way in enumerate(ways):
            for (start, end), turn in zip(diagonals, way, strict=True):
                on_it = (games.origin[games.mission, uav] == start) & (games.destination[games.mission, uav] == end)
                corner = sorted({0, 1, 2, 3} - {start, end})[turn]
                taken &= ~on_it | (games.through[:, uav] == corner)
        assert taken.sum() == 24
        best = max(best, games.utility_mbps[taken].sum() / 24)
    at_most, reached = ceiling(games, KNOWN["nothing of the other"])
    assert reached == pytest.approx(best, abs=1e-9)
    assert at_most >= best - 1e-9


def test_knowing_more_is_never_worth_less_and_knowing_all_is_the_joint_optimum(
    games: TinyGames, found: dict[str, Ceiling]
) -> None:
    bounds = [rung.at_most_mbps for rung in found.values()]
    assert all(less <= more + 1e-7 for less, more in pairwise(bounds))
    assert found["its intents"].at_most_mbps == pytest.approx(joint_optimum_mbps(games), abs=1e-6)
    assert found["its intents"].found_mbps == pytest.approx(joint_optimum_mbps(games), abs=1e-9)
    for at_most, reached in found.values():
        assert reached <= at_most + 1e-9


@pytest.mark.parametrize(
    ("player", "knows"),
    [
        (ShortestPathPlayer(), "nothing of the other"),
        (BestRoutePlayer(), "nothing of the other"),
        (ForecastPlayer(), "loads"),
        (MeanFieldPlayer(rounds=3, episodes=500), "loads"),
        (WelfarePlayer(starts=2, slack=0), "its intents"),
    ],
    ids=lambda value: getattr(value, "name", value),
)
def test_no_player_is_above_the_ceiling_of_what_it_knows(
    player: Player, knows: str, game: Scenario, games: TinyGames, found: dict[str, Ceiling]
) -> None:
    utility_mbps, late_percent = earned(player, game, games)
    assert late_percent == 0.0
    assert 0.0 < utility_mbps <= found[knows].at_most_mbps + 1e-9


def test_the_welfare_planner_is_at_the_joint_optimum_of_the_square() -> None:
    games = tiny_games(SQUARE)
    assert earned(WelfarePlayer(slack=0), SQUARE, games) == pytest.approx((joint_optimum_mbps(games), 0.0), abs=1e-9)


def test_who_comes_later_is_said_to_be_late_and_may_have_more_than_the_ceiling() -> None:
    games = tiny_games(PLANE)
    utility_mbps, late_percent = earned(WelfarePlayer(slack=1), PLANE, games)
    assert late_percent > 0.0
    assert utility_mbps > joint_optimum_mbps(games)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"num_uavs": 3}, "num_uavs = 3: the ceiling is worked out for 2 UAVs"),
        ({"width_voxels": 5}, r"missions of 7 voxel steps: at most 6"),
        ({"max_slots": 1}, r"missions of 6 voxel steps: at most 3"),
        ({"max_altitude_m": 30.0, "max_voxel_steps": 9}, "4,669,920 joint flights or more: at most 1,000,000"),
        ({"width_voxels": 5, "length_voxels": 5, "max_voxel_steps": 4}, "joint flights or more: at most 1,000,000"),
    ],
)
def test_a_game_that_is_not_tiny_is_refused(changes: dict[str, float], said: str) -> None:
    with pytest.raises(UserError, match=said):
        tiny_games(PRESETS["tiny"].changed(**changes))
