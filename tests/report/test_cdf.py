"""Distributions: which methods share a panel, and what its curves are."""

import numpy as np
import pytest

from lawn_sb3.experiment.recipe import Method
from lawn_sb3.report.cdf import distributions, planners, references
from lawn_sb3.report.sections import utility_cdf
from lawn_sb3.results.results import Results
from tests.handmade import flown, learner, player, recipe_with, results_of
from tests.report.reading import picture_in

METHODS: dict[str, Method] = {
    "random": player("random"),
    "shortest-path": player("shortest-path"),
    "qmix": learner("QMIX", algo="qmix"),
    "mappo": learner("MAPPO", "centralized_critic"),
    "welfare": player("welfare"),
    "bound": player("bound"),
}


def drawn(methods: dict[str, Method]) -> tuple[list[list[str]], str]:
    results = results_of(recipe_with(methods), *(flown(key, 0, utility_mbps=[4.0]) for key in methods))
    axes = distributions(results, results.episodes, "utility_mbps", "u", "F").axes
    caption = picture_in(utility_cdf.section(results), "fig3_utility_cdf").caption
    return [[str(line.get_label()) for line in ax.lines] for ax in axes], caption


def test_planners_have_a_panel_of_their_own_with_straight_flight_and_a_learner_beside_them() -> None:
    panels, text = drawn(METHODS)
    assert panels == [["Random", "Shortest-path", "QMIX", "MAPPO"], ["Shortest-path", "MAPPO", "Welfare", "Bound"]]
    assert "seeds. (b): planners, with Shortest-path and MAPPO once more." in text
    assert "The paper" not in text  # none of them has a row there
    assert list(planners(METHODS)) == ["welfare", "bound"]
    without = {key: method for key, method in METHODS.items() if key != "mappo"}
    assert list(references(without)) == ["shortest-path", "qmix"]  # the first learner there is


@pytest.mark.parametrize("keys", [("random", "mappo"), ("welfare", "bound")])
def test_methods_of_one_kind_share_one_panel(keys: tuple[str, str]) -> None:
    panels, text = drawn({key: METHODS[key] for key in keys})
    assert panels == [[METHODS[key].label for key in keys]]
    assert "(b)" not in text


def test_a_curve_is_the_share_of_the_uavs_up_to_a_value() -> None:
    # Four UAVs, two of them with 0 and one each with 3 and 8: shares 1/2, 3/4, 1.
    results = results_of(
        recipe_with({"random": player("random")}),
        flown("random", 0, utility_mbps=[0.0, 8.0]),
        flown("random", 1, utility_mbps=[3.0, 0.0]),
    )
    x, share = curve(results)
    assert [share[np.searchsorted(x, value)] for value in (0.0, 2.9, 3.1, 7.9, 8.1)] == [0.5, 0.5, 0.75, 0.75, 1.0]
    x, share = curve(results, end=4.0)
    assert (x[-1], share[-1]) == (4.0, 0.75)


def curve(results: Results, end: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    (ax,) = distributions(results, results.episodes, "utility_mbps", "u", "F", end).axes
    (line,) = ax.lines
    x, share = line.get_data()
    return np.asarray(x), np.asarray(share)
