"""Table II: means and intervals over seeds beside the paper's values, and the methods held against one of them."""

import numpy as np
import pytest

from lawn_sb3.experiment.recipe import Method
from lawn_sb3.report.sections.table_two import section
from tests.handmade import flown, learner, player, recipe_with, results_of
from tests.report.reading import interval_in, numbers_of, shown_of, table_in

RECIPE = recipe_with(
    {
        "random": Method(label="Random", paper_row="Random", player="random"),
        "mappo": learner("MAPPO", paper_row="CTDE-MAPPO"),
        "mine": learner("Mine"),
    },
    evaluation={"episodes": 1},
)


def test_figures_are_means_over_seeds_with_the_papers_beside_them() -> None:
    # Random: seed 0 fails (0 %), seed 1 arrives (100 %): mean 50; a bootstrap of two seeds reaches from 0 to 100.
    made = results_of(
        RECIPE,
        flown("random", 0, arrived=[False], utility_mbps=[0.0]),
        flown("random", 1, arrived=[True], utility_mbps=[20.0]),
        flown("mappo", 0, makespan_slots=[6]),
        flown("mine", 0),
    )
    table = table_in(section(made), "table2")
    numbers = numbers_of(table)
    assert interval_in(numbers["random"], "success_percent") == [50.0, 0.0, 100.0]
    assert numbers["random"]["utility_mbps"] == 10.0
    assert numbers["random"]["success_percent_paper"] == 22.4
    assert numbers["mappo"]["makespan_slots_paper"] == 8.7
    assert numbers["mappo"]["seeds"] == 1
    assert np.isnan(numbers["mappo"]["success_percent_low"])  # one seed has no interval
    assert np.isnan(numbers["mine"]["reward_paper"])
    shown = shown_of(table)
    assert shown["Random"]["Success (%)"] == "50.0 [0.0, 100.0] (22.4)"
    assert shown["MAPPO"]["T̄ (slots)"] == "6.0 (8.7)"
    assert table.shown["n"].tolist() == ["2 × 1", "1 × 1", "1 × 1"]


def test_in_another_game_nothing_is_said_of_the_paper() -> None:
    made = results_of(RECIPE.model_copy(update={"set": ("num_uavs=5",)}), flown("random", 0), flown("mappo", 0))
    table = table_in(section(made), "table2")
    assert "(" not in table.shown["J̄"].iloc[0]
    assert "paper" not in table.caption
    without = recipe_with({"mine": learner("Mine")}, evaluation={"episodes": 1})
    assert "paper" not in table_in(section(results_of(without, flown("mine", 0))), "table2").caption


def test_learners_are_held_against_straight_flight_in_a_sentence() -> None:
    recipe = recipe_with({"straight": player("shortest-path"), "mappo": learner("Mine"), "iql": learner("Other")})
    # 4 and 2.0 +- 0.1 against 3.0 +- 0.1: 1 is 10 standard errors of 0.1, p = 0.01 with 2 degrees of freedom, of two.
    rows = [flown("straight", seed, reward=[reward], collisions=[1]) for seed, reward in enumerate((2.9, 3.1))]
    rows += [flown("mappo", seed, reward=[reward], collisions=[2]) for seed, reward in enumerate((3.9, 4.1))]
    rows += [flown("iql", seed, reward=[reward]) for seed, reward in enumerate((1.9, 2.1))]
    (sentence,) = section(results_of(recipe, *rows)).summary
    assert sentence.startswith("Beside UAVs that fly straight, 1 of the 2 learners has measurably less J̄ and 1 more")
    assert "the best, Mine, differs by 1.000 [" in sentence
    assert section(results_of(recipe, *rows[2:])).summary == ()
    alone = recipe.model_copy(update={"methods": {key: recipe.methods[key] for key in ("straight", "mappo")}})
    (sentence,) = section(results_of(alone, *rows[:4])).summary
    assert sentence.startswith(
        "Beside UAVs that fly straight, the learner has measurably more J̄ (t test over seeds and "
    )
    assert "missions); it, Mine, differs by 1.000 [" in sentence


def test_shares_of_the_attainable_welfare_are_shown_beside_a_bound_only() -> None:
    # One mission: the bound has 40 Mbps, straight flight 20, MAPPO 30 with seed 0 and 10 with seed 1. The best known is
    # 30, so straight flight has 20/40 to 20/30, and MAPPO on average as much.
    recipe = recipe_with({"bound": player("bound"), "shortest-path": player("shortest-path"), "mappo": learner("Mine")})
    rows = [
        flown("shortest-path", 0, utility_mbps=[20.0]),
        flown("mappo", 0, utility_mbps=[30.0]),
        flown("mappo", 1, utility_mbps=[10.0]),
    ]
    table = table_in(section(results_of(recipe, flown("bound", 0, utility_mbps=[40.0]), *rows)), "table2")
    assert table.shown["Share (%)"].tolist() == ["–", "50.0–66.7", "50.0–66.7"]
    numbers = numbers_of(table)
    assert interval_in(numbers["mappo"], "share_low_percent") == [50.0, 25.0, 75.0]  # the low one is seed 1 alone
    assert np.isnan(numbers["bound"]["share_low_percent"])
    assert "between 30.0 Mbps" in table.caption
    assert "and 40.0 Mbps" in table.caption
    without = table_in(section(results_of(recipe, *rows)), "table2")
    assert "Share (%)" not in without.shown
    assert "Share" not in without.caption


PAIR = recipe_with({"mine": learner("Mine", "centralized_critic"), "paper": learner("Paper's", "state_critic")})


def test_the_papers_critic_is_what_others_are_held_against() -> None:
    both = table_in(section(results_of(PAIR, flown("mine", 0), flown("paper", 0))), "comparison")
    assert "difference to Paper's on" in both.caption
    alone = table_in(section(results_of(PAIR, flown("mine", 0))), "comparison")
    assert "difference to Mine on" in alone.caption
    none = recipe_with({"iql": learner("IQL", algo="iql")})
    assert "comparison" not in section(results_of(none, flown("iql", 0))).shown


def test_differences_and_probabilities_by_hand() -> None:
    # Missions (a, b, c, d): mine earns 1, 2, 3, 4 in both seeds, the paper's 0, 2, 4, 0 in both. On a and d mine is
    # better, on b equal, on c worse: P = (1 + 1/2 + 0 + 1) / 4 = 0.625; the difference is (1 + 0 - 1 + 4) / 4 = 1.
    # The middle half of mine's 1, 1, 2, 2, 3, 3, 4, 4 is 2, 2, 3, 3 with mean 2.5.
    made = results_of(
        PAIR,
        *(flown("mine", seed, reward=[1.0, 2.0, 3.0, 4.0]) for seed in (0, 1)),
        *(flown("paper", seed, reward=[0.0, 2.0, 4.0, 0.0]) for seed in (0, 1)),
    )
    table = table_in(section(made), "comparison")
    row = numbers_of(table)["mine"]
    assert row["reward_improvement"] == pytest.approx(0.625)
    assert row["reward_difference"] == pytest.approx(1.0)
    assert row["reward_iqm"] == pytest.approx(2.5)
    shown = shown_of(table)
    assert shown["Mine"]["Δ J̄"] == "1.000 [1.000, 1.000]"
    assert shown["Paper's"]["Δ J̄"] == "–"
