"""What a training needs is worked out before it starts."""

from pathlib import Path
from typing import Any

import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.memory import check_memory, experience_bytes
from lawn_sb3.experiment.recipe import Evaluation, Method
from lawn_sb3.scenario import load_scenario


def cell(algo: str, *changes: str, num_games: int = 64, **settings: Any) -> Cell:
    method = Method(label="M", algo=algo, env_steps=1, num_games=num_games, settings=settings)
    return Cell("m", method, 0, load_scenario("paper", changes), Evaluation(), Path("nowhere"))


def test_a_rollout_holds_flat_observations_of_all_games() -> None:
    # 2 games of 4 UAVs, [o_i | x] = 24 + 48 numbers of 4 bytes: 2,304 bytes a slot, now and in 8 slots of the rollout
    assert experience_bytes(cell("mappo", num_games=2, n_steps=8)) == 2_304 * (1 + 8)


def test_a_replay_holds_local_observations_before_and_after() -> None:
    # 4 UAVs, o_i = 24 numbers, twice: 768 bytes for each of 100 transitions, besides the 2,304 of the slot itself
    assert experience_bytes(cell("iql", num_games=2, buffer_size=100)) == 2_304 + 76_800


def test_what_has_no_room_is_refused_with_what_it_needs() -> None:
    check_memory(cell("mappo", num_games=64, n_steps=64))
    many = ("num_uavs=1024", "gbs_grid=[20,20]", "width_voxels=200", "length_voxels=200", "max_altitude_m=600")
    with pytest.raises(UserError, match=r"needs \d+ GiB for its observations alone, this machine has \d+: give"):
        check_memory(cell("mappo", *many, num_games=640, n_steps=256))
