"""Fig. 2: what it draws of players that do not learn, and whose curves have nothing to show."""

import pandas as pd
from matplotlib.axes import Axes

from lawn_sb3.report.sections.training import section
from lawn_sb3.report.style import KNOWN
from lawn_sb3.results.results import Results
from tests.handmade import flown, player, recipe_with, results_of
from tests.report.reading import picture_in

PLAYERS = ("random", "shortest-path", "best-route", "equilibrium", "welfare", "bound")


CURVE = {"method": ["learner"], "seed": [0], "time/env_steps": [1], "greedy/success_percent": [50.0]}


def results_with(*players: str) -> Results:
    """One mission each, with rewards 0, 1, 2..."""
    recipe = recipe_with({key: player(key) for key in players})
    flights = (flown(key, 0, reward=[float(k)]) for k, key in enumerate(players))
    return results_of(recipe, *flights, curves=pd.DataFrame(CURVE))


def levels(ax: Axes) -> dict[str, float]:
    """Colour and height of the horizontal lines of a panel."""
    return {str(line.get_color()): float(line.get_ydata()[0]) for line in ax.lines}  # type: ignore[index, arg-type]


def test_of_the_planners_fig_2_draws_one_so_that_no_lines_lie_on_top_of_each_other() -> None:
    figure = picture_in(section(results_with(*PLAYERS)), "fig2_convergence").figure
    expected = {KNOWN["random"]: 0.0, KNOWN["shortest-path"]: 1.0, KNOWN["welfare"]: 4.0}
    assert levels(figure.axes[0]) == levels(figure.axes[2]) == expected  # of training missions, of greedy play
    (legend,) = figure.legends
    labels = [text.get_text() for text in legend.get_texts()]
    assert labels == ["Random", "Shortest-path", "Welfare"]  # none of them has a row in the paper


def test_without_curves_there_is_no_fig_2() -> None:
    without = results_with(*PLAYERS)
    without.curves = pd.DataFrame()
    assert section(without) is None
