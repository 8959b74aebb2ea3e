"""Fig. 1: the system model of any scenario, and what it says of GBSs, RBs and UAVs."""

from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from lawn_sb3.game.radio import radio_map, rb_share
from lawn_sb3.report.airspace import airspace_caption, airspace_figure
from lawn_sb3.scenario import PRESETS, Scenario

MINE = Scenario(
    name="mine", num_uavs=6, gbs_positions_m=((25, 25, 0), (75, 75, 0), (52, 48, 0)), rbs_per_gbs=(10, 10, 20)
)


def texts(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.axes[0].texts]


def marks(figure: Figure, marker: str) -> list[list[float]]:
    axes: Any = figure.axes[0]
    return [np.array(line.get_data_3d())[:, 0].tolist() for line in axes.lines if line.get_marker() == marker]


@pytest.mark.parametrize("scenario", [*PRESETS.values(), MINE], ids=lambda scenario: scenario.name)
def test_any_scenario_is_drawn_with_units_and_all_that_is_in_it(scenario: Scenario) -> None:
    figure = airspace_figure(scenario, 0)
    axes: Any = figure.axes[0]
    assert [axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()] == ["x (m)", "y (m)", "altitude z (m)"]
    assert marks(figure, "^") == scenario.gbs_positions.tolist()
    assert len(marks(figure, "o")) == len(marks(figure, "*")) == scenario.num_uavs
    assert sum(text.startswith("UAV ") for text in texts(figure)) == scenario.num_uavs
    assert f"{scenario.num_gbs} GBSs" in airspace_caption(scenario)


def test_the_rbs_of_each_uav_are_those_of_the_cells_at_the_origins() -> None:
    figure = airspace_figure(MINE, 0)
    voxels = np.floor(np.array(marks(figure, "o")) / MINE.voxel_size_m).astype(int)
    load = np.bincount(radio_map(MINE).cell[tuple(voxels.T)], minlength=3)
    for gbs, (rbs, uavs) in enumerate(zip(MINE.num_rbs.tolist(), load.tolist(), strict=True)):
        (label,) = [text for text in texts(figure) if text.startswith(f"GBS {gbs}, {rbs} RBs")]
        assert label.endswith(f": {rb_share(rbs, uavs)} RBs each" if uavs else "no UAV")


def test_a_flat_airspace_is_said_to_be_stretched() -> None:
    assert "stretched" not in airspace_caption(PRESETS["paper"])
    assert "stretched" in airspace_caption(PRESETS["tiny"])
