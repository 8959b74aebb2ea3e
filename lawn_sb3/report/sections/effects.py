"""What each part of a method is worth: ablations held against their defaults."""

from __future__ import annotations

from lawn_sb3.report.section import Section
from lawn_sb3.report.table import interval_columns, sample_text, table_of
from lawn_sb3.results.learning import THRESHOLD, median_crossing
from lawn_sb3.results.pairing import EFFECTS, MARK, Pair, left_out, pair_up, significant
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import UNKNOWN, Interval, mean_interval

HEADING = "What each part is worth"
CHANCE = 0.05
"""Share of the effects that would be marked if none were there."""
IMPROVED = ("reward", "utility_mbps")
"""Quantities in which two seeds are rarely level on a test episode, so that they can be held against each other."""

SEARCHED = (
    "All settings were searched for the defaults and for none of their ablations, which a search of their own might "
    "improve; some change more than their name says, see runs/ablation.yaml."
)


def section(results: Results) -> Section:
    """Every ablation minus its default, seed by seed.

    :param results: what the runs left
    :return: a table with one row for each default, with its own figures, and below it one for each of its ablations,
        from the best effect on J to the worst; numbers have ``NAME, NAME_low, NAME_high`` of every quantity. Ablations
        without an effect are named among the problems
    """
    groups, rows = pair_up(results), []
    for baseline, pairs in groups.items():
        rows += [_default_row(results, baseline), *(_effect_row(results, pair) for pair in pairs)]
    table = table_of(rows, _caption([pair for pairs in groups.values() for pair in pairs]))
    return Section(HEADING, {"effects": table}, problems=tuple(left_out(results)))


def _default_row(results: Results, key: str) -> tuple[dict[str, object], dict[str, str]]:
    """A default's own figures."""
    by_seed = results.by_seed()
    own = by_seed[by_seed["method"] == key]
    figures = {name: mean_interval(own[name]) for name in EFFECTS}
    return _row(results, key, results.seeds(key), figures, dict.fromkeys(IMPROVED, UNKNOWN))


def _effect_row(results: Results, pair: Pair) -> tuple[dict[str, object], dict[str, str]]:
    """An ablation's differences to its default."""
    figures = {name: pair.effect(name) for name in EFFECTS}
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
    crossing = median_crossing(results, key, seeds)
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
    for name in EFFECTS:
        quantity = QUANTITIES[name]
        mark = MARK if baseline and significant(figures[name]) else ""
        cells[quantity.difference_heading] = figures[name].text(quantity.fine_decimals) + mark
        if name in improved:
            cells[f"P(better {quantity.symbol})"] = improved[name].text(2) if baseline else "–"
    cells[f"Env steps to {THRESHOLD:.0f} %"] = crossing.text()
    return row, {**cells, "n": sample_text(len(seeds), episodes)}


def _caption(pairs: list[Pair]) -> str:
    """What the table shows, and how many of its marks chance alone would set."""
    known = [pair.effect(name) for pair in pairs for name in EFFECTS if len(pair.seeds) > 1]
    marked = sum(significant(effect) for effect in known)
    return (
        "Ablations under their defaults, from the best effect on J̄ to the worst. Rows of defaults are their own "
        "figures [95 % bootstrap interval over seeds]. Δ: ablation minus default, seed by seed on the same test "
        "missions, mean over seeds [95 % Student's t interval over these differences, which takes them for normal and "
        "may reach beyond what is possible, such as 100 % success]. †: the interval leaves 0 out. The intervals are "
        f"not corrected for their number: of {len(known)} ({len(pairs)} ablations × {len(EFFECTS)} quantities) "
        f"{marked} are marked, and up to about {CHANCE * len(known):.0f} would be if no effect were there; all effects "
        "of a group share the default's runs, so such marks come together. T̄: makespan, less is better. U: mean "
        "utility. Collisions: of a UAV in a mission, fewer are better. P(better): probability that a seed of the "
        "ablation does better than one of the default on the same test episode, ties counted half, so that 0.5 is no "
        "difference [95 % bootstrap interval over seeds, which with five seeds holds the true value in about five of "
        "six cases; not counted among the marks]. J̄ counts all terms of the reward, also where training was not given "
        f"one. Env steps: until the first greedy evaluation with {THRESHOLD:.0f} % success, median "
        f"of the seeds. n: seeds × test episodes. {SEARCHED}"
    )
