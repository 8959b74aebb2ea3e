"""What each part of a method is worth: ablations held against their defaults, and the report of such a recipe."""

from __future__ import annotations

import pandas as pd

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.recipe import Cell, Recipe
from lawn_sb3.paper.claims import Evidence, judge_all, load_claims
from lawn_sb3.report.document import Report
from lawn_sb3.report.sections import ablation_figure, ablation_learning, scaling
from lawn_sb3.report.sections.claims import claims_table
from lawn_sb3.report.sections.learning import THRESHOLD
from lawn_sb3.report.table import Table, interval_columns
from lawn_sb3.results.pairing import MARK, QUANTITIES, UNKNOWN, Pair, left_out, pair_up, significant
from lawn_sb3.results.results import Results, read_results
from lawn_sb3.results.statistics import Interval, mean_interval

CHANCE = 0.05
"""Share of the effects that would be marked if none were there."""
IMPROVED = ("reward", "utility_mbps")
"""Quantities in which two seeds are rarely level on a test episode, so that they can be held against each other."""

SECTIONS = {
    "What each part is worth": ("effects", "effects_forest"),
    "How fast they learn": ("learning_effects", "learning_curves"),
    "Claims of the paper": ("claims",),
    "Other numbers of UAVs": ("scaling_out", "scaling"),
}
SEARCHED = (
    "All settings were searched for the defaults and for none of their ablations, which a search of their own might "
    "improve; some change more than their name says, see runs/ablation.yaml."
)
CLAIMS_CAPTION = (
    "Claims of the paper on parts of its method; all others are in the report of runs/paper.yaml. How each is "
    "measured, what came out [95 % bootstrap interval over seeds], and the verdict that follows by the rule stated, "
    f"which rests on Welch's t interval. {SEARCHED}"
)


def build_ablation(recipe: Recipe, cells: list[Cell], command: str) -> tuple[Report, Results]:
    """Work out all effects, and how the actors do among more or fewer UAVs.

    :param recipe: a recipe whose methods name their baselines
    :param cells: its cells
    :param command: the command that makes this report again
    :return: the report, and what it was made of
    :raises UserError: if no run can be used
    """
    results = read_results(recipe, cells, ("curves",))
    if not results.methods:
        raise UserError(f"no finished run to report on: {results.problems[0]}; run: lawn-sb3 reproduce first")
    problems = [*results.problems, *left_out(results)]
    rows = scaling.read_scaling(recipe, cells, problems)
    report = Report(recipe, command, SECTIONS, problems)
    if pair_up(results):
        report.tables["effects"] = effects(results)
        report.figures["effects_forest"] = ablation_figure.effects_figure(results), ablation_figure.CAPTION
    if ablation_learning.has_curves(results):
        report.tables["learning_effects"] = ablation_learning.learning_effects(results)
        report.figures["learning_curves"] = ablation_learning.learning_curves(results), ablation_learning.CURVES_CAPTION
    judged = judge_all([claim for claim in load_claims() if claim.needs == "ablation"], Evidence(results))
    if any(finding.verdict != "not testable" for _, finding in judged):
        report.tables["claims"] = claims_table(judged, CLAIMS_CAPTION)
    if len(rows):
        report.tables["scaling"] = scaling.scaling_table(rows, recipe)
        report.figures["scaling_out"] = scaling.scaling_figure(rows, recipe), scaling.caption(rows, recipe)
    return report, results


def effects(results: Results) -> Table:
    """Every ablation minus its default, seed by seed.

    :param results: what the runs left
    :return: a row for each default, with its own figures, and below it one for each of its ablations, from the
        best effect on J to the worst; numbers have ``NAME, NAME_low, NAME_high`` of every quantity
    """
    numbers, shown = [], []
    groups = pair_up(results)
    for baseline, pairs in groups.items():
        for row, cells in (_default_row(results, baseline), *(_effect_row(results, pair) for pair in pairs)):
            numbers.append(row)
            shown.append(cells)
    caption = _caption([pair for pairs in groups.values() for pair in pairs])
    return Table(pd.DataFrame(numbers), pd.DataFrame(shown), caption)


def _default_row(results: Results, key: str) -> tuple[dict[str, object], dict[str, str]]:
    """A default's own figures."""
    by_seed = results.by_seed()
    own = by_seed[by_seed["method"] == key]
    figures = {name: mean_interval(own[name]) for name in QUANTITIES}
    return _row(results, key, results.seeds(key), figures, dict.fromkeys(IMPROVED, UNKNOWN))


def _effect_row(results: Results, pair: Pair) -> tuple[dict[str, object], dict[str, str]]:
    """An ablation's differences to its default."""
    figures = {name: pair.effect(name) for name in QUANTITIES}
    improved = {name: pair.improvement(results, name) for name in IMPROVED}
    return _row(results, pair.key, pair.seeds, figures, improved, pair.baseline)


def _row(
    results: Results,
    key: str,
    seeds: list[int],
    figures: dict[str, Interval],
    improved: dict[str, Interval],
    baseline: str | None = None,
) -> tuple[dict[str, object], dict[str, str]]:
    """A row for machines, and one for readers; one without a baseline is a default's."""
    label, episodes = results.recipe.methods[key].label, results.recipe.evaluation.episodes
    crossing = ablation_learning.median_crossing(results, key, seeds)
    row: dict[str, object] = {
        "method": label,
        "key": key,
        "baseline": baseline or key,
        "is_default": baseline is None,
        "seeds": len(seeds),
        "episodes": episodes,
        **interval_columns(figures | {f"{name}_improvement": found for name, found in improved.items()}),
        "crossing_env_steps": crossing.if_reached,
    }
    cells = {"Method": label if baseline else f"{label} (default)"}
    for name, quantity in QUANTITIES.items():
        unit = f" ({quantity.unit.strip()})" if quantity.unit else ""
        mark = MARK if baseline and significant(figures[name]) else ""
        cells[f"Δ {quantity.symbol}{unit}"] = figures[name].text(quantity.decimals) + mark
        if name in improved:
            cells[f"P(better {quantity.symbol})"] = improved[name].text(2) if baseline else "–"
    cells[f"Env steps to {THRESHOLD:.0f} %"] = crossing.text()
    return row, {**cells, "n": f"{len(seeds)} × {episodes}"}


def _caption(pairs: list[Pair]) -> str:
    """What the table shows, and how many of its marks chance alone would set."""
    known = [pair.effect(name) for pair in pairs for name in QUANTITIES if len(pair.seeds) > 1]
    marked = sum(significant(effect) for effect in known)
    return (
        "Ablations under their defaults, from the best effect on J̄ to the worst. Rows of defaults are their own "
        "figures [95 % bootstrap interval over seeds]. Δ: ablation minus default, seed by seed on the same test "
        "missions, mean over seeds [95 % Student's t interval over these differences, which takes them for normal and "
        "may reach beyond what is possible, such as 100 % success]. †: the interval leaves 0 out. The intervals are "
        f"not corrected for their number: of {len(known)} ({len(pairs)} ablations × {len(QUANTITIES)} quantities) "
        f"{marked} are marked, and up to about {CHANCE * len(known):.0f} would be if no effect were there; all effects "
        "of a group share the default's runs, so such marks come together. T̄: makespan, less is better. U: mean "
        "utility. Collisions: of a UAV in a mission, fewer are better. P(better): probability that a seed of the "
        "ablation does better than one of the default on the same test episode, ties counted half, so that 0.5 is no "
        "difference [95 % bootstrap interval over seeds, which with five seeds holds the true value in about five of "
        "six cases; not counted among the marks]. J̄ counts all terms of the reward, also where training was not given "
        f"one. Env steps: until the first greedy evaluation with {THRESHOLD:.0f} % success, median "
        f"of the seeds. n: seeds × test episodes. {SEARCHED}"
    )
