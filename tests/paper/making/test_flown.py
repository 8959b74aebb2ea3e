"""What the smaller checks fly and plan: the printed grid, the least reward, deviation cycles, and guarantees."""

import numpy as np
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.paper.making.deviation_cycles import deviation_cycles
from lawn_sb3.paper.making.guaranteed import guaranteed
from lawn_sb3.paper.making.least_reward import least_reward
from lawn_sb3.paper.making.make import printed_grid
from lawn_sb3.planning import BoundPlayer
from tests.handmade import recipe_of, recipe_of_parts

TINY = 1e-9


def test_the_printed_grid_takes_longer_than_the_printed_time() -> None:
    # Mean |x - y| of two draws from n values is (n^2 - 1) / 3n: 33.33 twice and 9.99, over three steps a slot 25.5;
    # rounding up adds a third on average.
    rows = printed_grid(recipe_of_parts(episodes=200), [])
    assert rows["min_slots"].mean() == pytest.approx(25.9, abs=1.0)


def test_rates_in_mbps_alone_exceed_the_printed_reward() -> None:
    # A UAV that arrives has R-bar + U = R (1 - 0.9^T + T_min/T). If all flew their 2.8 slots at 35.68 Mbps, that were
    # 35.68 * 1.25; somewhat less is possible, but nothing like 3.19.
    terms = least_reward(recipe_of_parts(episodes=50), [])
    assert terms["uavs"].sum() == 50 * 4
    assert 0.5 * 35.68 < np.average(terms["least_mbps"], weights=terms["uavs"]) < 1.25 * 35.68


def test_one_slot_has_a_potential_in_log_rates_but_not_in_rates() -> None:
    cycles = deviation_cycles(recipe_of_parts(episodes=20), [])
    assert (cycles["log_rate_gain"].abs() < TINY).all()
    assert (cycles["rate_gain_mbps"].abs() > TINY).any()
    assert set(cycles["episode"]) <= set(range(20))
    assert (cycles["uav"] < cycles["other_uav"]).all()


def test_a_single_cell_leaves_nobody_a_choice() -> None:
    with pytest.raises(UserError, match="change their cells"):
        deviation_cycles(recipe_of_parts(changes=["gbs_grid=[1, 1]"], episodes=5), [])


def test_with_equal_links_the_rates_have_a_potential_too() -> None:
    # Two sites among 2 x 2 voxels, each voxel as near to its site as any other: rates depend on the loads alone, which
    # is a congestion game as Rosenthal has them.
    alike = ["num_uavs=2", "width_voxels=2", "length_voxels=2", "max_altitude_m=10", "gbs_grid=[2, 1]"]
    cycles = deviation_cycles(recipe_of_parts(changes=alike, episodes=5), [])
    assert (cycles[["rate_gain_mbps", "log_rate_gain"]].abs() < TINY).all(axis=None)


WAITING = (
    "width_voxels=11", "length_voxels=1", "max_altitude_m=10", "max_voxel_steps=1", "ema_beta=0.05",
    "gbs_positions_m=[[100, 5, 0]]", "path_loss_exponent=10", "tx_power_dbm=-60",
)  # fmt: skip
"""A corridor that is served at its end alone, where it pays to wait."""


@pytest.mark.parametrize("game", [(), WAITING])
def test_a_guarantee_is_the_share_of_the_rbs_that_is_left_of_the_best_flight_alone(game: tuple[str, ...]) -> None:
    # 12 RBs among 3 UAVs leave each 4, a third: every rate is a third of that alone, and so is every utility.
    recipe = recipe_of(3, ("a",), episodes=5).model_copy(update={"set": ("num_uavs=3", "rbs_per_gbs=12", *game)})
    alone = evaluate(BoundPlayer(), recipe.game(), 5, recipe.evaluation.seed)
    assert ((alone["slots"] > alone["min_slots"] + 5).any()) == bool(game)
    found = guaranteed(recipe, [])
    assert found[["episode", "uav"]].to_numpy().tolist() == alone[["episode", "uav"]].to_numpy().tolist()
    assert found["guaranteed_mbps"].to_numpy() == pytest.approx(alone["utility_mbps"].to_numpy() / 3)
