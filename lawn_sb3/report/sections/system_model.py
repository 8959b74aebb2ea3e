"""Fig. 1: the system model, drawn from the scenario."""

from lawn_sb3.report.airspace import airspace_caption, airspace_figure
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.results.results import Results


def section(results: Results) -> Section:
    """The airspace of the recipe's scenario with one mission of each UAV: those of the first test episode."""
    game = results.recipe.game()
    figure = airspace_figure(game, results.recipe.evaluation.seed)
    return Section("Fig. 1: system model", {"fig1_system_model": Picture(figure, airspace_caption(game))})
