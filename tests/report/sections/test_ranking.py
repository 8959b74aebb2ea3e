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
    assert moved(game((3.0, 3.2), (2.0, 2.1)), game((1.0, 1.1), (2.0, 2.1))) == "Two above One"


def test_a_pair_that_seeds_do_not_tell_apart_has_not_changed_places() -> None:
    assert moved(game((3.0, 3.2), (2.0, 2.1)), game((1.0, 3.0), (2.0, 2.1))) == "none"
    assert moved(game((3.0, 3.2), (2.0, 2.1)), game((3.0, 3.1), (2.0, 2.1))) == "none"
