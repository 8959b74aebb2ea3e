"""Laws of the game that hold in every scenario, whatever is played."""

import numpy as np
import pytest
from hypothesis import assume, given, settings

from lawn_sb3.game import Missions, Simulator, draw_missions
from lawn_sb3.game.radio import rate_unit_mbps
from lawn_sb3.scenario import Scenario
from tests.game.random_play import SEEDS, random_actions, random_play, scenarios

NUM_GAMES = 2


@given(scenario=scenarios(), seed=SEEDS)
@settings(max_examples=50)
def test_every_slot_keeps_the_game_s_bounds(scenario: Scenario, seed: int) -> None:
    simulator = Simulator(scenario, NUM_GAMES, seed)
    for flew, outcome, state in random_play(simulator, seed, slots=30):
        assert (state.position >= 0).all()
        assert (state.position < scenario.grid).all()
        assert (state.slot <= scenario.max_slots).all()
        # T_min bounds completion from below, hence U_i / R-hat_i = T_min / T_i <= 1.
        assert (state.min_slots <= state.slot)[outcome.arrived].all()
        assert (outcome.utility_mbps <= outcome.corrected_rate_mbps * (1 + 1e-12)).all()
        assert not (outcome.arrived & outcome.timed_out).any()
        np.testing.assert_array_equal(state.flying, flew & ~outcome.arrived & ~outcome.timed_out)
        simulator.go_on()


@given(scenario=scenarios(), seed=SEEDS)
@settings(max_examples=50)
def test_rb_shares_never_exceed_k_b_in_sum(scenario: Scenario, seed: int) -> None:
    simulator = Simulator(scenario, NUM_GAMES, seed, "episode")
    for flew, outcome, _ in random_play(simulator, seed, slots=30):
        assert (outcome.num_rbs * outcome.cell_load <= scenario.num_rbs[outcome.cell]).all()
        for cell, rbs, flying in zip(outcome.cell, outcome.num_rbs, flew, strict=True):
            shared = np.bincount(cell[flying], rbs[flying], minlength=scenario.num_gbs)
            assert (shared <= scenario.num_rbs).all()
        simulator.go_on()


@given(scenario=scenarios(), seed=SEEDS)
@settings(max_examples=50)
def test_one_uav_more_never_raises_the_rates_of_the_others(scenario: Scenario, seed: int) -> None:
    assume(scenario.num_uavs > 1)
    missions = draw_missions(scenario, NUM_GAMES, np.random.default_rng(seed))
    fewer = scenario.num_uavs - 1
    crowded, quieter = Simulator(scenario, NUM_GAMES), Simulator(scenario.changed(num_uavs=fewer), NUM_GAMES)
    crowded.reset(missions=missions)
    quieter.reset(missions=Missions(missions.origins[:, :fewer], missions.destinations[:, :fewer]))
    rng = np.random.default_rng(seed)
    for _ in range(scenario.max_slots):
        actions = random_actions(crowded, rng)
        more, less = crowded.step(actions), quieter.step(actions[:, :fewer])
        np.testing.assert_array_equal(more.cell[:, :fewer], less.cell)
        assert (more.rate_mbps[:, :fewer] <= less.rate_mbps).all()


@given(scenario=scenarios(), seed=SEEDS)
@settings(max_examples=50)
def test_rate_reward_telescopes_to_the_final_ema_rate_over_its_unit(scenario: Scenario, seed: int) -> None:
    simulator = Simulator(scenario, NUM_GAMES, seed)
    played = list(random_play(simulator, seed, slots=scenario.max_slots))
    total = sum(slot.outcome.reward_terms[..., 0] for slot in played)
    # R-bar_i(T) written out: the sum over t of beta (1 - beta)^(T - t) R_i(t).
    beta, age = scenario.ema_beta, simulator.state.slot
    final = sum(
        beta * (1 - beta) ** (age - t) * slot.outcome.rate_mbps * slot.flew for t, slot in enumerate(played, start=1)
    )
    np.testing.assert_allclose(total * rate_unit_mbps(scenario), final, rtol=1e-9, atol=1e-9)


@given(scenario=scenarios(), seed=SEEDS)
@settings(max_examples=50)
def test_nav_reward_telescopes_to_the_distance_covered(scenario: Scenario, seed: int) -> None:
    simulator = Simulator(scenario, NUM_GAMES, seed)
    goal, start = simulator.state.destination.copy(), simulator.state.position.copy()
    total = sum(slot.outcome.reward_terms[..., 1] for slot in random_play(simulator, seed, slots=scenario.max_slots))
    before, after = (np.linalg.norm(place - goal, axis=-1) for place in (start, simulator.state.position))
    assert total == pytest.approx(scenario.nav_weight * (before - after), abs=1e-9)


@given(scenario=scenarios(), seed=SEEDS)
@settings(max_examples=50)
def test_permuting_uavs_permutes_outcomes(scenario: Scenario, seed: int) -> None:
    rng = np.random.default_rng(seed)
    missions = draw_missions(scenario, NUM_GAMES, rng)
    order = rng.permutation(scenario.num_uavs)
    one, other = Simulator(scenario, NUM_GAMES), Simulator(scenario, NUM_GAMES)
    one.reset(missions=missions)
    other.reset(missions=Missions(missions.origins[:, order], missions.destinations[:, order]))
    for _ in range(scenario.max_slots):
        actions = random_actions(one, rng)
        for mine, theirs in zip(one.step(actions), other.step(actions[:, order]), strict=True):
            np.testing.assert_array_equal(mine[:, order], theirs)
        np.testing.assert_array_equal(one.state.cell_load, other.state.cell_load)


@given(scenario=scenarios(), seed=SEEDS)
@settings(max_examples=50)
def test_every_uav_is_done_by_the_deadline(scenario: Scenario, seed: int) -> None:
    simulator = Simulator(scenario, NUM_GAMES, seed)
    ended = np.zeros((NUM_GAMES, scenario.num_uavs))
    for slot in random_play(simulator, seed, slots=scenario.max_slots):
        ended += slot.outcome.arrived.astype(int) + slot.outcome.timed_out
    assert not simulator.state.flying.any()
    assert (ended == 1).all()
