"""One episode as every method flies it: chosen from the data alone, and drawn where the UAVs were."""

from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluation_missions
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.report.section import Picture
from lawn_sb3.report.sections.trajectories import (
    FIRST_SLOTS,
    dot_sizes,
    heading,
    section,
    typical_episode,
)
from lawn_sb3.report.space import UAV_COLOURS, offsets, uav_look
from lawn_sb3.results.results import Results, read_results
from lawn_sb3.scenario import PRESETS
from tests.handmade import flown, recipe_of, results_of
from tests.report.reading import picture_in, points_of

PAPER = PRESETS["paper"]


@pytest.fixture
def small(recipe: Recipe, small_cells: list[Cell]) -> Results:
    """What the small runs left: 4 of 6 episodes are traced."""
    return read_results(recipe, small_cells)


def from_above(results: Results) -> Picture:
    return picture_in(section(results), "trajectories")


def still(method: str, seed: int, episode: int, slots: int) -> pd.DataFrame:
    columns = {"method": method, "seed": seed, "episode": episode, "uav": 0, "slot": range(slots + 1)}
    return pd.DataFrame({**columns, "x": 2, "y": 3, "z": 1, "cell": 0, "cell_load": 1, "rate_mbps": 1.0})


def choice(*by_seed: tuple[list[float], list[float]]) -> tuple[int, int]:
    """Seed and number of the episode that is shown, by the utilities of a and b in the episodes of each seed."""
    recipe = recipe_of(1, ("a", "b"), seeds=len(by_seed), episodes=3)
    rows, paths = [], []
    for seed, utilities in enumerate(by_seed):
        for method, own in zip(("a", "b"), utilities, strict=True):
            rows.append(flown(method, seed, 1, utility_mbps=own))
            paths += [still(method, seed, episode, 1) for episode in (0, 1)]  # the last left no path
    episode = typical_episode(results_of(recipe, *rows, paths=pd.concat(paths)))
    assert [flight.method for flight in episode.flights] == ["a", "b"]
    assert episode.destinations.shape == (1, 3)
    return episode.seed, episode.number


def test_the_traced_episode_nearest_to_the_mean_utilities_is_chosen() -> None:
    assert choice(([10.0, 13.0, 13.0], [20.0, 22.0, 24.0])) == (0, 1)  # means 12 and 22
    assert choice(([10.0, 19.0, 13.0], [20.0, 22.0, 24.0]), ([8.0, 14.0, 14.0], [20.0, 22.0, 24.0])) == (1, 1)


def test_an_episode_whose_order_contradicts_the_means_is_not_chosen() -> None:
    # Means 21 and 22: the second episode is nearest, but there a is above b.
    assert choice(([10.0, 22.5, 30.5], [14.0, 21.5, 30.5])) == (0, 0)
    # Means 21.8 and 22: less than 0.5 apart, so that no order can be contradicted.
    assert choice(([10.0, 22.5, 32.9], [14.0, 21.5, 30.5])) == (0, 1)


def test_of_the_seeds_those_count_that_most_methods_have_paths_of() -> None:
    recipe = recipe_of(1, ("a", "b"), seeds=2, episodes=3)
    rows = [flown(method, seed, 1, utility_mbps=[1.0] * 3) for method in ("a", "b") for seed in (0, 1)]
    traced = [("a", 0), ("a", 1), ("b", 1)]
    paths = pd.concat([still(method, seed, episode, 1) for method, seed in traced for episode in (0, 1)])
    assert typical_episode(results_of(recipe, *rows, paths=paths)).seed == 1


def test_the_choice_does_not_depend_on_the_order_of_rows(small: Results) -> None:
    chosen = typical_episode(small)
    shuffled = results_of(small.recipe, small.episodes[::-1], paths=small.paths[::-1])
    again = typical_episode(shuffled)
    assert (again.seed, again.number) == (chosen.seed, chosen.number)
    for flight, other in zip(chosen.flights, again.flights, strict=True):
        assert flight.method == other.method
        assert all((path == same).all() for path, same in zip(flight.paths, other.paths, strict=True))


def test_paths_lead_from_the_origins_and_arrived_uavs_end_at_their_destination(small: Results) -> None:
    episode = typical_episode(small)
    missions = evaluation_missions(small.recipe.game(), small.recipe.evaluation.episodes, small.recipe.evaluation.seed)
    for flight in episode.flights:
        for i, path in enumerate(flight.paths):
            assert path[0] == pytest.approx(PAPER.voxel_centre(missions.origins[episode.number, i]))
            assert len(path) == flight.rows["slots"].iloc[i] + 1
    assert episode.destinations == pytest.approx(PAPER.voxel_centre(missions.destinations[episode.number]))
    arrived = small.episodes[small.episodes["arrived"]].merge(small.paths, on=["method", "seed", "episode", "uav"])
    last = arrived[arrived["slot"] == arrived["slots"]]
    assert len(last) > 0
    ends = missions.destinations[last["episode"].to_numpy(), last["uav"].to_numpy()]
    assert (last[list("xyz")].to_numpy() == ends).all()


def test_without_paths_there_is_nothing_to_show(small: Results) -> None:
    bare = results_of(small.recipe, small.episodes)
    assert section(bare) is None


@pytest.mark.parametrize("num_uavs", [1, 2, 4, 6])
def test_paths_through_the_same_voxels_are_drawn_apart(num_uavs: int) -> None:
    aside = offsets(PAPER.changed(num_uavs=num_uavs))
    assert (np.abs(aside) < PAPER.voxel_size_m / 2).all()  # nobody is moved into the next voxel
    for along in range(2):  # also when both fly along the same side of the area
        gaps = np.diff(np.sort(aside[:, along]))
        assert (gaps > 0.2).all()  # metres


def test_higher_layers_have_larger_dots() -> None:
    sizes = dot_sizes(PAPER, np.array([5.0, 15.0, 25.0]))
    assert sizes[0] > 0
    assert (np.diff(sizes) > 3).all()


def lines_of(ax: Axes, marker: str) -> list[np.ndarray]:
    return [np.asarray(line.get_xydata()) for line in ax.lines if line.get_marker() == marker]


def test_the_view_from_above_shows_paths_origins_and_destinations(small: Results) -> None:
    episode, aside = typical_episode(small), offsets(small.recipe.game())
    figure = from_above(small).figure
    for ax, flight in zip(figure.axes, episode.flights, strict=True):
        origins, stars = lines_of(ax, "o"), lines_of(ax, "*")
        tracks = [line for line in ax.lines if line.get_marker() == "None" and line.get_color() in UAV_COLOURS]
        for i, path in enumerate(flight.paths):
            assert np.asarray(tracks[i].get_xydata()) == pytest.approx(path[: FIRST_SLOTS + 1, :2] + aside[i])
            assert tracks[i].get_color() == UAV_COLOURS[i]
            assert origins[i] == pytest.approx(path[:1, :2] + aside[i])
            assert stars[i] == pytest.approx((episode.destinations[i, :2] + aside[i])[None])
        assert lines_of(ax, "^")[0] == pytest.approx(PAPER.gbs_positions[:, :2])
        assert (ax.get_xlim(), ax.get_ylim()) == ((0, 100), (0, 100))
    assert figure.axes[0].get_xlabel() == "x (m)"


def test_of_long_paths_the_first_slots_are_drawn_and_said_so() -> None:
    recipe = recipe_of(1, ("a", "b"))
    rows = [
        flown("a", 0, 1, slots=[100], makespan_slots=[100], utility_mbps=[1.25]),
        flown("b", 0, 1, slots=[FIRST_SLOTS], makespan_slots=[FIRST_SLOTS]),
    ]
    paths = pd.concat([still("a", 0, 0, 100), still("b", 0, 0, FIRST_SLOTS)])
    results = results_of(recipe, *rows, paths=paths)
    long, short = typical_episode(results).flights
    assert heading(results, long) == "M1\n20 of 100 slots, U 1.2 (1.2) Mbps"
    assert heading(results, short) == "M2\n20 slots, U 0.0 (0.0) Mbps"
    for ax in from_above(results).figure.axes:
        (track,) = [line for line in ax.lines if line.get_color() == UAV_COLOURS[0] and line.get_marker() == "None"]
        assert len(points_of(track)) == FIRST_SLOTS + 1
    assert "the first 20 slots" in from_above(results).caption


def test_fifteen_uavs_look_different() -> None:
    assert len({uav_look(i) for i in range(15)}) == 15


def test_the_view_in_space_shows_the_same_paths(small: Results) -> None:
    episode, aside = typical_episode(small), offsets(small.recipe.game())
    figure: Any = picture_in(section(small), "trajectories_3d").figure
    for ax, flight in zip(figure.axes, episode.flights, strict=True):
        solid = [line for line in ax.lines if line.get_color() in UAV_COLOURS and line.get_linewidth() in (0.6, 1.5)]
        tracks = [np.array(line.get_data_3d()).T for line in solid if line.get_marker() == "None"]
        for i, path in enumerate(flight.paths):
            assert tracks[i] == pytest.approx(path[: FIRST_SLOTS + 1] + np.append(aside[i], 0.0))
        assert [ax.get_xlabel(), ax.get_ylabel(), ax.get_zlabel()] == ["x (m)", "y (m)", "z (m)"]
        assert ax.get_zlim() == (0, 30)


def test_an_airspace_too_fine_for_grid_lines_is_drawn_without(small: Results) -> None:
    fine = small.recipe.model_copy(update={"scenario": "as-printed"})
    results = results_of(fine, small.episodes, paths=small.paths)
    figure = from_above(results).figure
    assert not [line for line in figure.axes[0].lines if line.get_color() == "0.93"]
    assert [line for line in from_above(small).figure.axes[0].lines if line.get_color() == "0.93"]


@pytest.mark.parametrize("num_uavs", [15, 16])
def test_paths_are_drawn_as_long_as_uavs_can_be_told_apart(num_uavs: int) -> None:
    paths = pd.concat([still("a", 0, 0, 1).assign(uav=uav) for uav in range(num_uavs)])
    rows = flown("a", 0, num_uavs, slots=[1] * num_uavs)
    assert (section(results_of(recipe_of(num_uavs, ("a",)), rows, paths=paths)) is None) == (num_uavs > 15)
