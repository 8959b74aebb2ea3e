"""The look of all figures: a method keeps its colour, and small multiples share their axes."""

from collections.abc import Collection

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from seaborn.algorithms import bootstrap

from lawn_sb3.report.space import UAV_COLOURS
from lawn_sb3.report.style import (
    COLOURS,
    KNOWN,
    LADDER,
    LINES,
    band,
    colours,
    grid_shape,
    line_of,
    markers,
    panels,
    title_of,
)


@given(st.sets(st.sampled_from(sorted(KNOWN))), st.permutations(sorted(KNOWN)))
def test_a_known_method_keeps_its_colour_whatever_is_beside_it(some: set[str], everyone: list[str]) -> None:
    assert colours(some).items() <= colours(everyone).items()


@pytest.mark.parametrize(
    "known", [KNOWN, [*LADDER, "shortest-path", "forecast", "worst-equilibrium", "welfare", "bound"]]
)
def test_all_methods_of_a_large_recipe_and_of_the_ladder_differ_in_colour(known: Collection[str]) -> None:
    assert len(set(colours([*known, "mine"]).values())) == len(known) + 1


def test_planners_are_told_apart_by_line_and_marker_too() -> None:
    assert {line_of(key) for key in COLOURS if key not in LINES} == {"-"}
    assert len({*LINES.values(), "-"}) == len(LINES) + 1
    looks = markers(KNOWN)
    assert len(set(looks.values())) == len(KNOWN)
    assert markers([*KNOWN, "mine"]).items() >= looks.items()
    some = markers(["mine", "welfare", "shortest-path"])  # a recipe with other methods
    assert {key: some[key] for key in ("welfare", "shortest-path")}.items() <= looks.items()
    assert some["mine"] not in (some["welfare"], some["shortest-path"])


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=9))
def test_the_band_of_a_mean_is_seaborn_s(values: list[float]) -> None:
    means = bootstrap(values, n_boot=1_000, func="mean", seed=0)
    assert band(values) == tuple(np.percentile(means, [2.5, 97.5]))


def test_no_uav_has_the_colour_of_a_method() -> None:
    # Euclidean distance in RGB, from 0 to sqrt(3); the two blues of MAPPO are 0.43 apart.
    methods = {*colours([*KNOWN, "mine"]).values(), *colours(LADDER).values()}
    for uav in UAV_COLOURS:
        for method in methods:
            apart = sum((a - b) ** 2 for a, b in zip(to_rgb(uav), to_rgb(method), strict=True)) ** 0.5
            assert apart > 0.25, (uav, method)


@pytest.mark.parametrize(
    ("count", "shape"),
    [
        (1, (1, 1)), (2, (1, 2)), (4, (1, 4)), (5, (2, 3)), (6, (2, 3)), (7, (2, 4)), (9, (3, 3)), (12, (3, 4)),
        (13, (3, 5)),
    ],
)  # fmt: skip
def test_panels_are_laid_out_in_even_rows(count: int, shape: tuple[int, int]) -> None:
    figure = Figure()
    axes = panels(figure, count, 2.0, 2.0, "slot", "UAVs")
    assert grid_shape(count) == shape
    assert len(axes) == len(figure.axes) == count
    grid = axes[0].get_gridspec()
    assert grid is not None
    assert (grid.nrows, grid.ncols) == shape
    axes[0].set(xlim=(0, 7), ylim=(0, 3))
    assert all(ax.get_xlim() == (0, 7) and ax.get_ylim() == (0, 3) for ax in axes)


def test_only_outer_panels_are_labelled_and_every_column_has_its_numbers() -> None:
    # Three columns: the last row has two panels, so the third panel is the lowest of its column.
    axes = panels(Figure(), 5, 2.0, 2.0, "slot", "UAVs")
    assert [ax.get_xlabel() for ax in axes] == ["", "", "slot", "slot", "slot"]
    assert [ax.get_ylabel() for ax in axes] == ["UAVs", "", "", "UAVs", ""]
    assert [ax.xaxis.get_tick_params()["labelbottom"] for ax in axes] == [False, False, True, True, True]


def test_a_panel_is_headed_by_a_mark_in_the_methods_colour() -> None:
    (ax,) = panels(Figure(), 1, 2.0, 2.0, "", "")
    title_of(ax, "QMIX", "#009E73")
    legend = ax.get_legend()
    assert legend is not None
    assert legend.get_texts()[0].get_text() == "QMIX"
    assert legend.get_patches()[0].get_facecolor()[:3] == to_rgb("#009E73")


def test_methods_beside_known_ones_have_no_known_colour() -> None:
    flown = colours(["random", "shortest-path", "qmix", "mappo", "mappo-blind", "one", "two", "three"])
    assert not {flown[key] for key in ("one", "two", "three")} & {*COLOURS.values()}
    assert len(set(flown.values())) == len(flown)
