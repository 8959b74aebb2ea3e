"""Leads: rows are named in words, with the constants that are changed."""

from lawn_sb3.report.sections.leads import section
from lawn_sb3.results.results import Results
from tests.handmade import flown, learner, recipe_with, results_of
from tests.report.reading import picture_in


def game(*changes: str) -> Results:
    recipe = recipe_with({"one": learner("One"), "two": learner("Two")}).model_copy(update={"set": changes})
    return results_of(recipe, flown("one", 0, reward=[1.0]), flown("two", 0, reward=[3.0]))


def test_changed_games_are_named_in_words_with_what_is_changed() -> None:
    games = {
        "as-is": game(),
        "fail-penalty-halved": game("fail_penalty=2.5"),
        "stays": game("arrived_uav=stays", "tx_power_dbm=25.94", "fail_penalty=5.055"),
    }
    figure = picture_in(section(games), "leads").figure
    shown = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert shown == [
        "as is", "fail penalty halved (r_fail = 2.5)", "stays (P_tx = 25.94 dBm, r_fail = 5.055,\narrived UAV = stays)"
    ]  # fmt: skip
