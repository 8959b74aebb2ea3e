"""Which rows of the paper a recipe may be held to: those that its methods name, if its game is the paper's."""

from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.paper.printed_values import TABLE_II, PaperRow
from lawn_sb3.scenario import PRESETS


def printed_rows(recipe: Recipe) -> dict[str, PaperRow]:
    """The paper's figures to be set beside those of a recipe.

    :param recipe: the recipe
    :return: the row of Table II of each method that names one, by the method's key; none in another game
    """
    if not is_papers_game(recipe):
        return {}
    return {key: TABLE_II[method.paper_row] for key, method in recipe.methods.items() if method.paper_row is not None}


def is_papers_game(recipe: Recipe) -> bool:
    """Whether a recipe plays the paper's game, unchanged."""
    return recipe.game() == PRESETS["paper"]
