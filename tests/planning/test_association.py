"""The association game of one slot: its potential, its equilibria, and that it is the real game's next slot."""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lawn_sb3.errors import UserError
from lawn_sb3.game import Missions
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning.association import association_rates_mbps, cycle_gain, deviation_cycle, one_slot_game
from lawn_sb3.scenario import Scenario
from tests.envs.corridor import CORRIDOR, action
from tests.game.random_play import SEEDS, random_play, scenarios

# Two GBSs of 5 and 3 RBs. An RB carries 1 and 2 Mbps for UAV 0, 4 and 2 Mbps for UAV 1, 3 and 5 Mbps for UAV 2.
NUM_RBS = [5, 3]
RB_RATE_MBPS = [[1.0, 2.0], [4.0, 2.0], [3.0, 5.0]]

# Two GBSs of 5 RBs; an RB carries 1 Mbps for UAV 0 and 2 Mbps for UAV 1, whichever GBS it comes from. Alone with a GBS
# they get 5 RBs, together floor(5 / 2) = 2.
UNLIKE_RB_RATE_MBPS = [[1.0, 1.0], [2.0, 2.0]]


class Game(NamedTuple):
    rb_rate_mbps: NDArray[np.float64]
    num_rbs: list[int]
    choice: list[int]

    @property
    def all_choices(self) -> NDArray[np.int64]:
        """Every joint choice [M^N, N]."""
        num_uavs, num_gbs = self.rb_rate_mbps.shape
        return np.stack(np.meshgrid(*[range(num_gbs)] * num_uavs, indexing="ij"), axis=-1).reshape(-1, num_uavs)


@st.composite
def games(draw: st.DrawFn, least_rate_mbps: float = 0.1) -> Game:
    """Games of up to 4 UAVs and 3 GBSs, some with too few RBs for everybody."""
    num_uavs, num_gbs = draw(st.integers(1, 4)), draw(st.integers(1, 3))
    rates = st.floats(max(least_rate_mbps, 0.1), 10.0) | st.just(least_rate_mbps)
    row = st.lists(rates, min_size=num_gbs, max_size=num_gbs)
    return Game(
        np.array(draw(st.lists(row, min_size=num_uavs, max_size=num_uavs))),
        draw(st.lists(st.integers(1, 9), min_size=num_gbs, max_size=num_gbs)),
        draw(st.lists(st.integers(0, num_gbs - 1), min_size=num_uavs, max_size=num_uavs)),
    )


def test_a_gbs_with_more_uavs_than_rbs_serves_none_of_them() -> None:
    assert association_rates_mbps(RB_RATE_MBPS, NUM_RBS, [1, 1, 1]).tolist() == [2.0, 2.0, 5.0]  # one RB each
    assert association_rates_mbps(RB_RATE_MBPS, [5, 2], [1, 1, 1]).tolist() == [0.0, 0.0, 0.0]


@given(game=games(least_rate_mbps=0.0))
@settings(max_examples=30)
def test_many_joint_choices_at_once_are_each_judged_by_itself(game: Game) -> None:
    together = association_rates_mbps(game.rb_rate_mbps, game.num_rbs, game.all_choices)
    each = [association_rates_mbps(game.rb_rate_mbps, game.num_rbs, choice) for choice in game.all_choices]
    np.testing.assert_array_equal(together, each)
    games_too = np.broadcast_to(game.rb_rate_mbps, (len(each), *game.rb_rate_mbps.shape))
    np.testing.assert_array_equal(association_rates_mbps(games_too, game.num_rbs, game.all_choices), together)


@given(game=games(), data=st.data())
def test_order_of_the_uavs_permutes_rates(game: Game, data: st.DataObject) -> None:
    order = data.draw(st.permutations(range(len(game.choice))))
    permuted = game.rb_rate_mbps[order], game.num_rbs, np.array(game.choice)[order]
    mine = association_rates_mbps(game.rb_rate_mbps, game.num_rbs, game.choice)
    assert association_rates_mbps(*permuted).tolist() == mine[order].tolist()


@given(game=games(least_rate_mbps=0.0))
@example(game=Game(np.ones((4, 3)), [1, 1, 1], [0, 0, 0, 0]))  # RBs for three of four UAVs
def test_every_game_has_an_equilibrium(game: Game) -> None:
    num_uavs, num_gbs = game.rb_rate_mbps.shape
    rates_mbps = association_rates_mbps(game.rb_rate_mbps, game.num_rbs, game.all_choices)
    own_mbps = np.moveaxis(rates_mbps.reshape(*[num_gbs] * num_uavs, num_uavs), -1, 0)  # by UAV and joint choice
    stays = [own * (1 + 1e-9) >= own.max(axis=i, keepdims=True) for i, own in enumerate(own_mbps)]
    assert np.all(stays, axis=0).any()


def test_rates_around_a_cycle_of_two_unlike_uavs_do_not_add_up_to_zero() -> None:
    # Both at GBS 0: 2 * 1 and 2 * 2 Mbps. UAV 0 goes to GBS 1, where it is alone, and so is UAV 1: 5 and 10 Mbps. UAV 1
    # follows: 2 and 4 Mbps. UAV 0 goes back: 5 and 10 Mbps. Then UAV 1 goes back as well.
    cycle = deviation_cycle([0, 0], uavs=(0, 1), targets=(1, 1))
    assert cycle.tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
    rates_mbps = association_rates_mbps(UNLIKE_RB_RATE_MBPS, [5, 5], cycle)
    assert rates_mbps.tolist() == [[2.0, 4.0], [5.0, 10.0], [2.0, 4.0], [5.0, 10.0]]
    # UAV 0 gains 3 Mbps each time it leaves UAV 1, and UAV 1 loses 6 Mbps each time it follows: 3 - 6 + 3 - 6 = -6.
    assert cycle_gain(rates_mbps, (0, 1)) == -6.0
    # In logarithms leaving and following are the same ratio, 5/2.
    assert cycle_gain(np.log(rates_mbps), (0, 1)) == pytest.approx(0.0, abs=1e-12)
    # No other UAV moves.
    around = deviation_cycle([0, 1, 2, 0], uavs=(3, 1), targets=(1, 2))
    assert around.tolist() == [[0, 1, 2, 0], [0, 1, 2, 1], [0, 2, 2, 1], [0, 2, 2, 0]]


@given(seed=SEEDS)
@example(seed=0)
def test_two_uavs_taken_at_random_have_no_potential_of_rates(seed: int) -> None:
    # With shares f_b(1) > f_b(2) the sum is (r_00 - r_10) (f_0(1) - f_0(2)) + (r_01 - r_11) (f_1(1) - f_1(2)), r_ib
    # being what an RB of GBS b carries for UAV i: it is zero with probability zero.
    rng = np.random.default_rng(seed)
    rb_rate_mbps, num_rbs = rng.uniform(1.0, 5.0, (2, 2)), rng.integers(2, 12, 2)
    rates_mbps = association_rates_mbps(rb_rate_mbps, num_rbs, deviation_cycle([0, 0], (0, 1), (1, 1)))
    assert abs(cycle_gain(rates_mbps, (0, 1))) > 1e-9
    assert abs(cycle_gain(np.log(rates_mbps), (0, 1))) < 1e-9


@given(game=games(), data=st.data())
def test_log_rates_add_up_to_zero_around_every_cycle(game: Game, data: st.DataObject) -> None:
    num_uavs, num_gbs = game.rb_rate_mbps.shape
    assume(num_uavs > 1)
    one, other = data.draw(st.permutations(range(num_uavs)))[:2]
    targets = data.draw(st.tuples(*[st.integers(0, num_gbs - 1)] * 2))
    cycle = deviation_cycle(game.choice, (one, other), targets)
    rates_mbps = association_rates_mbps(game.rb_rate_mbps, game.num_rbs, cycle)
    assume((rates_mbps > 0).all())
    assert cycle_gain(np.log(rates_mbps), (one, other)) == pytest.approx(0.0, abs=1e-9)


def test_a_uav_reaches_the_cells_that_one_move_leads_to() -> None:
    # In the corridor voxels 0 and 1 belong to GBS 0, voxels 2 and 3 to GBS 1, and an RB carries 2 Mbps everywhere. With
    # one voxel a slot, UAV 0 in voxel 0 cannot leave GBS 0; UAV 1 in voxel 1 can stay or go on to voxel 2. Of moves
    # that carry the same the first counts: hovering, then those of one step.
    simulator = Simulator(CORRIDOR)
    simulator.reset(missions=Missions(np.array([[0, 0, 0], [1, 0, 0]]), np.array([[2, 0, 0], [3, 0, 0]])))
    rb_rate_mbps, actions = one_slot_game(simulator, 0)
    np.testing.assert_allclose(rb_rate_mbps, [[2.0, 0.0], [2.0, 2.0]])
    assert actions[0, 0] == actions[1, 0] == action(simulator.rules.actions, 0, 0, 0)
    assert actions[1, 1] == action(simulator.rules.actions, 1, 0, 0)
    # Both in cell 0: floor(5 / 2) = 2 RBs, 4 Mbps; once UAV 1 has left, 10 Mbps each.
    assert association_rates_mbps(rb_rate_mbps, CORRIDOR.num_rbs, [[0, 0], [0, 1]]).round(9).tolist() == [
        [4.0, 4.0],
        [10.0, 10.0],
    ]


def test_a_uav_cannot_fly_through_its_destination_to_a_cell_beyond() -> None:
    # From voxel 0 two steps lead to cell 1, but with the destination in voxel 1 the slot ends there.
    scenario = CORRIDOR.changed(num_uavs=1, max_voxel_steps=2, arrival="fly-through")
    for goal, beyond_mbps in ((1, 0.0), (3, 2.0)):
        simulator = Simulator(scenario)
        simulator.reset(missions=Missions(np.array([[0, 0, 0]]), np.array([[goal, 0, 0]])))
        assert one_slot_game(simulator, 0).rb_rate_mbps[0, 1] == pytest.approx(beyond_mbps)


@given(scenario=scenarios(), seed=SEEDS, slots=st.integers(0, 3))
@settings(max_examples=50)
def test_rates_are_those_of_the_next_slot_if_the_uavs_move_so(scenario: Scenario, seed: int, slots: int) -> None:
    simulator, rng = Simulator(scenario, seed=seed), np.random.default_rng(seed)
    for _ in random_play(simulator, seed, slots):
        pass
    flying = simulator.state.flying[0].copy()
    assume(flying.all() or (flying.any() and scenario.arrived_uav == "leaves"))
    rb_rate_mbps, actions = one_slot_game(simulator, 0)
    assert (rb_rate_mbps[~flying] == 0.0).all()
    # Each chooses at random among the cells it can reach.
    choice = np.where(rb_rate_mbps > 0, rng.random(rb_rate_mbps.shape), -1.0).argmax(axis=1)
    outcome = simulator.step(np.take_along_axis(actions, choice[:, None], axis=1).T)
    assert (outcome.cell[0] == choice)[flying].all()
    np.testing.assert_array_equal(
        outcome.rate_mbps[0, flying], association_rates_mbps(rb_rate_mbps[flying], scenario.num_rbs, choice[flying])
    )


@given(scenario=scenarios(num_uavs=1), seed=SEEDS)
@settings(max_examples=30)
def test_no_move_leads_to_a_better_voxel_of_any_cell(scenario: Scenario, seed: int) -> None:
    mine = Simulator(scenario, seed=seed)
    simulator = Simulator(scenario, mine.num_actions)  # one game a move
    simulator.reset(missions=Missions(mine.state.position[0], mine.state.destination[0]))
    outcome = simulator.step(np.arange(simulator.num_actions)[:, None])
    best_mbps = np.zeros((1, scenario.num_gbs))
    for cell, rate_mbps, num_rbs in zip(outcome.cell, outcome.rate_mbps, outcome.num_rbs, strict=True):
        best_mbps[0, cell] = np.maximum(best_mbps[0, cell], rate_mbps / num_rbs)
    np.testing.assert_allclose(one_slot_game(mine, 0).rb_rate_mbps, best_mbps)


@pytest.mark.parametrize("choice", [[0, 2], [-1, 0], [0.0, 1.0]])
def test_a_choice_that_is_no_gbs_is_refused(choice: list[float]) -> None:
    with pytest.raises(UserError, match="index of a GBS: a whole number from 0 to 1"):
        association_rates_mbps(UNLIKE_RB_RATE_MBPS, [5, 5], choice)


def test_shapes_that_do_not_fit_are_refused() -> None:
    for rb_rate_mbps, num_rbs, choice in (
        (UNLIKE_RB_RATE_MBPS, [5, 5], [0]),
        (UNLIKE_RB_RATE_MBPS, [5], [0, 1]),
        ([1.0, 2.0], [5, 5], [0, 1]),
        (UNLIKE_RB_RATE_MBPS, [5, 5], 0),
    ):
        with pytest.raises(UserError, match=r"expected \[..., N, M\], \[M\] and \[..., N\]"):
            association_rates_mbps(rb_rate_mbps, num_rbs, choice)
