"""Policies for large airspaces and for swarms: what they see, and that no weight depends on the game."""

import numpy as np
import pytest
import torch as th

from lawn_sb3.algos.common.around import Around
from lawn_sb3.algos.common.outlook import MOST_LOST, Outlook
from lawn_sb3.algos.common.scales import MORE, AtScales
from lawn_sb3.algos.mappo import EpisodeMAPPO
from lawn_sb3.envs import Observer, make_vec_env
from lawn_sb3.game.airspace import Missions, action_table
from lawn_sb3.game.radio import rate_unit_mbps
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.scenario import PRESETS, Scenario
from policies.foresees_cells import ForeseesCellsPolicy
from policies.knows_cells import KnowsCellsPolicy
from tests.planning.test_first_moves import losses

PAPER = PRESETS["paper"]


def seen_by(
    scenario: Scenario, origins: list[list[int]], destinations: list[list[int]], kind: type[Around] = Around
) -> tuple[Around, th.Tensor]:
    simulator = Simulator(scenario, 1, seed=0, continuation="episode")
    simulator.reset(missions=Missions(np.array([origins]), np.array([destinations])))
    observer = Observer(scenario, ["clock"])
    return kind(scenario, observer.layout), th.as_tensor(observer.seen(simulator.state)[0])


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


@pytest.mark.parametrize("kind", [Around, Outlook])
def test_turned_airspaces_look_the_same_and_moves_are_turned_back(kind: type[Around]) -> None:
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

    around, seen = seen_by(PAPER, turned(origins, 0), turned(destinations, 0), kind)
    features, turn = around(seen)
    moves = action_table(PAPER.max_voxel_steps)
    answers = th.as_tensor(moves[:, :2] @ np.array([10, 1])).float()[None]  # tells horizontal moves apart
    for k in range(1, 8):
        _, elsewhere = seen_by(PAPER, turned(origins, k), turned(destinations, k), kind)
        others, other_turn = around(elsewhere)
        th.testing.assert_close(others[0], features[0])
        best = [int(around.turn_back(answers, which[:1]).argmax()) for which in (turn, other_turn)]
        ends = [np.array(start)[0] + moves[a] for start, a in zip((origins, turned(origins, k)), best, strict=True)]
        assert turned(ends[0][None], k)[0] == ends[1].tolist()


@pytest.mark.parametrize("policy", [KnowsCellsPolicy, ForeseesCellsPolicy])
def test_no_weight_depends_on_how_many_uavs_or_cells_there_are(policy: type[KnowsCellsPolicy]) -> None:
    games = [PRESETS["tiny"], PAPER.grown(16), PAPER.changed(gbs_positions_m=((25.0, 25.0, 0.0), (75.0, 60.0, 0.0)))]
    models = [
        EpisodeMAPPO(policy, make_vec_env(game, 1, seed=0, continuation="episode", extras=["clock"], slack=0))
        for game in games
    ]
    shapes = [{name: value.shape for name, value in model.policy.state_dict().items()} for model in models]
    assert shapes[0] == shapes[1] == shapes[2]


def test_losses_are_told_in_the_order_of_the_turned_moves() -> None:
    # From (5, 2, 0) to (5, 8, 0) in two slots: the one move in time is along y, which after the turn is along x.
    outlook, seen = seen_by(PAPER.changed(num_uavs=1), [[5, 2, 0]], [[5, 8, 0]], Outlook)
    assert isinstance(outlook, Outlook)
    features, turn = outlook(seen)
    moves = action_table(PAPER.max_voxel_steps)
    lost = outlook.losses_of(features)
    assert moves[int(lost.argmin())].tolist() == [3, 0, 0]
    assert moves[int(outlook.turn_back(lost, turn).argmin())].tolist() == [0, 3, 0]
    assert sorted(set(lost[0].tolist())) == [0.0, MOST_LOST]


def test_an_untrained_actor_that_trusts_the_forecast_flies_as_it_does() -> None:
    game = PAPER.grown(16)
    env = make_vec_env(game, 8, seed=0, continuation="episode", extras=["clock"], slack=0)
    model = EpisodeMAPPO(ForeseesCellsPolicy, env, policy_kwargs={"trust": 10_000})
    simulator = env.games[0].simulator
    obs = env.reset()
    for _ in range(4):
        moves, _ = model.predict(np.asarray(obs), deterministic=True, action_masks=env.action_masks())
        for g, chosen in enumerate(moves.reshape(8, -1)):
            lost_mbps = losses(simulator, g)
            assert (lost_mbps[range(16), chosen] < 0.01)[simulator.state.flying[g]].all()
        obs, *_ = env.step(moves)


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
