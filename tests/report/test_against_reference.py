"""A new run held against the reference: equal, in agreement, or different, and in what."""

import numpy as np

from lawn_sb3.report.against_reference import against_reference
from lawn_sb3.results.results import Results
from tests.handmade import flown, learner, recipe_with, results_of

RECIPE = recipe_with({"mappo": learner("CTDE-MAPPO")})


def made(*rewards: float, utility_mbps: float = 20.0) -> Results:
    return results_of(
        RECIPE,
        *(flown("mappo", seed, reward=[reward], utility_mbps=[utility_mbps]) for seed, reward in enumerate(rewards)),
    )


def verdict(new: Results, reference: Results) -> str:
    return str(against_reference(new, reference).shown.iloc[0]["Against the reference"])


def test_equal_rows_are_called_equal() -> None:
    assert verdict(made(3.0, 3.1), made(3.0, 3.1)) == "equal to the last digit"


def test_seeds_that_overlap_agree_and_seeds_apart_do_not() -> None:
    assert verdict(made(3.0, 3.2), made(3.1, 3.3)) == "agrees"
    assert verdict(made(3.0, 3.01, 3.02), made(4.0, 4.01, 4.02)) == "differs in J̄"
    assert verdict(made(3.0, 3.1, utility_mbps=30.0), made(3.0, 3.1)) == "differs in U"  # no spread in U


def test_one_seed_tells_nothing_unless_it_is_equal() -> None:
    assert verdict(made(3.0), made(9.0)) == "cannot be told from one seed"
    assert verdict(made(3.0), made(3.0)) == "equal to the last digit"


def test_equal_methods_seldom_seem_to_differ() -> None:
    rng = np.random.default_rng(0)
    verdicts = [verdict(made(*rng.normal(size=5)), made(*rng.normal(size=5))) for _ in range(100)]
    # One method and three figures, of which only J̄ has spread here: at most 5 false alarms in a hundred expected.
    assert verdicts.count("agrees") >= 90


def test_methods_that_the_reference_lacks_are_left_out() -> None:
    other = recipe_with({"mine": learner("Mine")})
    assert not len(against_reference(results_of(other, flown("mine", 0)), made(3.0)).shown)
