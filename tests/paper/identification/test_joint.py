"""The joint search: every reading with the free constants fitted, and what the allowed games share."""

import numpy as np
import pandas as pd
import pytest

from lawn_sb3.experiment.evaluation import evaluate, evaluation_games
from lawn_sb3.game.airspace import moves_inside
from lawn_sb3.game.player import RandomPlayer
from lawn_sb3.game.radio import rate_unit_mbps
from lawn_sb3.paper.identification.allowed import (
    as_game,
    conclusion_findings,
    conclusions,
    consistent,
    examples,
    joint_findings,
    success_by_reading,
)
from lawn_sb3.paper.identification.bounds import draw_legs, rate_terms_mbps, rewards
from lawn_sb3.paper.identification.candidates import PAPER, PRINTED
from lawn_sb3.paper.identification.joint import (
    OF_FLIGHTS,
    FeasibleRandomPlayer,
    Reading,
    _row,
    _weights,
    joint_search,
    readings,
)
from lawn_sb3.paper.printed_values import TABLE_II
from lawn_sb3.planning import ShortestPathPlayer

AS_PRESET = Reading(PAPER.grid, 3, "clip", "leaves", "slot-end")
READ = [
    AS_PRESET,
    AS_PRESET._replace(arrived_uav="stays"),
    AS_PRESET._replace(moves="hover"),
    AS_PRESET._replace(arrival="fly-through"),
    AS_PRESET._replace(grid=PRINTED.grid),
]


@pytest.fixture(scope="module")
def games() -> pd.DataFrame:
    return joint_search(300, 50_000, lambda: None, READ)


def of(games: pd.DataFrame, reading: Reading) -> pd.DataFrame:
    return games[(games[list(Reading._fields)] == pd.Series(reading._asdict())).all(axis=1)]


def test_the_readings_are_all_different_and_hold_the_preset_and_the_printed_grid() -> None:
    every = list(readings())
    assert len(set(every)) == len(every)
    assert AS_PRESET.game() == PAPER
    assert {AS_PRESET, AS_PRESET._replace(grid=PRINTED.grid)} <= set(every)


def test_feasible_moves_stay_inside_and_are_equally_likely() -> None:
    simulator, player = evaluation_games(PAPER, 4_000, 1), FeasibleRandomPlayer()
    simulator.state.position[:] = 0  # in a corner 20 of the 63 moves stay inside
    player.start(simulator, np.random.default_rng(0))
    actions = player.act(simulator)
    inside = moves_inside(np.zeros(3, dtype=np.int64), simulator.rules.actions, PAPER.grid)
    counts = np.bincount(actions.ravel(), minlength=len(inside))
    assert (counts[~inside] == 0).all()
    expected = actions.size / inside.sum()
    assert np.abs(counts[inside] - expected).max() < 5.0 * np.sqrt(expected)


def test_the_fitted_constants_give_the_printed_rate_and_reward_of_random(games: pd.DataFrame) -> None:
    game = of(games, AS_PRESET._replace(arrived_uav="stays")).iloc[0]
    constants = {name: game[name] for name in ("tx_power_dbm", "nav_weight", "collision_penalty", "fail_penalty")}
    rows = evaluate(AS_PRESET.player, PAPER.changed(arrived_uav="stays", **constants), 300, 50_000)
    printed = TABLE_II["Random"]
    assert rows["rate_mbps"].mean() == pytest.approx(printed.rate_mbps, abs=0.05)
    assert rows["reward"].mean() == pytest.approx(printed.reward, abs=0.01)
    assert game["tx_power_dbm"] > PAPER.tx_power_dbm + 3.0  # who stays takes RBs: it needs a better link


@pytest.mark.parametrize("bias_horizon", ["completion", "deadline"])
def test_the_weight_of_progress_leaves_ctde_mappo_its_reward(bias_horizon: str) -> None:
    far = AS_PRESET._replace(grid=(14, 14, 3), arrival="fly-through")  # long missions: 0.5 would earn more than 3.19
    fitted = joint_search(100, 50_000, lambda: None, [far])
    game = as_game(fitted[fitted["bias_horizon"] == bias_horizon].iloc[0])
    legs, unit = draw_legs(game, 100, 50_000), rate_unit_mbps(game)
    least = rate_terms_mbps(game, legs.min_slots, 35.68, 8.75, largest=False)
    collided = evaluate(RandomPlayer(), game, 100, 50_000)["collisions"].mean()
    assert game.nav_weight < 0.5
    assert rewards(legs, least, game.nav_weight, unit).mean() - collided == pytest.approx(3.19, abs=0.01)


def test_where_random_flies_away_too_far_for_its_reward_a_smaller_penalty_of_collisions_serves_both() -> None:
    legs, unit = draw_legs(PAPER, 300, 50_000), rate_unit_mbps(PAPER)
    terms = pd.Series({"progress_voxels": -8.2, "collisions": 5.0, "failed": 0.9, "rate_sum_mbps": 30.0})
    fitted, against = _weights(PAPER, terms, legs)
    # J of Random is -3.57, and at the upper end of omega CTDE-MAPPO has its 3.19 only if it collides as Random does.
    assert fitted["nav_weight"] < 0.5
    assert fitted["fail_penalty"] == 0.0
    assert 0.0 < fitted["collision_penalty"] < 1.0
    nav, collided = fitted["nav_weight"], 5.0 * fitted["collision_penalty"]
    assert -8.2 * nav - collided + 30.0 / unit == pytest.approx(-3.57, abs=0.01)
    least = rewards(legs, rate_terms_mbps(PAPER, legs.min_slots, 35.68, 8.75, largest=False), nav, unit).mean()
    assert least - collided == pytest.approx(3.19, abs=0.01)
    assert against == []


def test_a_game_whose_constants_nobody_could_mean_is_ruled_out() -> None:
    flights = {name: 0.0 for figure in OF_FLIGHTS for name in (figure, f"z_{figure}")}  # as near as can be
    preset = {
        name: getattr(PAPER, name) for name in ("tx_power_dbm", "nav_weight", "collision_penalty", "fail_penalty")
    }
    assert _row(AS_PRESET, preset, flights)["verdict"] == "consistent"
    for change, reason in (
        ({"collision_penalty": 10.1}, "collision_penalty 10.1"),  # the preset's is 1
        ({"fail_penalty": -0.1}, "fail_penalty -0.1"),
        ({"tx_power_dbm": PAPER.tx_power_dbm + 20.1}, "link_budget_db 131.5"),  # 111.4 dB in the preset
    ):
        row = _row(AS_PRESET, preset | change, flights)
        assert (row["verdict"], row["against"]) == ("ruled out", reason)


def test_the_figures_shown_are_those_that_were_tested(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lawn_sb3.paper.identification.joint.FEW", 100)  # to which the constants are fitted
    game = joint_search(300, 50_000, lambda: None, [AS_PRESET]).iloc[0]
    tested = evaluate(RandomPlayer(), PAPER, 300, 50_000)
    assert game["success_percent"] == pytest.approx(100.0 * tested["arrived"].mean())
    assert game["makespan_slots"] == tested["makespan_slots"].mean()
    few = evaluate(RandomPlayer(), PAPER, 100, 50_000)
    assert game["success_percent"] != pytest.approx(100.0 * few["arrived"].mean())


def test_the_preset_and_uavs_that_stay_are_consistent_and_the_printed_grid_is_not(games: pd.DataFrame) -> None:
    for reading, allowed in ((READ[0], True), (READ[1], True), (READ[3], False), (READ[4], False)):
        assert ("consistent" in set(of(games, reading)["verdict"])) is allowed, reading
    preset = of(games, AS_PRESET)
    deadline = preset[(preset["bias_horizon"] == "deadline") & (preset["gbs_layout"] == "tile-centres")].iloc[0]
    assert deadline["against"] == "R̂ of CTDE-MAPPO in its T̄"  # no flight of 8.7 slots has it, with this link
    assert len(of(games, READ[4])) == 1  # too far off to be fitted


def test_what_the_allowed_games_share_is_said_and_what_they_do_not_is_not_identified(games: pd.DataFrame) -> None:
    found = joint_findings(games)
    assert found["arrived_uav"].startswith("jointly not identified: in consistent games are leaves (")
    assert found["arrival"].startswith("only slot-end (")
    assert found["grid"].endswith("in none: 100 x 100 x 30 (as printed).")
    none = joint_findings(games.assign(verdict="ruled out"))
    assert none["grid"].startswith("the paper's figures are consistent with no value tried")
    table = success_by_reading(games)
    assert str(table["clip, slot-end"][0]).startswith("**2")
    assert not str(table["clip, fly-through"][0]).startswith("**")


def test_an_example_of_each_reading_departs_from_the_preset_in_that_alone(games: pd.DataFrame) -> None:
    chosen = examples(games)
    assert set(chosen.index) <= set(consistent(games).index)
    first = chosen.iloc[0]
    assert {name: first[name] for name in Reading._fields} == AS_PRESET._asdict()
    stays = chosen[chosen["arrived_uav"] == "stays"].iloc[0]
    assert (stays["grid"], stays["moves"], stays["gbs_layout"]) == (PAPER.grid, "clip", "tile-centres")
    assert examples(games.assign(verdict="ruled out")).empty


def test_conclusions_are_drawn_in_the_allowed_games_by_planners(games: pd.DataFrame) -> None:
    chosen = examples(games).head(2)
    drawn = conclusions(chosen, 20, 50_000)
    game = as_game(chosen.iloc[0])
    straight = evaluate(ShortestPathPlayer(), game, 20, 50_000)
    assert drawn["straight_reward"][0] == straight["reward"].mean()
    assert (drawn["welfare_utility_mbps"] > drawn["straight_utility_mbps"]).all()
    found = conclusion_findings(drawn.assign(straight_reward=[3.0, 3.5]))
    assert "in 1 of 2 games (J̄ 3.00 to 3.50)" in found["straight flight"]
    assert conclusion_findings(drawn.head(0)) == {}
