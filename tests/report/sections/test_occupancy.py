"""Cell loads over time: what is drawn is the mean of what the runs saw."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.patches import StepPatch

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.report.sections.occupancy import load_groups, occupancy, section, shown_slots
from lawn_sb3.results.results import Results, read_results
from tests.handmade import flown, recipe_of, results_of
from tests.report.reading import picture_in

RECIPE = recipe_of(2, ("early", "late"), seeds=2)


def slots(method: str, seed: int, alone: list[float], together: list[float]) -> pd.DataFrame:
    count = len(alone)
    columns = {"method": method, "seed": seed, "slot": range(1, count + 1), "load_1": alone, "load_2": together}
    return pd.DataFrame(columns)


@pytest.fixture
def results() -> Results:
    early = [slots("early", 0, [1.0, 0.5], [1.0, 0.0]), slots("early", 1, [2.0], [0.0])]
    late = [slots("late", seed, [0.0] * 99 + [1.0], [2.0] * 99 + [0.0]) for seed in (0, 1)]
    rows = [flown(method, seed, 2, slots=[1, 1]) for method in ("early", "late") for seed in (0, 1)]
    return results_of(RECIPE, *rows, slots=pd.concat([*early, *late], ignore_index=True))


def panels_of(results: Results) -> dict[str, Axes]:
    titles = ((ax, ax.get_legend()) for ax in picture_in(section(results), "cell_loads").figure.axes)
    return {legend.get_texts()[0].get_text(): ax for ax, legend in titles if legend is not None}


def drawn(ax: Axes) -> np.ndarray:
    """Heights of the stacked steps [K, slots]."""
    steps: list[Any] = [patch.get_data() for patch in ax.patches if isinstance(patch, StepPatch)]
    return np.array([step.values - step.baseline for step in steps])


def test_a_seed_whose_uavs_are_done_counts_as_nobody_flying(results: Results) -> None:
    # Slot 1: (1 + 2) / 2 alone, (1 + 0) / 2 together. Slot 2: seed 1 has ended, so (0.5 + 0) / 2 and (0 + 0) / 2.
    assert occupancy(results, "early").to_numpy().tolist() == [[1.5, 0.5], [0.25, 0.0]]


def test_a_random_walk_does_not_stretch_the_axis(results: Results) -> None:
    # "late" flies to the deadline of 100 slots; "early" is done after 2, and a panel shows at least 8.
    assert shown_slots(results) == 8
    only_late = results_of(RECIPE, results.episodes, slots=results.slots[results.slots["method"] == "late"])
    assert shown_slots(only_late) == 100


def test_the_panels_show_the_means_stacked(results: Results) -> None:
    panels = panels_of(results)
    assert list(panels) == ["M1", "M2"]
    assert drawn(panels["M1"]).tolist() == [[1.5, 0.25, 0, 0, 0, 0, 0, 0], [0.5, 0, 0, 0, 0, 0, 0, 0]]
    assert drawn(panels["M2"]).tolist() == [[0.0] * 8, [2.0] * 8]
    assert all(ax.get_xlim() == (0.5, 8.5) and ax.get_ylim() == (0, 2) for ax in panels.values())


def test_a_panel_says_how_much_is_shared_and_what_lies_beyond_it(results: Results) -> None:
    # "early": 0.5 of 1.5 + 0.5 + 0.25 = 2.25 UAV-slots, 22 %. "late": all of the first 8 slots; 1 UAV in slot 100.
    notes = {label: ax.texts[0].get_text() for label, ax in panels_of(results).items()}
    assert notes == {"M1": "22 % shared", "M2": "100 % shared\n1.0 still fly in slot 100"}


def test_shades_run_from_light_to_dark(results: Results) -> None:
    for ax in panels_of(results).values():
        lightness = [sum(to_rgb(patch.get_facecolor())) for patch in ax.patches]
        assert lightness == sorted(lightness, reverse=True)
        assert len(set(lightness)) == 2


@given(st.integers(1, 100))
def test_every_load_is_in_one_group_and_alone_stays_alone(num_uavs: int) -> None:
    groups = load_groups(num_uavs)
    assert [load for group in groups for load in group] == list(range(1, num_uavs + 1))
    assert list(groups[0]) == [1]
    assert len(groups) <= 8
    assert num_uavs > 8 or len(groups) == num_uavs


def test_many_loads_are_drawn_together() -> None:
    # Ten UAVs: alone, with 1 or 2 others, with 3 or 4... With load k in slot 1 flown by k UAVs: 1, 2 + 3, 4 + 5...
    recipe = recipe_of(10, ("a",))
    loads = pd.DataFrame([{"method": "a", "seed": 0, "slot": 1, **{f"load_{k}": float(k) for k in range(1, 11)}}])
    (ax,) = panels_of(results_of(recipe, flown("a", 0, 10, slots=[1] * 10), slots=loads)).values()
    assert drawn(ax)[:, 0].tolist() == [1, 5, 9, 13, 17, 10]


def test_real_runs_are_drawn_as_their_files_say(recipe: Recipe, small_cells: list[Cell], tmp_path: Path) -> None:
    results = read_results(recipe, small_cells)
    panels = panels_of(results)
    files = [pd.read_csv(tmp_path / f"runs/small/random/seed-{seed}/slots.csv") for seed in (0, 1)]
    mean = np.mean([file["load_2"].reindex(range(100), fill_value=0.0) for file in files], axis=0)
    heights = drawn(panels["Random"])[1]
    assert heights == pytest.approx(mean[: len(heights)])
    assert "6 test episodes of each of 2 seeds" in picture_in(section(results), "cell_loads").caption


def test_in_swarms_no_group_is_above_the_loads_that_occur_and_the_legend_has_room() -> None:
    # 64 UAVs, never more than 5 in a cell: five groups of one load each, not eight of nine loads.
    recipe = recipe_of(64, ("a",))
    columns = {f"load_{k}": float(k <= 5) for k in range(1, 65)}
    results = results_of(
        recipe,
        flown("a", 0, 64, slots=[1] * 64),
        slots=pd.DataFrame([{"method": "a", "seed": 0, "slot": 1, **columns}]),
    )
    picture = picture_in(section(results), "cell_loads")
    (legend,) = picture.figure.legends
    assert [text.get_text() for text in legend.get_texts()][-1] == "5 UAVs in the cell"
    picture.figure.draw_without_rendering()
    shown = legend.get_window_extent()
    assert shown.x0 >= 0.0
    assert shown.x1 <= picture.figure.bbox.x1
