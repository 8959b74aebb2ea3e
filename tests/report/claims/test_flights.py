"""Claims that take flights of their own: what an actor reads, where hovering leads, what the welfare could be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lawn_sb3.experiment.cell import run_cell
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.recipe import Cell, Recipe, cells
from lawn_sb3.game.radio import radio_map
from lawn_sb3.game.simulator import Simulator
from lawn_sb3.planning import ShortestPathPlayer
from lawn_sb3.report.claims import Evidence
from lawn_sb3.report.claims.claim import ROLES, CannotTellError
from lawn_sb3.report.claims.flights import HoveringPlayer, hovering_explains_rate, ignores_state, maximises_welfare
from lawn_sb3.report.results import read_results
from lawn_sb3.scenario import PRESETS
from tests.report.claims.by_hand import evidence, flown, recipe_of

STOCK = "stable_baselines3.common.policies:ActorCriticPolicy"


@pytest.fixture
def trained_cells(recipe: Recipe, small_cells: list[Cell], tmp_path: Path) -> tuple[Recipe, list[Cell]]:
    """One seed of V([o_i, x]), of the paper's V(x), and of SB3's own actor, which reads all of [o_i | x]."""
    small = recipe.methods["mappo"]
    methods = {
        "state": small.model_copy(update={"policy": "state_critic", "label": "V(x)"}),
        "stock": small.model_copy(update={"policy": STOCK, "label": "Stock"}),
    }
    more = recipe.model_copy(update={"methods": methods, "seeds": (0,)})
    made = cells(more, tmp_path / "more")
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


def test_who_hovers_goes_to_the_best_voxel_within_one_slot_and_stays() -> None:
    scenario = PRESETS["paper"]
    simulator = Simulator(scenario, num_games=40, seed=1, continuation="episode")
    origins = simulator.state.position.copy()
    player = HoveringPlayer(share_flying=0.0)
    player.start(simulator, np.random.default_rng(0))
    simulator.step(player.act(simulator))
    spots, still_there = simulator.state.position.copy(), simulator.state.flying.copy()
    steps = np.abs(spots - origins).sum(axis=-1)
    assert steps.max() <= scenario.max_voxel_steps
    rate = radio_map(scenario).rb_rate_mbps
    voxels = np.moveaxis(np.indices(rate.shape), 0, -1)
    for origin, spot in zip(origins.reshape(-1, 3), spots.reshape(-1, 3), strict=True):
        near = np.abs(voxels - origin).sum(axis=-1) <= scenario.max_voxel_steps
        assert rate[tuple(spot)] == rate[near].max()
    simulator.step(player.act(simulator))
    assert (simulator.state.position == spots)[still_there].all()


def test_all_that_do_not_hover_arrive_in_the_least_time() -> None:
    rows = evaluate(HoveringPlayer(share_flying=1.0), PRESETS["paper"], 20, 0)
    assert rows["arrived"].all()
    assert (rows["slots"] == rows["min_slots"]).all()


def test_hovering_gives_less_than_the_printed_rate_unless_the_link_is_better() -> None:
    weak = hovering_explains_rate(evidence(recipe=recipe_of(episodes=100)), "IQL")
    assert weak.verdict == "not reproduced"
    assert "(one standard error; paper 44.46) where 25.6 % of the UAVs fly straight" in weak.figure
    # 10 dB more are log2(10) = 3.3 bit/s/Hz more on top of some 26: an eighth.
    strong = hovering_explains_rate(evidence(recipe=recipe_of(changes=["tx_power_dbm=30"], episodes=100)), "IQL")
    assert strong.verdict == "reproduced"


def test_the_welfare_is_held_to_the_best_paths_that_were_drawn() -> None:
    recipe = recipe_of(episodes=5)
    scores = {
        seed: evaluate(ShortestPathPlayer(), recipe.game(), 5, recipe.evaluation.seed, seed)
        .groupby("episode")["utility_mbps"]
        .mean()
        for seed in (0, 1)
    }
    best = float(np.maximum(scores[0], scores[1]).mean())
    found = evidence(
        flown("mappo", utility_mbps=[[best + 1.0] * 5, [best + 3.0] * 5]),
        flown("mappo-o", utility_mbps=[[best - 1.0] * 5, [best - 3.0] * 5]),
        recipe=recipe,
    )
    above = maximises_welfare(found, ["mappo"], draws=2)
    assert above.verdict == "reproduced"
    assert above.figure == f"best of 2 shortest paths: mean U {best:.1f} Mbps; MAPPO: 2.00 [1.00, 3.00] Mbps against it"
    below = maximises_welfare(found, ["mappo-o"], draws=2)
    assert below.verdict == "not reproduced"
    assert below.why.endswith("; MAPPO-O does.")
    assert maximises_welfare(found, ["mappo", "mappo-o"], draws=2).verdict == "partly"


def test_a_welfare_that_cannot_be_told_from_the_best_is_not_held_against_a_policy() -> None:
    recipe = recipe_of(episodes=1)
    drawn = evaluate(ShortestPathPlayer(), recipe.game(), 1, recipe.evaluation.seed)
    best = float(drawn["utility_mbps"].mean())
    found = evidence(flown("mappo", utility_mbps=[[best - 1.0], [best + 1.0]]), recipe=recipe)
    assert maximises_welfare(found, ["mappo"], draws=1).verdict == "reproduced"
    one = evidence(flown("mappo", utility_mbps=[[best]]), recipe=recipe)
    with pytest.raises(CannotTellError, match="two seeds"):
        maximises_welfare(one, ["mappo"], draws=1)
