"""UAVs that hover near their start: where they go, and what it gives them."""

import numpy as np

from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.game.airspace import Missions
from lawn_sb3.game.radio import radio_map
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.paper.claims import Finding
from lawn_sb3.paper.claims.flights import iql_rate_artefact
from lawn_sb3.paper.making.hovering import HoveringPlayer
from lawn_sb3.paper.making.make import hovering
from lawn_sb3.scenario import PRESETS
from tests.handmade import evidence, recipe_of_parts


def hovered(origins: list[list[int]]) -> Simulator:
    """Four UAVs of the paper's game, one slot after these starts, all of them to hover."""
    missions = Missions(np.array([origins]), np.array([[[x, y, 2] for x, y, _ in origins]]))
    simulator = Simulator(PRESETS["paper"], continuation="episode")
    simulator.reset(missions=missions)
    player = HoveringPlayer(share_flying=0.0, seeks=True)
    player.start(simulator, np.random.default_rng(0))
    simulator.step(player.act(simulator))
    return simulator


def test_who_hovers_leaves_a_crowded_cell_for_an_empty_one_nearby() -> None:
    # Cells are quarters of 5 x 5 voxels, with GBSs below (2, 2), (2, 7), (7, 2) and (7, 7). All four UAVs start in the
    # first. The last, at (2, 4), can get to 2 of 10 RBs at (2, 2), the best link, or to all 10 at the equally good
    # (2, 7), three steps away; the others have only the first cell within three steps.
    simulator = hovered([[0, 0, 0], [0, 1, 0], [1, 0, 0], [2, 4, 0]])
    assert simulator.state.position[0, 3].tolist() == [2, 7, 0]
    assert simulator.outcome.num_rbs[0].tolist() == [3, 3, 3, 10]  # 10 among three, 10 for one


def test_who_hovers_stays_in_a_cell_it_has_to_itself() -> None:
    # Alone: 10 RBs here as there, and (2, 2) is nearer than (2, 7).
    simulator = hovered([[2, 4, 0], [9, 9, 0], [9, 8, 0], [8, 9, 0]])
    assert simulator.state.position[0, 0].tolist() == [2, 2, 0]


def test_who_hovers_goes_to_the_most_promising_voxel_within_one_slot_and_stays() -> None:
    scenario = PRESETS["paper"]
    simulator = Simulator(scenario, num_games=40, seed=1, continuation="episode")
    origins, loads = simulator.state.position.copy(), simulator.state.cell_load.copy()
    player = HoveringPlayer(share_flying=0.0, seeks=True)
    player.start(simulator, np.random.default_rng(0))
    simulator.step(player.act(simulator))
    spots, still_there = simulator.state.position.copy(), simulator.state.flying.copy()
    steps = np.abs(spots - origins).sum(axis=-1)
    assert steps.max() <= scenario.max_voxel_steps
    cell, rate = radio_map(scenario)
    voxels = np.moveaxis(np.indices(rate.shape), 0, -1)
    for k, (origin, spot) in enumerate(zip(origins.reshape(-1, 3), spots.reshape(-1, 3), strict=True)):
        others = loads[k // scenario.num_uavs].copy()
        others[cell[tuple(origin)]] -= 1
        promised = scenario.num_rbs[cell] // (others[cell] + 1) * rate
        near = np.abs(voxels - origin).sum(axis=-1) <= scenario.max_voxel_steps
        assert promised[tuple(spot)] == promised[near].max()
    simulator.step(player.act(simulator))
    assert (simulator.state.position == spots)[still_there].all()


def test_who_does_not_seek_hovers_where_it_starts() -> None:
    simulator = Simulator(PRESETS["paper"], num_games=40, seed=1, continuation="episode")
    origins = simulator.state.position.copy()
    player = HoveringPlayer(share_flying=0.0, seeks=False)
    player.start(simulator, np.random.default_rng(0))
    for _ in range(3):
        simulator.step(player.act(simulator))
    assert (simulator.state.position == origins).all()


def test_all_that_do_not_hover_arrive_in_the_least_time() -> None:
    rows = evaluate(HoveringPlayer(share_flying=1.0, seeks=False), PRESETS["paper"], 20, 0)
    assert rows["arrived"].all()
    assert (rows["slots"] == rows["min_slots"]).all()


def judged(*changes: str) -> Finding:
    """The claim that hovering explains IQL's rate, held to 100 missions."""
    recipe = recipe_of_parts(changes=changes, episodes=100)
    return iql_rate_artefact(evidence(recipe=recipe, hovering=hovering(recipe, [])))


def test_who_seeks_has_the_printed_rate_and_who_stays_has_not() -> None:
    found = judged()
    assert found.verdict == "contradicted"
    assert "nearby do come to it" in found.why
    # 10 dB less are log2(10) = 3.3 bit/s/Hz less of some 29: a ninth of 44 Mbps, 5 Mbps.
    weak = judged("tx_power_dbm=10")
    assert weak.verdict == "contradicted"
    assert "nearby do not come to it" in weak.why
