"""What first moves lose by the forecast: by hand, by trying every way, and against the forecast's own moves."""

import itertools

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from lawn_sb3.game import Simulator
from lawn_sb3.game.airspace import Missions, action_table
from lawn_sb3.planning import ForecastPlayer, first_move_losses
from lawn_sb3.scenario import PRESETS, Scenario
from tests.game.random_play import SEEDS, random_play, scenarios

PAPER = PRESETS["paper"]


def losses(simulator: Simulator, game: int = 0) -> np.ndarray:
    """Of all UAVs of a game [N, A]."""
    rules, state = simulator.rules, simulator.state
    here = state.position[game]
    others = np.tile(state.cell_load[game], (len(here), 1))
    others[np.arange(len(here)), rules.cell[tuple(here.T)]] -= 1
    mission = state.min_slots[game], state.slot[game]
    return first_move_losses(rules, here, state.destination[game], *mission, others.clip(min=0))


def test_the_last_move_but_one_by_hand() -> None:
    """Two slots from (0, 0, 0) to (6, 0, 0): only (3, 0, 0) lies three steps from both, so all other moves are late."""
    simulator = Simulator(PAPER.changed(num_uavs=1), 1, continuation="episode")
    simulator.reset(missions=Missions(np.array([[[0, 0, 0]]]), np.array([[[6, 0, 0]]])))
    moves = action_table(PAPER.max_voxel_steps)
    (lost,) = losses(simulator)
    assert lost[(moves == [3, 0, 0]).all(axis=1)].tolist() == [0.0]
    assert np.isinf(lost[~(moves == [3, 0, 0]).all(axis=1)]).all()


def test_as_a_search_of_all_ways_finds_them() -> None:
    """Five steps in two slots, among others; the last slot is over the destination, whatever the way there was.

    The utility of both ways differs in the rate of the next slot alone, so a loss is the difference of these rates.
    """
    game = PAPER.changed(num_uavs=3)
    simulator = Simulator(game, 1, continuation="episode")
    origins, goals = [[2, 3, 0], [3, 3, 1], [6, 6, 0]], [[6, 4, 0], [9, 9, 0], [0, 0, 0]]
    simulator.reset(missions=Missions(np.array([origins]), np.array([goals])))
    rules, loads = simulator.rules, simulator.state.cell_load[0]
    start, goal = np.array(origins[0]), np.array(goals[0])
    rates = []
    for move in action_table(PAPER.max_voxel_steps):
        end = start + move
        inside = (end >= 0).all() and (end < rules.grid).all()
        if not inside or np.abs(goal - end).sum() > PAPER.max_voxel_steps or (end == goal).all():
            rates.append(-np.inf)
            continue
        cell = rules.cell[tuple(end)]
        others = loads[cell] - (cell == rules.cell[tuple(start)])
        rates.append(rules.num_rbs[cell] // (others + 1) * rules.rb_rate_mbps[tuple(end)])
    expected = max(rates) - np.array(rates)
    assert np.isfinite(expected).sum() > 1
    np.testing.assert_allclose(losses(simulator)[0], expected, rtol=1e-4, atol=1e-4)


@given(scenario=scenarios(max_slots=30), seed=SEEDS, slots=st.integers(0, 3))
@settings(max_examples=60)
def test_the_forecast_flies_a_move_that_loses_nothing(scenario: Scenario, seed: int, slots: int) -> None:
    simulator = Simulator(scenario, 1, seed, continuation="episode")
    simulator.reset()
    for _ in itertools.islice(random_play(simulator, seed, slots), slots):
        simulator.go_on()
    state = simulator.state
    late = state.slot + 1 > state.min_slots  # the forecast may then have no time left for any flight
    assume(state.flying.any() and not late[state.flying].any())
    player = ForecastPlayer()
    player.start(simulator, np.random.default_rng(0))
    moves, lost = player.act(simulator)[0], losses(simulator)
    for i in np.flatnonzero(state.flying[0]):
        assert lost[i].min() == 0.0
        assert lost[i, moves[i]] == pytest.approx(0.0, abs=1e-4)
