"""Fairness against welfare: where the points lie, and what is left out of sight."""

import pytest

from lawn_sb3.report.section import Picture
from lawn_sb3.report.sections.low_utilities import FRONTIER, frontier, section
from lawn_sb3.results.results import Results
from tests.handmade import flown, player, recipe_with, results_of
from tests.report.reading import picture_in

METHODS = ("random", "shortest-path", "forecast", "welfare")


@pytest.fixture
def results() -> Results:
    """One mission of two UAVs: Jain indices 1/2, 0.8, 0.9 and 1; random has far less than the others."""
    utilities = {"random": [2.0, 0.0], "shortest-path": [10.0, 30.0], "forecast": [30.0, 15.0], "welfare": [25.0, 25.0]}
    recipe = recipe_with({key: player(key) for key in METHODS}, evaluation={"episodes": 1})
    return results_of(recipe, *(flown(key, 0, 2, utility_mbps=values) for key, values in utilities.items()))


def picture_of(results: Results) -> Picture:
    """The only part of the section."""
    return picture_in(section(results), "fairness_tradeoff")


def points(results: Results, panel: int) -> dict[str, tuple[float, float]]:
    """Label and place of the points of a panel."""
    ax = picture_of(results).figure.axes[panel]
    labelled = [line for line in ax.lines if not str(line.get_label()).startswith("_") and line.get_label() != FRONTIER]
    return {str(line.get_label()): (float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in labelled}  # type: ignore[index, arg-type]


def test_points_are_mean_utility_and_fairness_by_hand(results: Results) -> None:
    # Shortest path: 40^2 / (2 * 1000) = 0.8. Forecast: 45^2 / (2 * 1125) = 0.9.
    jain, worst = points(results, 0), points(results, 1)
    assert jain["Shortest-path"] == pytest.approx((20.0, 0.8))
    assert jain["Forecast"] == pytest.approx((22.5, 0.9))
    assert jain["Welfare"] == pytest.approx((25.0, 1.0))
    assert {label: y for label, (_, y) in worst.items()} == {"Shortest-path": 10.0, "Forecast": 15.0, "Welfare": 25.0}


def test_the_frontier_picks_mission_by_mission(results: Results) -> None:
    ends = frontier(results)[[0, -1]]
    assert ends.tolist() == [[25.0, 25.0], [25.0, 25.0]]  # welfare is best in both
    fairer = results_of(
        results.recipe,
        *(
            flown(key, 0, 2, utility_mbps=values)
            for key, values in {"welfare": [10.0, 60.0], "forecast": [20.0, 30.0]}.items()
        ),
    )
    # Means 35 and 25, worst 10 and 20: welfare up to equal weights, 0.5 * 35 + 0.5 * 10 = 0.5 * 25 + 0.5 * 20, then
    # the forecast.
    points = frontier(fairer)
    assert points[0].tolist() == [35.0, 10.0]
    assert points[-1].tolist() == [25.0, 20.0]
    assert (points[:20] == points[0]).all()
    assert (points[21:] == points[-1]).all()


def test_a_method_far_below_all_others_is_named_instead_of_drawn(results: Results) -> None:
    assert list(points(results, 0)) == ["Shortest-path", "Forecast", "Welfare"]
    assert "not drawn: Random (mean U 1.0 Mbps, Jain index 0.50, worst UAV 0.0 Mbps)." in picture_of(results).caption


def test_methods_that_do_not_plan_are_drawn_again_at_their_own_scale_if_there_are_several(results: Results) -> None:
    assert len(picture_of(results).figure.axes) == 2  # straight flight alone needs no scale
    closer = results_of(results.recipe, results.episodes, flown("random", 1, 2, utility_mbps=[24.0, 20.0]))
    closer.episodes = closer.episodes.query("not (method == 'random' and seed == 0)")
    assert len(picture_of(closer).figure.axes) == 4
    assert list(points(closer, 2)) == ["Random", "Shortest-path"]
    assert "Bottom: the same without the planners." in picture_of(closer).caption
    assert "Bottom" not in picture_of(results).caption
