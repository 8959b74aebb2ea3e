"""What a method's UAVs know, and the bits it takes: by hand for the paper's game of 300 voxels and 4 cells."""

import pytest

from lawn_sb3.experiment.knowledge import PLAYERS, RUNGS, bits_of, has_ladder, rung_of
from lawn_sb3.experiment.recipe import Method
from lawn_sb3.experiment.registry import PLAYERS as KNOWN
from lawn_sb3.scenario import PRESETS
from tests.handmade import learner, player

# A cell is one of 4: 2 bits. A voxel is one of 300: 9 bits, and position and destination make 18. All of x adds T_min,
# up to 7 (20 voxel steps at 3 a slot): 3 bits; and the EMA rate: 32.
BITS = {"nothing": 0, "loads": 0, "clock": 0, "memory": 0, "destinations": 2, "intents": 18, "state": 53}


@pytest.mark.parametrize("rung", RUNGS)
def test_each_policy_of_the_ladder_stands_on_its_rung(rung: str) -> None:
    method = learner(rung, policy=f"knows_{rung}", algo="mappo-episodes").model_copy()
    assert rung_of(method) == rung
    assert bits_of(method, PRESETS["paper"]) == BITS[rung]


def test_learners_of_the_paper_see_the_loads() -> None:
    assert rung_of(learner("MAPPO", policy="centralized_critic")) == "loads"
    assert rung_of(learner("IQL", policy="in_time_q", algo="iql")) == "clock"


def test_every_player_has_a_rung_and_nobody_is_heard_by_uavs_that_are_alone() -> None:
    assert set(PLAYERS) == set(KNOWN)
    assert bits_of(player("bound"), PRESETS["paper"]) is None
    assert bits_of(player("mean-field-destinations"), PRESETS["paper"]) == 2
    assert bits_of(Method(label="R", player="random"), PRESETS["paper"]) == 0


def test_three_rungs_with_learners_make_a_ladder() -> None:
    rungs = {key: learner(key, policy=f"knows_{key}", algo="mappo-episodes") for key in ("loads", "clock", "state")}
    assert has_ladder(rungs)
    players = {key: player(key) for key in ("shortest-path", "forecast", "welfare")}
    assert not has_ladder({**rungs, **players, "state": rungs["clock"]})
