"""What each kind of report shows, in the order of the page: a recipe's, one of ablations, one of changed games."""

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.cell import Cell
from lawn_sb3.experiment.recipe import Recipe
from lawn_sb3.paper.checks import read_checks
from lawn_sb3.paper.comparable import printed_rows
from lawn_sb3.report.document import Report
from lawn_sb3.report.section import Section
from lawn_sb3.report.sections import (
    effects,
    ladder,
    leads,
    learning_speed,
    low_utilities,
    occupancy,
    optimum,
    ranking,
    sampling,
    scaling_out,
    system_model,
    table_one,
    table_two,
    training,
    trajectories,
    utility_cdf,
    verdicts,
)
from lawn_sb3.results.results import TABLES, Results, read_results
from lawn_sb3.results.spent import time_spent
from lawn_sb3.results.tracks import replay_of_results


class Kind(NamedTuple):
    """A kind of report."""

    sections: tuple[Callable[[Any], Section | None], ...]
    """Of :class:`Results`, or of those of each changed game by its name."""
    main: str
    """File name of the table that says most."""
    main_title: str
    """What it shows."""
    tables: Collection[str] = TABLES
    """Tables of the results that its sections need beside the evaluations."""


OF_RECIPE = Kind(
    (
        table_two.section,
        ladder.section,
        verdicts.section,
        training.section,
        utility_cdf.section,
        optimum.section,
        occupancy.section,
        low_utilities.section,
        trajectories.section,
        sampling.section,
        scaling_out.section,
        system_model.section,
        table_one.section,
    ),
    "table2",
    "Table II",
)
IN_PARENTHESES = "; the paper's values in parentheses"
"""What the title of Table II says where there are any."""
OF_ABLATIONS = Kind(
    (effects.section, learning_speed.section, verdicts.section, scaling_out.section),
    "effects",
    "effect of each ablation on its default",
    tables=("curves", "scaling", "costs"),
)
OF_CHANGED_GAMES = Kind(
    (leads.section, partial(ranking.section, "reward"), partial(ranking.section, "utility_mbps")),
    "ranking_reward",
    "J̄ by changed game",
)


def build_report(recipe: Recipe, cells: Sequence[Cell], command: str) -> Report:
    """Work out all tables, figures and verdicts.

    :param recipe: the recipe
    :param cells: its cells
    :param command: the command that makes this report again
    :return: the report
    :raises UserError: if no run can be used, or none of the game as it is
    """
    kind = OF_CHANGED_GAMES if recipe.variants else OF_ABLATIONS if recipe.is_ablation else OF_RECIPE
    games = {
        name: read_results(own, [cell for cell in cells if cell.variant == name], kind.tables)
        for name, own in recipe.split().items()
    }
    if kind is OF_RECIPE:
        for results in games.values():
            results.checks = read_checks(recipe, cells, results.problems)
    problems = [problem for results in games.values() for problem in results.problems]
    whole = {name: results for name, results in games.items() if results.methods}
    if not whole:
        raise UserError(f"no finished run to report on: {problems[0]}; run: lawn-sb3 reproduce first")
    base = next(iter(games))
    if base not in whole:
        raise UserError(f"no finished run of {base!r}, the game as it is: nothing to compare with")
    given: Results | Mapping[str, Results] = whole if recipe.variants else whole[base]
    sections = [section for make in kind.sections if (section := make(given)) is not None]
    return Report(
        recipe,
        command,
        sections,
        kind.main,
        kind.main_title + (IN_PARENTHESES if kind is OF_RECIPE and printed_rows(recipe) else ""),
        [*problems, *(problem for section in sections for problem in section.problems)],
        [sentence for section in sections for sentence in section.summary],
        None if recipe.variants else replay_of_results(whole[base]),
        time_spent(cells),
    )
