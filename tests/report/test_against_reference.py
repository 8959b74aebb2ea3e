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


MANY = recipe_with({f"m{k}": learner(f"M{k}") for k in range(8)})


def many(*rewards: list[float]) -> Results:
    """Eight methods with three seeds each; those that are not given always have the same."""
    by_seed = [*rewards, *[[0.0, 0.1, 0.2]] * (8 - len(rewards))]
    return results_of(MANY, *(flown(f"m{k}", s, reward=[own[s]]) for k, own in enumerate(by_seed) for s in range(3)))


def test_equal_methods_seldom_seem_to_differ() -> None:
    rng = np.random.default_rng(0)
    tables = [against_reference(*(many(*rng.normal(size=(8, 3)).tolist()) for _ in range(2))) for _ in range(60)]
    alarms = sum(any("differs" in text for text in table.shown["Against the reference"]) for table in tables)
    # Of tables, not of rows, one in twenty may hold a false alarm: 3 expected. Uncorrected it would be one in three.
    assert alarms <= 8


def test_a_difference_counts_if_holm_rejects_it_among_all_that_are_tested() -> None:
    # Difference 1, variance 0.01 and no spread in the reference: standard error 0.058 with 2 degrees of freedom,
    # t = 17, p = 0.003. Difference 0.5: t = 8.7, p = 0.013.
    large, small, none = [0.9, 1.0, 1.1], [0.4, 0.5, 0.6], [-0.1, 0.0, 0.1]
    table = against_reference(many(large, small, none, none), many(*[[0.0] * 3] * 4))
    # 0.003 <= 0.05 / 4 and 0.013 <= 0.05 / 3.
    assert table.shown["Against the reference"].tolist()[:4] == ["differs in J̄", "differs in J̄", "agrees", "agrees"]
    assert "Holm's correction over all 4 differences" in table.caption
    # 0.013 > 0.05 / 4, though its interval leaves 0 out; those that have the same are no tests.
    table = against_reference(many(large, small, none, none, none), many(*[[0.0] * 3] * 5))
    assert table.shown["Against the reference"].tolist() == [
        "differs in J̄", *["agrees"] * 4, *["equal to the last digit"] * 3
    ]  # fmt: skip
    assert table.numbers["reward_low"][1] > 0.0
    assert "Holm's correction over all 5 differences" in table.caption


def test_methods_that_the_reference_lacks_are_left_out() -> None:
    other = recipe_with({"mine": learner("Mine")})
    assert not len(against_reference(results_of(other, flown("mine", 0)), made(3.0)).shown)
