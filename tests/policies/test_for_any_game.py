"""Policies for large airspaces and for swarms: what they see, and that no weight depends on the game."""

import numpy as np
import pytest
import torch as th

from lawn_sb3.algos.common.around import Around
from lawn_sb3.algos.common.scales import MORE, AtScales
from lawn_sb3.algos.mappo import EpisodeMAPPO
from lawn_sb3.envs import Observer, make_vec_env
from lawn_sb3.game.airspace import Missions, action_table
from lawn_sb3.game.radio import rate_unit_mbps
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.scenario import PRESETS, Scenario
from policies.knows_cells import KnowsCellsPolicy

PAPER = PRESETS["paper"]


def seen_by(scenario: Scenario, origins: list[list[int]], destinations: list[list[int]]) -> tuple[Around, th.Tensor]:
    simulator = Simulator(scenario, 1, seed=0, continuation="episode")
    simulator.reset(missions=Missions(np.array([origins]), np.array([destinations])))
    observer = Observer(scenario, ["clock"])
    return Around(scenario, observer.layout), th.as_tensor(observer.seen(simulator.state)[0])


def test_rates_around_are_what_joining_the_cells_would_give() -> None:
    # Cells of 5 x 5 columns; UAVs 0 and 1 in the first, 2 in the second along x. UAV 0 heads along x, so nothing turns.
    game = PAPER.changed(num_uavs=3)
    around, seen = seen_by(game, [[2, 2, 0], [1, 1, 0], [7, 2, 0]], [[9, 3, 0], [9, 9, 0], [0, 0, 0]])
    features, turn = around(seen)
    places = {tuple(place): k for k, place in enumerate(around.place[0].tolist())}
    rates = features[0, -len(places) :]
    simulator = Simulator(game, 1, seed=0)
    unit = rate_unit_mbps(game)
    assert int(turn[0]) == 0
    for place, num_rbs in (((0, 0, 0), 5), ((1, 1, 0), 5), ((3, 0, 0), 5), ((0, 3, 0), 10), ((6, 6, 0), 10)):
        x, y, z = 2 + place[0], 2 + place[1], place[2]
        expected = num_rbs * simulator.rules.rb_rate_mbps[x, y, z] / unit
        assert float(rates[places[place]]) == pytest.approx(expected, rel=1e-5), place
    assert float(rates[places[(-3, 0, 0)]]) == 0.0  # out of the airspace


def test_turned_airspaces_look_the_same_and_moves_are_turned_back() -> None:
    size = PAPER.width_voxels - 1
    origins, destinations = (
        np.array([[2, 1, 0], [6, 3, 1], [1, 8, 2], [4, 4, 0]]),
        np.array([[7, 4, 1]] + [[0, 0, 2]] * 3),
    )
    destinations[1:] += np.arange(3)[:, None] * [1, 0, 0]

    def turned(voxels: np.ndarray, k: int) -> list[list[int]]:
        x, y, z = voxels.T
        x, y = (y, x) if k & 4 else (x, y)
        return np.stack([size - x if k & 2 else x, size - y if k & 1 else y, z], axis=1).tolist()  # type: ignore[no-any-return]

    around, seen = seen_by(PAPER, turned(origins, 0), turned(destinations, 0))
    features, turn = around(seen)
    moves = action_table(PAPER.max_voxel_steps)
    answers = th.as_tensor(moves[:, :2] @ np.array([10, 1])).float()[None]  # tells horizontal moves apart
    for k in range(1, 8):
        _, elsewhere = seen_by(PAPER, turned(origins, k), turned(destinations, k))
        others, other_turn = around(elsewhere)
        th.testing.assert_close(others[0], features[0])
        best = [int(around.turn_back(answers, which[:1]).argmax()) for which in (turn, other_turn)]
        ends = [np.array(start)[0] + moves[a] for start, a in zip((origins, turned(origins, k)), best, strict=True)]
        assert turned(ends[0][None], k)[0] == ends[1].tolist()


def test_no_weight_depends_on_how_many_uavs_or_cells_there_are() -> None:
    games = [PRESETS["tiny"], PAPER.grown(16), PAPER.changed(gbs_positions_m=((25.0, 25.0, 0.0), (75.0, 60.0, 0.0)))]
    models = [
        EpisodeMAPPO(KnowsCellsPolicy, make_vec_env(game, 1, seed=0, continuation="episode", extras=["clock"], slack=0))
        for game in games
    ]
    shapes = [{name: value.shape for name, value in model.policy.state_dict().items()} for model in models]
    assert shapes[0] == shapes[1] == shapes[2]


def test_the_way_at_several_scales_by_hand() -> None:
    local = th.zeros(1, 10)
    local[0, :6] = th.tensor([1.0, 2.0, 0.5, 3.0, 2.0, 0.4])  # 20 voxels along x, none along y, 1 down
    local[0, 6:] = th.arange(4)
    seen = AtScales()(local)
    assert seen.shape == (1, 10 + MORE)
    th.testing.assert_close(seen[0, :3], local[0, :3] / 10.0)
    ways = seen[0, 3:18].reshape(5, 3)
    th.testing.assert_close(ways[:, 0], th.tensor([1.0, 1.0, 1.0, 2 / 3, 0.2]))
    th.testing.assert_close(ways[:, 1], th.zeros(5))
    th.testing.assert_close(ways[:, 2], th.tensor([-1.0, -1 / 3, -0.1, -1 / 30, -0.01]))
    th.testing.assert_close(seen[0, 18:], local[0, 6:])
