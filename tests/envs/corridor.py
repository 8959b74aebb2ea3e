"""A corridor of four voxels with two GBSs, small enough to work out by hand what a game in it gives.

Voxel centres lie at x = 5, 15, 25, 35 m, 5 m high; the GBSs stand on the ground at x = 10 m and x = 30 m, so every
voxel is sqrt(50) m from its GBS. There the SNR is 150 / 50 = 3 and an RB of 1 MHz carries log2(4) = 2 Mbps: a UAV
alone in a cell of 5 RBs gets 10 Mbps, two in one cell get floor(5 / 2) = 2 RBs and 4 Mbps each.
"""

import math

import numpy as np

from lawn_sb3.scenario import Scenario

CORRIDOR = Scenario(
    name="corridor",
    num_uavs=2,
    width_voxels=4,
    length_voxels=1,
    max_altitude_m=10.0,
    max_voxel_steps=1,
    max_slots=3,
    gbs_grid=(2, 1),
    rbs_per_gbs=5,
    rb_bandwidth_hz=1e6,
    tx_power_dbm=10.0 * math.log10(150.0),
    ref_gain_db=0.0,
    noise_density_dbm_hz=-60.0,
    ema_beta=0.5,
    rate_unit="mbps",
)

ORIGINS = np.array([[0, 0, 0], [1, 0, 0]])
DESTINATIONS = np.array([[2, 0, 0], [3, 0, 0]])


def action(table: np.ndarray, *displacement: int) -> int:
    """Index of a displacement in an action table."""
    return int(np.flatnonzero((table == displacement).all(axis=1))[0])
