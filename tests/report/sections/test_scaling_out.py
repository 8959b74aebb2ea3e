"""Scaling out: means over seeds by number of UAVs, and where actors were trained."""

import numpy as np
import pandas as pd

from lawn_sb3.report.sections.scaling_out import section
from lawn_sb3.results.results import Results
from tests.handmade import learner, recipe_with
from tests.report.reading import picture_in, points_of, rows_by, table_in


def rows_of(method: str, seed: int, utility_mbps: list[float], num_uavs: tuple[int, ...] = (1, 4)) -> pd.DataFrame:
    rows = pd.DataFrame({"method": method, "seed": seed, "num_uavs": num_uavs, "episodes": 7})
    dull = {"reward": 0.0, "rate_mbps": 1.0, "makespan_slots": 4.0, "completion_slots": 3.0, "success_percent": 50.0}
    rows = rows.assign(**dull, utility_mbps=utility_mbps, collisions=[0.0, 0.5])
    return rows.assign(welfare_mbps=rows["utility_mbps"] * rows["num_uavs"])


HANDMADE = recipe_with({"mappo": learner("MAPPO"), "blind": learner("Blind").model_copy(update={"baseline": "mappo"})})
ROWS = pd.concat(
    [
        rows_of("mappo", 0, [40.0, 10.0]),
        rows_of("mappo", 1, [50.0, 20.0]),
        rows_of("blind", 0, [30.0, 5.0]),
        rows_of("blind", 1, [30.0, 5.0]),
    ],
    ignore_index=True,
)


def results_with(rows: pd.DataFrame) -> Results:
    return Results(HANDMADE, scaling=rows)


def test_the_table_by_hand() -> None:
    # Seeds with 40 and 50: mean 45, resampled between 40 and 50.
    table = table_in(section(results_with(ROWS)), "scaling")
    shown = rows_by(table.shown, "Quantity", "Method")
    mappo = {"N = 1": "45.00 [40.00, 50.00]", "N = 4": "15.00 [10.00, 20.00]", "n": "2 × 7"}
    assert shown["U (Mbps)", "MAPPO"] == mappo
    assert shown["U (Mbps)", "MAPPO: Blind"]["N = 1"] == "30.00 [30.00, 30.00]"  # an ablation says of what
    of_four = rows_by(table.numbers, "key", "num_uavs")["mappo", 4]
    assert of_four["welfare_mbps"] == 60.0  # 4 * (10 + 20) / 2
    assert of_four["makespan_slots"] == 4.0


def test_the_order_of_runs_does_not_matter() -> None:
    orders = (ROWS, ROWS[::-1].reset_index(drop=True))
    forward, backward = (table_in(section(results_with(rows)), "scaling") for rows in orders)
    pd.testing.assert_frame_equal(forward.numbers, backward.numbers)


def test_the_figure_shows_the_means_and_where_actors_were_trained() -> None:
    figure = picture_in(section(results_with(ROWS)), "scaling_out").figure
    assert len(figure.axes) == 3
    utility = figure.axes[0]
    mappo, blind, trained = utility.lines
    assert points_of(mappo) == [[1.0, 45.0], [4.0, 15.0]]
    assert points_of(blind) == [[1.0, 30.0], [4.0, 5.0]]
    assert set(np.asarray(trained.get_xdata())) == {HANDMADE.game().num_uavs} == {4}
    assert [text.get_text() for text in utility.get_xticklabels()] == ["1", "4"]
    assert (mappo.get_color(), mappo.get_marker()) != (blind.get_color(), blind.get_marker())


def test_costs_and_sizes_that_were_not_flown_are_shown() -> None:
    short = ROWS[(ROWS["method"] == "mappo") | (ROWS["num_uavs"] == 1)]
    costs = short[["method", "seed", "num_uavs"]].assign(decision_ms=0.25, memory_mb=512.0)
    made = section(Results(HANDMADE, scaling=short, costs=costs))
    shown = rows_by(table_in(made, "scaling").shown, "Quantity", "Method")
    assert shown["Time of a decision (ms)", "MAPPO"]["N = 4"] == "0.250 [0.250, 0.250]"
    assert shown["Memory (MB)", "MAPPO: Blind"] == {"N = 1": "512 [512, 512]", "N = 4": "–", "n": "2 × 7"}
    assert rows_by(table_in(made, "scaling").numbers, "key", "num_uavs")["mappo", 1]["decision_ms"] == 0.25
    figure = picture_in(made, "scaling_out").figure
    assert [ax.get_ylabel() for ax in figure.axes[3:]] == ["time of a decision (ms)", "peak memory (MB)"]
    assert points_of(figure.axes[3].lines[0]) == [[1.0, 0.25], [4.0, 0.25]]
    assert points_of(figure.axes[0].lines[1]) == [[1.0, 30.0]]
