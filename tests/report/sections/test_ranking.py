"""Sensitivity: figures and ranks by changed game, and the pairs that change places beyond what seeds explain."""

from lawn_sb3.report.sections.ranking import section
from lawn_sb3.report.table import Table
from lawn_sb3.results.results import Results
from tests.handmade import flown, learner, recipe_with, results_of
from tests.report.reading import table_in

RECIPE = recipe_with({"one": learner("One"), "two": learner("Two")})


def game(one: tuple[float, float], two: tuple[float, float], *changes: str) -> Results:
    return results_of(
        RECIPE.model_copy(update={"set": changes}),
        *(flown("one", seed, reward=[reward]) for seed, reward in enumerate(one)),
        *(flown("two", seed, reward=[reward]) for seed, reward in enumerate(two)),
    )


def ranking(games: dict[str, Results]) -> Table:
    return table_in(section("reward", games), "ranking_reward")


def moved(before: Results, after: Results) -> str:
    return str(ranking({"as-is": before, "changed": after}).shown.iloc[1]["Changed places"])


def test_figures_and_ranks_by_hand() -> None:
    shown = ranking({"as-is": game((3.0, 3.2), (2.0, 2.0))}).shown.iloc[0]
    assert shown["One"] == "3.10 [3.00, 3.20] (1.)"
    assert shown["Two"] == "2.00 [2.00, 2.00] (2.)"
    assert shown["n"] == "2 × 200"


def test_games_are_named_for_readers_and_by_their_keys_for_machines() -> None:
    table = ranking(
        {
            "as-is": game((3.0, 3.2), (2.0, 2.0)),
            "link-budget-halved": game((3.0, 3.2), (2.0, 2.0), "tx_power_dbm=16.99"),
        }
    )
    assert table.shown["Game"].tolist() == ["as is", "link budget halved (P_tx = 16.99 dBm)"]
    assert table.numbers["game"].unique().tolist() == ["as-is", "link-budget-halved"]


def test_a_pair_that_is_apart_in_both_games_changes_places() -> None:
    # Apart by 1.0 and 1.0 with a standard error of 0.01: p = 0.0001 with 2 degrees of freedom.
    assert moved(game((3.01, 2.99), (2.01, 1.99)), game((1.01, 0.99), (2.01, 1.99))) == "Two above One"


def test_a_pair_that_seeds_do_not_tell_apart_has_not_changed_places() -> None:
    assert moved(game((3.01, 2.99), (2.01, 1.99)), game((1.0, 3.0), (2.01, 1.99))) == "none"
    assert moved(game((3.01, 2.99), (2.01, 1.99)), game((3.01, 2.99), (2.01, 1.99))) == "none"
    # No seed of one is within those of the other; 1.1 is 5.5 standard errors of 0.2, p = 0.11 with 1 degree.
    assert moved(game((3.4, 3.0), (2.1, 2.1)), game((1.2, 0.8), (2.1, 2.1))) == "none"


def test_a_pair_counts_as_apart_after_holms_correction_over_the_pairs_of_all_games() -> None:
    # Apart by 1.0 with a standard error of 0.14 and 2 degrees of freedom: t = 7.1, p = 0.019, below 0.05 / 2.
    before, after = game((3.1, 2.9), (2.1, 1.9)), game((1.1, 0.9), (2.1, 1.9))
    assert moved(before, after) == "Two above One"
    more = ranking({"as-is": before, "changed": after, "again": after})  # and above 0.05 / 3
    assert more.shown["Changed places"].tolist() == ["–", "none", "none"]
    assert "Holm's correction over all 3 pairs of all games in which seeds vary, as 0 are, or" in more.caption


def test_pairs_in_which_no_seed_varies_need_no_test() -> None:
    flat = game((3.0, 3.0), (2.0, 2.0))
    assert moved(flat, game((1.0, 1.0), (2.0, 2.0))) == "Two above One"
    assert moved(flat, game((2.0, 2.0), (2.0, 2.0))) == "none"
