"""A new run held against the reference: equal, in agreement, or different, and in what."""

from __future__ import annotations

from lawn_sb3.report.against_reference import against_reference
from lawn_sb3.report.results import Results
from tests.report.handmade import flown, learner, recipe_with, results_of

RECIPE = recipe_with({"mappo": learner("CTDE-MAPPO")})


def made(*rewards: float, utility_mbps: float = 20.0) -> Results:
    """One reward a seed."""
    return results_of(
        RECIPE,
        *(flown("mappo", seed, reward=[reward], utility_mbps=[utility_mbps]) for seed, reward in enumerate(rewards)),
    )


def verdict(new: Results, reference: Results) -> str:
    """What the table says."""
    return str(against_reference(new, reference).shown.iloc[0]["Against the reference"])


def test_equal_rows_are_called_equal() -> None:
    assert verdict(made(3.0, 3.1), made(3.0, 3.1)) == "equal to the last digit"


def test_seeds_that_overlap_agree_and_seeds_apart_do_not() -> None:
    assert verdict(made(3.0, 3.2), made(3.1, 3.3)) == "agrees"
    assert verdict(made(3.0, 3.1), made(4.0, 4.1)) == "differs in J̄"
    assert verdict(made(3.0, 3.1, utility_mbps=30.0), made(3.0, 3.1)) == "differs in U"


def test_methods_that_the_reference_lacks_are_left_out() -> None:
    other = recipe_with({"mine": learner("Mine")})
    assert not len(against_reference(results_of(other, flown("mine", 0)), made(3.0)).shown)
