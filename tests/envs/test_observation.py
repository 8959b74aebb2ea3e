import copy
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lawn_sb3.envs import ObservationLayout, Observer
from lawn_sb3.envs.observation import space_of
from lawn_sb3.game import Missions, Simulator
from lawn_sb3.game.state import State
from lawn_sb3.scenario import PRESETS, Scenario
from tests.envs.corridor import CORRIDOR, DESTINATIONS, ORIGINS, action

few = settings(max_examples=40)
small_scenarios = st.builds(
    lambda num_uavs, columns, rows: Scenario(num_uavs=num_uavs, gbs_grid=(columns, rows), max_slots=20),
    num_uavs=st.integers(1, 6),
    columns=st.integers(1, 3),
    rows=st.integers(1, 3),
)


def corridor_after(slots: int, scenario: Scenario = CORRIDOR) -> Simulator:
    """The corridor after UAV 0 flew east and UAV 1 hovered for some slots."""
    simulator = Simulator(scenario)
    simulator.reset(missions=Missions(ORIGINS, DESTINATIONS))
    east = action(simulator.rules.actions, 1, 0, 0)
    for _ in range(slots):
        simulator.step(np.array([[east, 0]]))
    return simulator


def played(scenario: Scenario, seed: int, num_games: int = 2, slots: int = 3) -> Simulator:
    simulator = Simulator(scenario, num_games, seed)
    rng = np.random.default_rng(seed)
    for _ in range(slots):
        simulator.step(rng.integers(simulator.num_actions, size=simulator.state.slot.shape))
        simulator.go_on()
    return simulator


# The GBSs at (10, 5, 0) m and (30, 5, 0) m lie at voxels (0.5, 0, -0.5) and (2.5, 0, -0.5).
GBS_0 = [0.05, 0.0, -0.05]
GBS_1 = [0.25, 0.0, -0.05]


def test_local_observation_lists_what_eq_obs_lists_in_its_order() -> None:
    simulator = corridor_after(1)  # both at voxel 1, both rated 4 Mbps, EMA 0.5 * 4 = 2 Mbps
    local = Observer(CORRIDOR).local(simulator.state)
    position, ema = [0.1, 0.0, 0.0], [2.0]
    cells = [2 / 4, *GBS_0, 0 / 4, *GBS_1]
    assert local.shape == (1, 2, 16)
    assert local.dtype == np.float32
    np.testing.assert_allclose(local[0, 0], [*position, 0.2, 0, 0, 2 / 10, *ema, *cells], rtol=1e-6)
    np.testing.assert_allclose(local[0, 1], [*position, 0.3, 0, 0, 2 / 10, *ema, *cells], rtol=1e-6)


def test_global_state_lists_what_eq_global_state_lists_in_its_order() -> None:
    simulator = corridor_after(1)
    x = Observer(CORRIDOR).state(simulator.state)
    uav_0 = [0.1, 0, 0, 0.2, 0, 0, 2 / 10, 2.0]
    uav_1 = [0.1, 0, 0, 0.3, 0, 0, 2 / 10, 2.0]
    np.testing.assert_allclose(x, [[*uav_0, *uav_1, 2 / 4, *GBS_0, 0 / 4, *GBS_1]], rtol=1e-6)


def test_a_uav_that_has_arrived_no_longer_shows_in_the_cell_loads() -> None:
    simulator = corridor_after(2)  # UAV 0 arrived at voxel 2 in cell 1 and left, UAV 1 hovers in cell 0
    loads = Observer(CORRIDOR).local(simulator.state)[0, 1, Observer(CORRIDOR).layout.cell_loads]
    np.testing.assert_allclose(loads, [1 / 4, 0 / 4])


def test_ema_rate_is_given_in_the_unit_of_the_rewards() -> None:
    lone_uav = CORRIDOR.changed(rate_unit="lone-uav")
    simulator = corridor_after(1, lone_uav)
    unit_mbps = 5 * 1.0 * math.log2(1 + 150 / 10**2)  # 5 RBs of 1 MHz at one voxel, 10 m
    ema = Observer(lone_uav).local(simulator.state)[0, :, Observer(lone_uav).layout.ema_rate]
    np.testing.assert_allclose(ema, [[2.0 / unit_mbps], [2.0 / unit_mbps]], rtol=1e-6)


def test_one_voxel_is_a_tenth_in_every_airspace() -> None:
    for scenario in PRESETS.values():
        simulator = played(scenario, seed=0)
        observer = Observer(scenario)
        local = observer.local(simulator.state)
        np.testing.assert_allclose(local[..., observer.layout.position], simulator.state.position / 10, rtol=1e-6)
        np.testing.assert_allclose(local[..., observer.layout.destination], simulator.state.destination / 10, rtol=1e-6)


def test_layout_says_where_each_quantity_lies() -> None:
    layout = ObservationLayout(num_uavs=2, num_gbs=2)
    flat = np.arange(layout.flat_dim)
    local, x = flat[layout.local], flat[layout.state]
    assert (layout.local_dim, layout.state_dim, layout.flat_dim) == (16, 24, 40)
    assert local[layout.position].tolist() == [0, 1, 2]
    assert local[layout.destination].tolist() == [3, 4, 5]
    assert local[layout.min_slots].tolist() == [6]
    assert local[layout.ema_rate].tolist() == [7]
    assert local[layout.cell_loads].tolist() == [8, 12]
    assert x[layout.state_uavs].tolist() == list(range(16, 32))
    assert x[layout.state_cells].tolist() == list(range(32, 40))


@given(scenario=small_scenarios, seed=st.integers(0, 2**32 - 1))
@few
def test_flat_observation_is_the_local_one_and_then_the_global_state_as_the_layout_says(
    scenario: Scenario, seed: int
) -> None:
    simulator, observer = played(scenario, seed), Observer(scenario)
    layout, state = observer.layout, simulator.state
    assert (layout.num_uavs, layout.num_gbs) == (scenario.num_uavs, len(scenario.gbs_positions))
    local, x, flat = observer.local(state), observer.state(state), observer.flat(state)
    assert space_of(layout.local_dim).contains(local[0, 0])
    assert space_of(layout.state_dim).contains(x[0])
    assert space_of(layout.flat_dim).contains(flat[0, 0])
    np.testing.assert_array_equal(flat[..., layout.local], local)
    np.testing.assert_array_equal(flat[..., layout.state], np.repeat(x[:, None], scenario.num_uavs, 1))
    own = local[..., : layout.cell_loads.start]
    np.testing.assert_allclose(local[..., layout.min_slots][..., 0], state.min_slots / 10, rtol=1e-6)
    np.testing.assert_allclose(local[..., layout.cell_loads], np.repeat(state.cell_load[:, None] / 4, own.shape[1], 1))
    np.testing.assert_array_equal(x[:, layout.state_uavs].reshape(own.shape), own)
    np.testing.assert_array_equal(x[:, layout.state_cells], local[:, 0, layout.cell_loads.start :])


@given(scenario=small_scenarios, seed=st.integers(0, 2**32 - 1), data=st.data())
@few
def test_other_uavs_show_in_a_local_observation_through_the_cell_loads_alone(
    scenario: Scenario, seed: int, data: st.DataObject
) -> None:
    before, elsewhere = played(scenario, seed).state, played(scenario, seed + 1, slots=7).state
    observer = Observer(scenario)
    uav = data.draw(st.integers(0, scenario.num_uavs - 1))
    after = copy.deepcopy(before)
    others = np.arange(scenario.num_uavs) != uav
    for mine, theirs in zip(after, elsewhere, strict=True):
        if mine is not after.cell_load and mine is not after.past_load:
            mine[:, others] = theirs[:, others]
    np.testing.assert_array_equal(observer.local(after)[:, uav], observer.local(before)[:, uav])

    after.cell_load[:] += 1
    changed = np.flatnonzero((observer.local(after)[:, uav] != observer.local(before)[:, uav]).any(axis=0))
    loads = observer.layout.cell_loads
    assert changed.tolist() == list(range(loads.start, loads.stop, loads.step))


def test_games_do_not_see_each_other() -> None:
    scenario = PRESETS["paper"]
    together, observer = played(scenario, seed=3, num_games=3).state, Observer(scenario)
    for g in range(3):
        alone = State._make(array[g : g + 1] for array in together)
        np.testing.assert_array_equal(observer.flat(together)[g : g + 1], observer.flat(alone))


@pytest.mark.parametrize("num_gbs", [1, 4, 9])
def test_local_observation_is_as_long_for_any_number_of_uavs(num_gbs: int) -> None:
    assert {ObservationLayout(num_uavs, num_gbs).local_dim for num_uavs in (1, 2, 4, 50)} == {8 + 4 * num_gbs}
