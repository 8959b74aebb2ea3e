"""Who got the low utilities, by load and by delay; and how fair an episode is to its UAVs."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.report.bins import co_served_bounds, most_shown
from lawn_sb3.report.section import Picture
from lawn_sb3.report.sections.low_utilities import CAUSES, FRONTIER, Cause, binned, fairness, frontier, section
from lawn_sb3.report.table import Table
from lawn_sb3.results.results import Results, read_results
from tests.handmade import flown, player, recipe_of, recipe_with, results_of
from tests.report.reading import interval_in, numbers_of, picture_in, points_of, table_in


@pytest.fixture
def results() -> Results:
    """Two seeds of one episode of four UAVs, of which the last one fails in seed 0."""
    recipe = recipe_of(4, ("a",), seeds=2)
    first = flown(
        "a", 0, 4,
        mean_cell_load=[1.0, 1.5, 2.0, 4.0],
        slots=[4, 6, 7, 100],
        min_slots=[4, 4, 4, 4],
        arrived=[True, True, True, False],
        utility_mbps=[50.0, 30.0, 20.0, 0.0],
    )  # fmt: skip
    second = flown(
        "a", 1, 4,
        mean_cell_load=[1.0, 1.0, 2.000000001, 3.5],
        slots=[4, 4, 8, 9],
        min_slots=[4, 4, 4, 4],
        utility_mbps=[48.0, 52.0, 26.0, 4.0],
    )  # fmt: skip
    return results_of(recipe, first, second)


def low_utility_table(results: Results, cause: Cause) -> Table:
    return table_in(section(results), "low_utility_by_load" if cause == "co_served" else "low_utility_by_delay")


def figure_of(results: Results) -> Figure:
    return picture_in(section(results), "low_utilities").figure


def test_missions_are_sorted_by_the_others_in_their_cell(results: Results) -> None:
    # Other UAVs: 0, 0.5, 1, 3 and 0, 0, 1 (but for rounding), 2.5.
    bins, names = binned(results, "co_served")
    assert names == ["0", "(0, 1]", "(1, 2]", "(2, 3]"]
    assert bins.tolist() == [0, 1, 1, 3, 0, 0, 1, 3]


def test_missions_are_sorted_by_their_detour_and_failures_apart(results: Results) -> None:
    # T / T_min: 1, 1.5, 1.75, failed and 1, 1, 2, 2.25.
    bins, names = binned(results, "detour")
    assert names == ["1", "(1, 1.5]", "(1.5, 2]", "> 2", "failed"]
    assert bins.tolist() == [0, 1, 2, 4, 0, 0, 2, 3]


def test_means_are_over_seeds_and_every_mission_is_counted_once(results: Results) -> None:
    # Nobody else in the cell: 50 in seed 0, (48 + 52) / 2 = 50 in seed 1, three missions.
    # Up to one other: (30 + 20) / 2 = 25 and 26, so 25.5, resampled between 25 and 26.
    table = low_utility_table(results, "co_served")
    numbers = table.numbers.set_index("co_served")
    assert numbers["missions"].to_dict() == {"0": 3, "(0, 1]": 3, "(2, 3]": 2}
    assert numbers["utility_mbps"].to_dict() == {"0": 50.0, "(0, 1]": 25.5, "(2, 3]": 2.0}
    assert table.shown.loc[0, "(0, 1] others"] == "25.5 [25.0, 26.0], n = 3"
    assert table.shown.loc[0, "(1, 2] others"] == ""


def test_a_bin_that_only_one_seed_has_gets_no_interval(results: Results) -> None:
    table = low_utility_table(results, "detour")
    assert table.shown.loc[0, "failed"] == "0.0, n = 1"
    assert table.shown.loc[0, "T/T_min (1.5, 2]"] == "23.0 [20.0, 26.0], n = 2"


@given(st.integers(1, 200))
def test_bins_follow_the_number_of_uavs(num_uavs: int) -> None:
    bounds = co_served_bounds(num_uavs)
    steps = np.diff(bounds)
    assert bounds[0] == 0.0
    assert bounds[-1] >= num_uavs - 1  # as many others as there are
    assert len(bounds) <= 8
    assert not len(steps) or (steps[0] >= 1 and (steps == steps[0]).all())
    assert not len(bounds) > 1 or bounds[-2] < num_uavs - 1  # no bin that nobody can be in


def test_four_and_eight_uavs_have_a_bin_for_each_other_uav() -> None:
    assert co_served_bounds(4) == (0, 1, 2, 3)
    assert co_served_bounds(8) == tuple(range(8))
    assert co_served_bounds(1) == (0,)


def test_the_figure_shows_the_tables_means_and_intervals(results: Results) -> None:
    figure = figure_of(results)
    for ax, cause in zip(figure.axes, CAUSES, strict=True):
        numbers = low_utility_table(results, cause).numbers
        points = sorted(point for line in ax.lines if line.get_marker() == "o" for point in points_of(line))
        names = [label.get_text() for label in ax.get_xticklabels()]
        expected = [
            (names.index(name), value) for name, value in zip(numbers[cause], numbers["utility_mbps"], strict=True)
        ]
        assert points == [list(point) for point in expected]
        assert ax.get_ylabel() == ("mean utility $U_i$ (Mbps)" if cause == "co_served" else "")
        bars: Any = ax.collections[0]
        ends = [segment[:, 1].tolist() for segment in bars.get_segments() if len(segment)]
        known = numbers.dropna()
        assert ends == known[["utility_mbps_low", "utility_mbps_high"]].to_numpy().tolist()


def test_points_without_an_interval_are_hollow(results: Results) -> None:
    faces = {
        (x, line.get_markerfacecolor() == "white")
        for line in figure_of(results).axes[1].lines
        for x, _ in points_of(line)
        if line.get_marker() == "o"
    }
    assert faces == {(0, False), (1, True), (2, False), (3, True), (4, True)}  # detours of 1.5, above 2, and failed
    (legend,) = figure_of(results).legends
    signs: Any = dict(zip([text.get_text() for text in legend.get_texts()], legend.legend_handles, strict=True))
    assert signs.pop("hollow: of one seed alone").get_markerfacecolor() == "white"
    assert not [sign for sign in signs.values() if sign.get_markerfacecolor() == "white"]


@pytest.mark.parametrize("cause", CAUSES)
def test_every_mission_of_real_runs_is_in_a_bin(recipe: Recipe, small_cells: list[Cell], cause: Cause) -> None:
    results = read_results(recipe, small_cells)
    table = low_utility_table(results, cause)
    numbers = table.numbers
    assert numbers.groupby("key")["missions"].sum().to_dict() == {"random": 48, "mappo": 48}  # 2 seeds x 6 x 4
    assert "6 test episodes of each of 2 seeds" in table.caption


def test_two_methods_of_one_name_stay_apart(results: Results) -> None:
    twins = results.recipe.model_copy(update={"methods": dict.fromkeys(("a", "b"), results.recipe.methods["a"])})
    both = results_of(twins, results.episodes, results.episodes.assign(method="b", utility_mbps=1.0))
    assert low_utility_table(both, "detour").shown["T/T_min 1"].tolist() == [
        "50.0 [50.0, 50.0], n = 3",
        "1.0 [1.0, 1.0], n = 3",
    ]


def test_panels_of_many_methods_stand_below_each_other_so_that_points_stay_apart() -> None:
    for count, rows in ((8, 1), (9, 2)):
        keys = tuple(f"m{k}" for k in range(count))
        made = results_of(recipe_of(1, keys), *(flown(key, 0, utility_mbps=[10.0]) for key in keys))
        figure = figure_of(made)
        assert figure.axes[0].get_gridspec().nrows == rows  # type: ignore[union-attr]
        assert len({ax.get_ylabel() for ax in figure.axes}) == 3 - rows  # a panel of its own has an axis of its own


def test_indices_are_means_over_episodes_by_hand() -> None:
    # Episode 0: utilities 10, 30: Jain 40^2 / (2 * 1000) = 0.8; Gini 2 * 20 / (2 * 2 * 40) = 0.25; the worst has 10.
    # Episode 1: 20, 20: Jain 1, Gini 0, worst 20. Episode 2: nobody arrives: Jain 1, Gini 0, worst 0.
    # Nash welfare: sqrt(10 * 30), 20, and 0.
    rows = flown("a", 0, 2, utility_mbps=[10.0, 30.0, 20.0, 20.0, 0.0, 0.0])
    numbers = fairness(results_of(recipe_of(2, ("a",), episodes=3), rows)).numbers.iloc[0]
    assert numbers["jain"] == pytest.approx((0.8 + 1 + 1) / 3)
    assert numbers["gini"] == pytest.approx(0.25 / 3)
    assert numbers["nash_welfare_mbps"] == pytest.approx((300**0.5 + 20) / 3)
    assert numbers["worst_mbps"] == pytest.approx(10.0)
    assert numbers["utility_mbps"] == pytest.approx(80 / 6)
    assert numbers["nobody_percent"] == pytest.approx(100 / 3)
    assert np.isnan(numbers["jain_low"])  # one seed tells no spread


def test_intervals_are_over_seeds() -> None:
    # Jain of seed 0 is 1, of seed 1 1/2: resampled means are 1/2, 3/4, 1 with probability 1/4, 1/2, 1/4.
    rows = [flown("a", seed, 2, utility_mbps=values) for seed, values in enumerate(([7.0, 7.0], [7.0, 0.0]))]
    table = fairness(results_of(recipe_of(2, ("a",), seeds=2), *rows))
    assert interval_in(numbers_of(table)["a"], "jain") == [0.75, 0.5, 1.0]
    assert table.shown.loc[0, "Jain index"] == "0.750 [0.500, 1.000]"
    assert table.shown.loc[0, "n"] == "2 × 1"


def test_every_method_of_real_runs_has_a_row(recipe: Recipe, small_cells: list[Cell]) -> None:
    results = read_results(recipe, small_cells)
    table = fairness(results)
    assert table.shown["Method"].tolist() == ["Random", "CTDE-MAPPO"]
    assert table.numbers["jain"].between(0.25, 1.0).all()  # from 1/N to 1
    assert table.numbers["utility_mbps"].tolist() == pytest.approx(
        [results.scores(key, "utility_mbps").mean() for key in results.methods]
    )
    assert "its 4 UAVs" in table.caption


METHODS = ("random", "shortest-path", "forecast", "welfare")


@pytest.fixture
def four() -> Results:
    """One mission of two UAVs: Jain indices 1/2, 0.8, 0.9 and 1; random has far less than the others."""
    utilities = {"random": [2.0, 0.0], "shortest-path": [10.0, 30.0], "forecast": [30.0, 15.0], "welfare": [25.0, 25.0]}
    recipe = recipe_with({key: player(key) for key in METHODS}, evaluation={"episodes": 1})
    return results_of(recipe, *(flown(key, 0, 2, utility_mbps=values) for key, values in utilities.items()))


def picture_of(results: Results) -> Picture:
    return picture_in(section(results), "fairness_tradeoff")


def points(results: Results, panel: int) -> dict[str, tuple[float, float]]:
    """Label and place of the points of a panel."""
    ax = picture_of(results).figure.axes[panel]
    labelled = [line for line in ax.lines if not str(line.get_label()).startswith("_") and line.get_label() != FRONTIER]
    return {str(line.get_label()): (float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in labelled}  # type: ignore[index, arg-type]


def test_points_are_mean_utility_and_fairness_by_hand(four: Results) -> None:
    # Shortest path: 40^2 / (2 * 1000) = 0.8. Forecast: 45^2 / (2 * 1125) = 0.9.
    jain, worst = points(four, 0), points(four, 1)
    assert jain["Shortest-path"] == pytest.approx((20.0, 0.8))
    assert jain["Forecast"] == pytest.approx((22.5, 0.9))
    assert jain["Welfare"] == pytest.approx((25.0, 1.0))
    assert {label: y for label, (_, y) in worst.items()} == {"Shortest-path": 10.0, "Forecast": 15.0, "Welfare": 25.0}


def test_the_frontier_picks_mission_by_mission(four: Results) -> None:
    ends = frontier(four)[[0, -1]]
    assert ends.tolist() == [[25.0, 25.0], [25.0, 25.0]]  # welfare is best in both
    fairer = results_of(
        four.recipe,
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


def test_a_method_far_below_all_others_is_named_instead_of_drawn(four: Results) -> None:
    assert list(points(four, 0)) == ["Shortest-path", "Forecast", "Welfare"]
    assert "not drawn: Random (mean U 1.0 Mbps, Jain index 0.50, worst UAV 0.0 Mbps)." in picture_of(four).caption


def test_methods_that_do_not_plan_are_drawn_again_at_their_own_scale_if_there_are_several(four: Results) -> None:
    assert len(picture_of(four).figure.axes) == 2  # straight flight alone needs no scale
    closer = results_of(four.recipe, four.episodes, flown("random", 1, 2, utility_mbps=[24.0, 20.0]))
    closer.episodes = closer.episodes.query("not (method == 'random' and seed == 0)")
    assert len(picture_of(closer).figure.axes) == 4
    assert list(points(closer, 2)) == ["Random", "Shortest-path"]
    assert "(c, d): the same closer, without all planners but straight flight." in picture_of(closer).caption
    assert "(c, d)" not in picture_of(four).caption


def test_in_swarms_bins_end_where_loads_do() -> None:
    assert [most_shown(num_uavs, 3.2) for num_uavs in (4, 8, 64)] == [4, 8, 4]
    assert most_shown(64, 100.0) == 64
