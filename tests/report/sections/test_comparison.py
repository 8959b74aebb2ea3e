"""Methods held against one of them, mission by mission."""

import pytest

from lawn_sb3.report.sections.table_two import section
from tests.handmade import flown, learner, recipe_with, results_of
from tests.report.reading import numbers_of, shown_of, table_in

RECIPE = recipe_with({"mine": learner("Mine", "centralized_critic"), "paper": learner("Paper's", "state_critic")})


def test_the_papers_critic_is_what_others_are_held_against() -> None:
    both = table_in(section(results_of(RECIPE, flown("mine", 0), flown("paper", 0))), "comparison")
    assert "difference to Paper's on" in both.caption
    alone = table_in(section(results_of(RECIPE, flown("mine", 0))), "comparison")
    assert "difference to Mine on" in alone.caption
    none = recipe_with({"iql": learner("IQL", algo="iql")})
    assert "comparison" not in section(results_of(none, flown("iql", 0))).shown


def test_differences_and_probabilities_by_hand() -> None:
    # Missions (a, b, c, d): mine earns 1, 2, 3, 4 in both seeds, the paper's 0, 2, 4, 0 in both. On a and d mine is
    # better, on b equal, on c worse: P = (1 + 1/2 + 0 + 1) / 4 = 0.625; the difference is (1 + 0 - 1 + 4) / 4 = 1.
    # The middle half of mine's 1, 1, 2, 2, 3, 3, 4, 4 is 2, 2, 3, 3 with mean 2.5.
    made = results_of(
        RECIPE,
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
