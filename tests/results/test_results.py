"""Results: the matrices that statistics are made of."""

import pandas as pd
import pytest

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.results.results import Results, read_results
from tests.handmade import flown, player, recipe_of, recipe_with, results_of


def test_scores_are_means_over_the_uavs_by_seed_and_episode() -> None:
    # Two seeds, two episodes of two UAVs. Seed 0: (1 + 3) / 2 and (5 + 5) / 2; seed 1: (0 + 2) / 2 and (4 + 8) / 2.
    later = flown("a", 1, 2, reward=[0.0, 2.0, 4.0, 8.0])
    earlier = flown("a", 0, 2, reward=[1.0, 3.0, 5.0, 5.0])
    results = results_of(recipe_of(2, ("a",), seeds=2, episodes=2), later, earlier)  # order of reading must not count
    assert results.scores("a", "reward").tolist() == [[2.0, 5.0], [1.0, 6.0]]
    assert results.scores("a", "reward", per="uav").tolist() == [[[1.0, 3.0], [5.0, 5.0]], [[0.0, 2.0], [4.0, 8.0]]]
    assert results.seeds("a") == [0, 1]


def test_scores_of_real_runs_agree_with_their_summary(recipe: Recipe, small_cells: list[Cell]) -> None:
    results = read_results(recipe, small_cells)
    by_seed = results.by_seed().set_index(["method", "seed"])
    for method in results.methods:
        assert results.scores(method, "reward").shape == (2, 6)
        for seed, mean in enumerate(results.scores(method, "reward").mean(axis=1)):
            assert mean == pytest.approx(by_seed.loc[(method, seed), "reward"])
            success = 100.0 * results.scores(method, "arrived")[seed].mean()
            assert success == pytest.approx(by_seed.loc[(method, seed), "success_percent"])


def test_unknown_methods_and_columns_are_refused_with_what_there_is() -> None:
    results = results_of(recipe_of(1, ("a", "b")), flown("a", 0, 1, reward=[1.0]))
    with pytest.raises(UserError, match="unknown method with results 'b'; known: a"):
        results.scores("b", "reward")
    with pytest.raises(UserError, match=r"unknown column 'rewards' \(did you mean 'reward'\?\)"):
        results.scores("a", "rewards")
    with pytest.raises(UserError, match="unknown method with results 'a'"):
        Results(results.recipe).scores("a", "reward")
    assert Results(results.recipe).seeds("a") == results.seeds("b") == []


def test_the_extent_says_how_many_seeds_the_methods_have() -> None:
    recipe = recipe_of(1, ("a", "b"), seeds=2, episodes=1)
    one, two = (flown("a", seed, 1, reward=[1.0]) for seed in (0, 1))
    assert results_of(recipe, one).extent(one) == "1 test episodes of each of 1 seed"
    both = results_of(recipe, one, two)
    assert both.extent(both.episodes) == "1 test episodes of each of 2 seeds"
    uneven = results_of(recipe, one, two, flown("b", 0, 1, reward=[1.0]))
    assert uneven.extent(uneven.episodes) == "1 test episodes of each of 1 to 2 seeds"


def test_the_bound_can_be_left_out_and_the_rest_stays() -> None:
    recipe = recipe_with({"mine": player("bound"), "random": player("random")})
    slots = pd.DataFrame({"method": ["random", "mine"], "seed": [0, 0], "slot": [1, 1]})
    both = results_of(recipe, flown("mine", 0), flown("random", 0), slots=slots)
    rest = both.without_bound()
    assert list(rest.methods) == list(rest.methods_in(rest.slots)) == ["random"]
    assert rest.recipe is recipe  # colours are dealt out by the recipe
    assert list(both.methods) == list(both.methods_in(both.slots)) == ["mine", "random"]
    assert results_of(recipe, flown("mine", 0)).without_bound().methods == {}
