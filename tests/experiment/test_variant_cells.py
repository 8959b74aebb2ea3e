"""Runs of the policies that change more than what a network sees: masks, memory, own actors, a set for a critic."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch as th

from lawn_sb3.algos.mappo import MAPPO, MaskableMAPPO, RecurrentMAPPO
from lawn_sb3.envs import Observer
from lawn_sb3.errors import UserError
from lawn_sb3.experiment.build import build_model
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluate
from lawn_sb3.experiment.players import ModelPlayer, load_player
from lawn_sb3.experiment.recipe import Method
from lawn_sb3.experiment.train import run_cell
from lawn_sb3.game.airspace import moves_inside
from lawn_sb3.game.simulator import Simulator
from tests.experiment.training import ignore, mappo_cell, parameters

POLICIES = {"masked": MaskableMAPPO, "recurrent": RecurrentMAPPO, "separate_actors": MAPPO, "set_critic": MAPPO}


@pytest.mark.parametrize("policy", POLICIES)
def test_the_policy_decides_on_the_class_of_the_algorithm(policy: str, tmp_path: Path) -> None:
    assert type(build_model(mappo_cell(tmp_path, policy))) is POLICIES[policy]


def test_a_masked_player_never_flies_against_the_walls_and_another_does(small_cell: Cell, tmp_path: Path) -> None:
    def moves_out(policy: str) -> int:
        cell = mappo_cell(tmp_path / policy, policy)
        run_cell(cell, ignore)
        player = load_player(cell, deterministic=False)
        games = Simulator(small_cell.scenario, 50, seed=1)
        player.start(games, np.random.default_rng(0))
        out = 0
        for _ in range(20):
            actions = player.act(games)
            allowed = moves_inside(games.state.position, games.rules.actions, games.rules.grid)
            out += int((~np.take_along_axis(allowed, actions[..., None], axis=-1)).sum())
            games.step(actions)
            games.go_on()
        return out

    assert moves_out("masked") == 0
    assert moves_out("centralized_critic") > 0


@pytest.mark.parametrize("policy", ["centralized_critic", "masked", "recurrent", "set_critic"])
def test_an_actor_flies_with_any_number_of_uavs(tmp_path: Path, policy: str) -> None:
    cell = mappo_cell(tmp_path / policy, policy)
    run_cell(cell, ignore)
    for num_uavs in (1, 3, 9):
        rows = evaluate(load_player(cell), cell.scenario.changed(num_uavs=num_uavs), 5, 0)
        assert len(rows) == 5 * num_uavs


def test_an_actor_acts_on_o_alike_whatever_n_it_was_trained_for(tmp_path: Path) -> None:
    """Among nine UAVs, an actor trained with four acts as it does on the same o_i with noise for x."""
    cell = mappo_cell(tmp_path / "run")
    run_cell(cell, ignore)
    player, model = load_player(cell), build_model(cell)
    model.set_parameters(str(cell.directory / "model.zip"))
    games = Simulator(cell.scenario.changed(num_uavs=9), 20, seed=0)
    player.start(games, np.random.default_rng(0))
    actions = player.act(games)
    local = Observer(games.scenario).local(games.state).reshape(-1, 24)
    noise = np.random.default_rng(0).normal(size=(len(local), model.observation_space.shape[0] - 24))  # type: ignore[index]
    flat = np.concatenate([local, noise], axis=1).astype(np.float32)
    np.testing.assert_array_equal(actions.ravel(), model.predict(flat, deterministic=True)[0])


@pytest.mark.parametrize("settings", [{}, {"share_parameters": True}])
def test_networks_that_know_the_uav_are_not_flown_with_others(small_cell: Cell, settings: dict[str, bool]) -> None:
    own = mappo_cell(small_cell.directory, "separate_actors").method
    iql = Method(label="IQL", algo="iql", env_steps=8, num_games=2, settings={"buffer_size": 100, **settings})
    for method in (own, iql):
        model = build_model(replace(small_cell, method=method))
        for num_uavs in (2, 5):
            with pytest.raises(UserError, match=f"was trained for 4 UAVs and 4 GBSs and cannot play with {num_uavs} "):
                evaluate(ModelPlayer(model, "own"), small_cell.scenario.changed(num_uavs=num_uavs), 3, 0)


def test_qmix_flies_with_any_number_of_uavs_by_o_alone(small_cell: Cell) -> None:
    method = Method(label="QMIX", algo="qmix", env_steps=8, num_games=2, settings={"buffer_size": 100})
    model = build_model(replace(small_cell, method=method))
    games = Simulator(small_cell.scenario.changed(num_uavs=7), 3, seed=0)
    player = ModelPlayer(model, "qmix")
    player.start(games, np.random.default_rng(0))
    local = th.as_tensor(Observer(games.scenario).local(games.state).reshape(21, -1))
    np.testing.assert_array_equal(player.act(games).ravel(), model.policy.q_net(local).argmax(dim=1))  # type: ignore[operator]


@pytest.mark.parametrize("term", ["rate", "nav", "col", "term"])
def test_a_reward_term_left_out_of_training_counts_in_the_evaluation(
    small_cell: Cell, tmp_path: Path, term: str
) -> None:
    method = small_cell.method.model_copy(update={"without_reward": (term,)})
    cell = replace(small_cell, method=method, directory=tmp_path / term)
    run_cell(small_cell, ignore)
    run_cell(cell, ignore)
    assert any(not th.equal(value, parameters(small_cell)[name]) for name, value in parameters(cell).items())
    rows = evaluate(load_player(cell), small_cell.scenario, 5, small_cell.evaluation.seed, cell.seed)
    saved = pd.read_csv(cell.directory / "evaluation.csv")
    np.testing.assert_allclose(rows["reward"], saved["reward"], rtol=1e-8)
