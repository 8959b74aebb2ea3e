"""The ladder: who stands where, what each earns, and the claim that the loads suffice."""

import pandas as pd
import pytest

from lawn_sb3.experiment.recipe import Method
from lawn_sb3.report.sections import ladder, training
from lawn_sb3.results.results import Results
from tests.handmade import flown, player, recipe_with, results_of
from tests.report.reading import numbers_of, picture_in, points_of, table_in


def rung(name: str, **changes: object) -> Method:
    values = {"label": name.capitalize(), "algo": "mappo-episodes", "policy": f"knows_{name}", "env_steps": 1000}
    reward = {"continuation": "episode", "without_reward": ["rate", "nav", "col"]}
    return Method.model_validate({**values, **reward, **changes})


METHODS = {
    "state": rung("state", slack=1),
    "clock": rung("clock"),
    "blind": rung("nothing"),
    "destinations": rung("destinations"),
    "forecast": player("forecast"),
    "bound": player("bound"),
}
UTILITY = {"state": 44.0, "clock": 40.0, "blind": 37.0, "destinations": 42.0, "forecast": 39.0, "bound": 50.0}


def results(**utility: float) -> Results:
    """Two seeds of two missions; the second seed of a learner has 0.2 Mbps more than the first."""
    rows = [
        flown(key, seed, utility_mbps=[value + 0.2 * seed * (METHODS[key].algo is not None)] * 2)
        for key, value in {**UTILITY, **utility}.items()
        for seed in (0, 1)
    ]
    curves = pd.DataFrame(
        {
            "method": ["clock"] * 4,
            "seed": [0, 0, 1, 1],
            "time/env_steps": [10, 20, 12, 26],
            "greedy/utility_mbps": [37.0, 40.0, 38.0, 41.0],
        }
    )
    return results_of(recipe_with(METHODS, evaluation={"episodes": 2}), *rows, curves=curves)


def test_the_table_climbs_from_the_bottom_and_says_what_was_told() -> None:
    table = table_in(ladder.section(results()), "ladder_table")
    assert table.numbers["key"].tolist() == ["blind", "clock", "forecast", "destinations", "state", "bound"]
    assert table.shown["Told (bits)"].tolist() == ["0", "0", "0", "2", "53", "–"]
    assert table.shown["Learns"].tolist() == ["from scratch"] * 2 + ["plans"] + ["from scratch"] * 2 + ["plans"]
    clock = numbers_of(table)["clock"]
    assert clock["utility_mbps"] == pytest.approx(40.1)  # 40.0 and 40.2
    assert clock["over_forecast_mbps"] == pytest.approx(1.1)


def test_the_figure_has_a_place_for_each_rung_and_names_its_lines() -> None:
    ax = picture_in(ladder.section(results()), "ladder").figure.axes[0]
    named = [label.get_text().replace("\n", " ") for label in ax.get_xticklabels()]
    assert named == [
        "nothing of the others 0 bits",
        "loads and the own clock 0 bits",
        "... and how many head for each cell 2 bits",
        "all of x 53 bits",
    ]
    assert {text.get_text().strip() for text in ax.texts} == {"Forecast", "Bound", "//"}  # its axis is cut


def test_a_learning_curve_is_the_mean_over_seeds_whose_batches_end_at_other_env_steps() -> None:
    (line, *_) = picture_in(ladder.section(results()), "ladder_learning").figure.axes[0].get_lines()
    assert points_of(line) == [[11.0, 37.5], [23.0, 40.5]]


def test_a_rung_on_which_only_limits_stand_has_no_place() -> None:
    whole = results()
    few = Results(whole.recipe, whole.episodes[whole.episodes["method"] != "state"])
    few.episodes = pd.concat([few.episodes, flown("welfare", 0, utility_mbps=[47.0, 47.0])])
    few.recipe = recipe_with({**METHODS, "welfare": player("welfare")})
    ax = picture_in(ladder.section(few), "ladder").figure.axes[0]
    assert "Welfare" in {text.get_text().strip() for text in ax.texts}
    assert not any(label.get_text().startswith("all of x") for label in ax.get_xticklabels())


def test_learners_whose_moves_are_in_time_have_no_fig_2() -> None:
    made = results()
    made.curves["greedy/success_percent"] = 100.0
    assert training.section(made) is None
