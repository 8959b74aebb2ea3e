"""Random small scenarios for Hypothesis, and uniformly random play in them."""

import copy
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from hypothesis import strategies as st

from lawn_sb3.game import Simulator
from lawn_sb3.game.state import Outcome, State
from lawn_sb3.scenario import Scenario

SEEDS = st.integers(0, 2**32 - 1)
GBS_GRIDS = [(1, 1), (1, 2), (2, 1), (2, 2), (1, 3), (5, 1)]


@st.composite
def scenarios(draw: st.DrawFn, /, **fixed: Any) -> Scenario:
    """Scenarios of up to 6 UAVs and 5 GBSs in up to 5 x 5 x 3 voxels, with all readings."""
    # Heights of GBSs and of the airspace's floor are whole voxels, so that no GBS lies on a voxel centre.
    size = draw(st.sampled_from([1.0, 7.5, 10.0]))
    floor = draw(st.sampled_from([0.0, 2 * size]))
    width, length, layers = draw(st.integers(2, 5)), draw(st.integers(1, 5)), draw(st.integers(1, 3))
    halves, heights = st.integers(-2, 12).map(lambda k: k * size / 2), st.integers(0, 4).map(lambda k: k * size)
    explicit = st.lists(st.tuples(halves, halves, heights), min_size=1, max_size=5)
    sites = draw(st.none() | explicit)
    columns, rows = draw(st.sampled_from(GBS_GRIDS))
    num_gbs = columns * rows if sites is None else len(sites)
    rbs = st.integers(1, 12)
    values = {
        "num_uavs": draw(st.integers(1, min(6, width * length * layers // 2))),
        "width_voxels": width,
        "length_voxels": length,
        "voxel_size_m": size,
        "min_altitude_m": floor,
        "max_altitude_m": floor + layers * size,
        "max_voxel_steps": draw(st.integers(1, 4)),
        "max_slots": draw(st.integers(1, 12)),
        "gbs_grid": (columns, rows),
        "gbs_layout": draw(st.sampled_from(["tile-centres", "corners"])),
        "gbs_height_m": draw(heights),
        "gbs_positions_m": sites,
        "rbs_per_gbs": draw(rbs | st.lists(rbs, min_size=num_gbs, max_size=num_gbs)),
        "rb_bandwidth_hz": draw(st.sampled_from([15e3, 180e3])),
        "path_loss_exponent": draw(st.floats(1.5, 4.0)),
        "tx_power_dbm": draw(st.floats(0.0, 40.0)),
        "ref_gain_db": draw(st.floats(-60.0, 0.0)),
        "ema_beta": draw(st.floats(0.01, 0.99)),
        "nav_weight": draw(st.floats(0.0, 2.0)),
        "collision_penalty": draw(st.floats(0.0, 2.0)),
        "fail_penalty": draw(st.floats(0.0, 10.0)),
        "rate_unit": draw(st.sampled_from(["lone-uav", "mbps"])),
        "out_of_bounds": draw(st.sampled_from(["clip", "hover"])),
        "arrived_uav": draw(st.sampled_from(["leaves", "stays"])),
        "arrival": draw(st.sampled_from(["slot-end", "fly-through"])),
        "bias_horizon": draw(st.sampled_from(["completion", "deadline"])),
    }
    return Scenario.model_validate({**values, **fixed})


class Played(NamedTuple):
    """One slot: who was flying in it, what it gave, and the state it left; copies."""

    flew: np.ndarray
    outcome: Outcome
    state: State


def random_actions(simulator: Simulator, rng: np.random.Generator) -> np.ndarray:
    return rng.integers(simulator.num_actions, size=simulator.state.flying.shape)


def random_play(simulator: Simulator, seed: int, slots: int) -> Iterator[Played]:
    """Play uniformly at random; whether and how UAVs go on is left to the caller."""
    rng = np.random.default_rng(seed)
    for _ in range(slots):
        flew = simulator.state.flying.copy()
        outcome = simulator.step(random_actions(simulator, rng))
        yield Played(flew, copy.deepcopy(outcome), copy.deepcopy(simulator.state))
