"""One episode as every method flies it: chosen from the data alone, and drawn where the UAVs were."""

from typing import Any

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes

from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.evaluation import evaluation_missions
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.game.radio import radio_map
from lawn_sb3.report.section import Picture
from lawn_sb3.report.sections.trajectories import (
    FIRST_SLOTS,
    UAV_COLOURS,
    cell_borders,
    dot_sizes,
    heading,
    longest_episode,
    offsets,
    section,
    uav_look,
)
from lawn_sb3.results.results import Results, read_results
from lawn_sb3.scenario import PRESETS, Scenario
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


def test_the_traced_episode_with_the_most_to_fly_is_chosen() -> None:
    # T_min 2, 6 and 9, but the last episode left no path; of the seeds only 1 has paths of both methods.
    recipe = recipe_of(1, ("a", "b"), seeds=2, episodes=3)
    rows = [flown(method, seed, 1, min_slots=[2, 6, 9]) for method in ("a", "b") for seed in (0, 1)]
    traced = [("a", 0), ("a", 1), ("b", 1)]
    paths = pd.concat([still(method, seed, episode, 1) for method, seed in traced for episode in (0, 1)])
    episode = longest_episode(results_of(recipe, *rows, paths=paths))
    assert (episode.seed, episode.number) == (1, 1)
    assert [flight.method for flight in episode.flights] == ["a", "b"]
    assert episode.destinations.shape == (1, 3)


def test_the_choice_does_not_depend_on_the_order_of_rows(small: Results) -> None:
    chosen = longest_episode(small)
    shuffled = results_of(small.recipe, small.episodes[::-1], paths=small.paths[::-1])
    again = longest_episode(shuffled)
    assert (again.seed, again.number) == (chosen.seed, chosen.number)
    for flight, other in zip(chosen.flights, again.flights, strict=True):
        assert flight.method == other.method
        assert all((path == same).all() for path, same in zip(flight.paths, other.paths, strict=True))


def test_paths_lead_from_the_origins_and_arrived_uavs_end_at_their_destination(small: Results) -> None:
    episode = longest_episode(small)
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


def test_the_papers_cells_are_quarters_of_the_area() -> None:
    # Four GBSs at the quarter points: borders along x = 50 m and y = 50 m, 10 voxels each.
    borders = cell_borders(PAPER)
    assert borders.shape == (20, 2, 2)
    upright = borders[borders[:, 0, 0] == borders[:, 1, 0]]
    level = borders[borders[:, 0, 1] == borders[:, 1, 1]]
    assert (upright[..., 0] == 50.0).all()
    assert (level[..., 1] == 50.0).all()
    assert sorted(upright[:, 0, 1]) == sorted(level[:, 0, 0]) == [10.0 * k for k in range(10)]


def test_a_border_lies_wherever_neighbours_are_served_by_different_gbss() -> None:
    game = Scenario(gbs_positions_m=((11.0, 42.0, 0.0), (63.0, 77.0, 0.0), (88.0, 9.0, 0.0)))
    cell = radio_map(game).cell[:, :, 0]
    assert len(cell_borders(game)) == (cell[1:] != cell[:-1]).sum() + (cell[:, 1:] != cell[:, :-1]).sum()
    assert cell_borders(game.changed(gbs_positions_m=((11.0, 42.0, 0.0),))).shape == (0, 2, 2)


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
    episode, aside = longest_episode(small), offsets(small.recipe.game())
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
    long, short = longest_episode(results).flights
    assert heading(results, long) == "M1\n20 of 100 slots, U 1.2 Mbps"
    assert heading(results, short) == "M2\n20 slots, U 0.0 Mbps"
    for ax in from_above(results).figure.axes:
        (track,) = [line for line in ax.lines if line.get_color() == UAV_COLOURS[0] and line.get_marker() == "None"]
        assert len(points_of(track)) == FIRST_SLOTS + 1
    assert "the first 20 slots" in from_above(results).caption


def test_fifteen_uavs_look_different() -> None:
    assert len({uav_look(i) for i in range(15)}) == 15


def test_the_view_in_space_shows_the_same_paths(small: Results) -> None:
    episode, aside = longest_episode(small), offsets(small.recipe.game())
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
