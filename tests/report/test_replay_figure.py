"""The picture of a replay: nothing covers anything, however many players stand side by side."""

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from mpl_toolkits.mplot3d import Axes3D  # type: ignore[import-untyped]

from lawn_sb3.experiment.evaluation import fly
from lawn_sb3.experiment.measures import summarize
from lawn_sb3.game.player import RandomPlayer
from lawn_sb3.report.replay_figure import replay_figure
from lawn_sb3.results.tracks import Flown, replay_of, tracks_of
from lawn_sb3.scenario import PRESETS


@pytest.mark.parametrize("players", [1, 2, 4])
def test_the_bar_of_loads_leaves_room_for_the_label_of_z(players: int) -> None:
    game = PRESETS["paper"].changed(max_slots=10)
    flights = fly(RandomPlayer(), game, 2, 0, traced=1)
    tracks = list(tracks_of(game, flights.rows, flights.paths, [0]))
    flown = [Flown("random", f"Random {k}", tracks, summarize(flights.rows)) for k in range(players)]
    figure = replay_figure(replay_of(game, 0, 2, flown))
    renderer = FigureCanvasAgg(figure).get_renderer()  # type: ignore[no-untyped-call]
    figure.draw(renderer)
    labels = [ax.zaxis.label.get_window_extent(renderer) for ax in figure.axes if isinstance(ax, Axes3D)]
    (bar,) = (ax for ax in figure.axes if ax.get_ylabel() == "UAVs in the cell")
    assert len(labels) == players
    assert max(label.x1 for label in labels) < bar.get_window_extent(renderer).x0 - 1.0
