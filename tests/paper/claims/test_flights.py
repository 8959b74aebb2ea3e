"""Claims that take flights of their own: what an actor reads, and where hovering leads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lawn_sb3.experiment.cell import Cell, cells
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.game.airspace import Missions
from lawn_sb3.game.radio import radio_map
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.paper.claims import Evidence
from lawn_sb3.paper.claims.claim import ROLES, CannotTellError
from lawn_sb3.paper.claims.flights import HoveringPlayer, hovering_explains_rate, ignores_state
from lawn_sb3.results.results import read_results
from lawn_sb3.scenario import PRESETS
from tests.paper.claims.by_hand import evidence, flown, recipe_of

STOCK = "stable_baselines3.common.policies:ActorCriticPolicy"


@pytest.fixture
def trained_cells(
    recipe: Recipe, small_cells: list[Cell], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[Recipe, list[Cell]]:
    """One seed of V([o_i, x]), of the paper's V(x), and of SB3's own actor, which reads all of [o_i | x]."""
    small = recipe.methods["mappo"]
    methods = {
        "state": small.model_copy(update={"policy": "state_critic", "label": "V(x)"}),
        "stock": small.model_copy(update={"policy": STOCK, "label": "Stock"}),
    }
    more = recipe.model_copy(update={"methods": methods, "seeds": (0,)})
    made = cells(more, tmp_path / "more")
    monkeypatch.setattr("lawn_sb3.experiment.train.check_policy", lambda model, name: None)  # it refuses SB3's own
    for cell in made:
        run_cell(cell, lambda env_steps: None)
    whole = recipe.model_copy(update={"methods": {**recipe.methods, **methods}})
    return whole, [*small_cells, *made]


def test_actors_of_the_kit_ignore_the_global_state_and_sb3s_own_does_not(
    trained_cells: tuple[Recipe, list[Cell]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(ROLES, "stock", {"algo": "mappo", "policy": STOCK})
    found = Evidence(read_results(*trained_cells), trained_cells[1])
    own = ignores_state(found, ["mappo", "mappo-o"])
    assert own.verdict == "reproduced"
    # 50 games of four UAVs, x replaced 20 times: 4,000 actions.
    assert own.figure == "actions changed by noise in x, of 4,000 each: V(x): 0; CTDE-MAPPO: 0"
    stock = ignores_state(found, ["stock"])
    assert stock.verdict == "not reproduced"
    assert not stock.figure.endswith("Stock: 0")
    assert ignores_state(found, ["mappo", "stock"]).verdict == "partly"


def test_without_its_model_an_actor_cannot_be_told(recipe: Recipe, small_cells: list[Cell]) -> None:
    results = read_results(recipe, small_cells)
    with pytest.raises(CannotTellError, match="needs the trained model of CTDE-MAPPO"):
        ignores_state(Evidence(results, []), ["mappo-o"])
    for cell in small_cells:
        (cell.directory / "model.zip").unlink(missing_ok=True)
    with pytest.raises(CannotTellError, match=r"needs the trained model of CTDE-MAPPO: .*model\.zip"):
        ignores_state(Evidence(results, small_cells), ["mappo-o"])


def hovering(origins: list[list[int]]) -> Simulator:
    """Four UAVs of the paper's game, one slot after these starts, all of them to hover."""
    missions = Missions(np.array([origins]), np.array([[[x, y, 2] for x, y, _ in origins]]))
    simulator = Simulator(PRESETS["paper"], continuation="episode")
    simulator.reset(missions=missions)
    player = HoveringPlayer(share_flying=0.0)
    player.start(simulator, np.random.default_rng(0))
    simulator.step(player.act(simulator))
    return simulator


def test_who_hovers_leaves_a_crowded_cell_for_an_empty_one_nearby() -> None:
    # Cells are quarters of 5 x 5 voxels, with GBSs below (2, 2), (2, 7), (7, 2) and (7, 7). All four UAVs start in the
    # first. The last, at (2, 4), can get to 2 of 10 RBs at (2, 2), the best link, or to all 10 at the equally good
    # (2, 7), three steps away; the others have only the first cell within three steps.
    simulator = hovering([[0, 0, 0], [0, 1, 0], [1, 0, 0], [2, 4, 0]])
    assert simulator.state.position[0, 3].tolist() == [2, 7, 0]
    assert simulator.outcome.num_rbs[0].tolist() == [3, 3, 3, 10]  # 10 among three, 10 for one


def test_who_hovers_stays_in_a_cell_it_has_to_itself() -> None:
    # Alone: 10 RBs here as there, and (2, 2) is nearer than (2, 7).
    simulator = hovering([[2, 4, 0], [9, 9, 0], [9, 8, 0], [8, 9, 0]])
    assert simulator.state.position[0, 0].tolist() == [2, 2, 0]


def test_who_hovers_goes_to_the_most_promising_voxel_within_one_slot_and_stays() -> None:
    scenario = PRESETS["paper"]
    simulator = Simulator(scenario, num_games=40, seed=1, continuation="episode")
    origins, loads = simulator.state.position.copy(), simulator.state.cell_load.copy()
    player = HoveringPlayer(share_flying=0.0)
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


def test_all_that_do_not_hover_arrive_in_the_least_time() -> None:
    rows = evaluate(HoveringPlayer(share_flying=1.0), PRESETS["paper"], 20, 0)
    assert rows["arrived"].all()
    assert (rows["slots"] == rows["min_slots"]).all()


def test_hovering_can_give_the_printed_rate_unless_the_link_is_worse() -> None:
    found = hovering_explains_rate(evidence(recipe=recipe_of(episodes=100)), "IQL", "iql")
    assert found.verdict == "reproduced"
    assert "(one standard error; paper 44.46) where 25.6 % of the UAVs fly straight" in found.figure
    assert found.why.endswith("it can, so the explanation is possible.")
    # 10 dB less are log2(10) = 3.3 bit/s/Hz less of some 29: a ninth of 44 Mbps, 5 Mbps.
    weak = hovering_explains_rate(evidence(recipe=recipe_of(changes=["tx_power_dbm=10"], episodes=100)), "IQL", "iql")
    assert weak.verdict == "not reproduced"
    assert "falls short by" in weak.why


@pytest.mark.parametrize(
    ("rate", "arrived", "said"),
    [
        (37.0, True, "; our own IQL does not show it: R̂ 37.0 Mbps, success 100.0 %."),
        (50.0, False, "; our own IQL shows the rate: R̂ 50.0 Mbps, success 0.0 %."),
    ],
)
def test_whether_our_own_runs_show_the_rate_is_told_and_decides_nothing(rate: float, arrived: bool, said: str) -> None:
    own = flown("iql", rate_mbps=[[rate]] * 2, arrived=[[arrived]] * 2)
    found = hovering_explains_rate(evidence(own, recipe=recipe_of(episodes=100)), "IQL", "iql")
    assert found.verdict == "reproduced"
    assert found.why.endswith(said)
