"""How fast ablations learn beside their defaults, by greedy success on the way."""

from __future__ import annotations

import numpy as np

from lawn_sb3.report.section import Section
from lawn_sb3.report.table import interval_columns, table_of
from lawn_sb3.results.learning import (
    THRESHOLD,
    greedy_curves,
    has_curves,
    learning_effect,
    mean_success,
    median_crossing,
)
from lawn_sb3.results.pairing import MARK, pair_up, significant
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import UNKNOWN, Interval, mean_interval

HEADING = "How fast they learn"
CAPTION = (
    f"Learning beside the default. Env steps until the first greedy evaluation with {THRESHOLD:.0f} % success: median "
    "of the seeds [fastest to slowest]; a seed that never gets there counts as slower than all others. At most: that "
    "was the first evaluation. Evaluations lie some thousand env steps apart, and what is less apart cannot be told. "
    "Against the default: quotient of the medians. Mean success: greedy success on average over the training (the area "
    "under the curve); of defaults their own [95 % bootstrap interval over seeds], of ablations minus the default's, "
    "seed by seed, over the part of the training that both were watched in [95 % Student's t interval over these "
    "differences]. †: the interval leaves 0 out; not corrected for "
)


def section(results: Results) -> Section | None:
    """How fast each ablation learns.

    :param results: what the runs left
    :return: a table with one row for each default, and below it one for each of its ablations, in the order of the
        table of effects; none if no ablation was watched together with its default
    """
    if not has_curves(results):
        return None
    rows, compared = [], 0
    for baseline, pairs in pair_up(results).items():
        rows.append(_row(results, baseline, baseline, results.seeds(baseline), _level(results, baseline)))
        for pair in pairs:
            effect = learning_effect(results, pair)
            compared += effect.is_known
            rows.append(_row(results, pair.key, baseline, pair.seeds, effect))
    return Section(HEADING, {"learning_effects": table_of(rows, f"{CAPTION}the {compared} comparisons.")})


def _level(results: Results, key: str) -> Interval:
    """A default's own success during training."""
    curves = greedy_curves(results, key, results.seeds(key)).values()
    means = [mean_success(own, own.index[0], own.index[-1]) for own in curves if len(own) > 1]
    return mean_interval(means) if means else UNKNOWN


def _row(
    results: Results, key: str, baseline: str, seeds: list[int], success: Interval
) -> tuple[dict[str, object], dict[str, str]]:
    """A row for machines, and one for readers."""
    label, is_default = results.recipe.methods[key].label, key == baseline
    crossing = median_crossing(results, key, seeds)
    ratio = crossing.if_reached / median_crossing(results, baseline, seeds).if_reached
    reached = int(np.isfinite(crossing.by_seed).sum())
    row: dict[str, object] = {
        "method": label,
        "key": key,
        "baseline": baseline,
        "is_default": is_default,
        "seeds": len(crossing.by_seed),
        "reached": reached,
        "crossing_env_steps": crossing.if_reached,
        "ratio": ratio,
        **interval_columns({"mean_success_percent": success}),
    }
    mark = MARK if not is_default and significant(success) else ""
    cells = {
        "Method": f"{label} (default)" if is_default else label,
        f"Env steps to {THRESHOLD:.0f} %": crossing.text_with_range(),
        "Against the default": "–" if is_default or np.isnan(ratio) else f"× {ratio:.2f}",
        f"Seeds at {THRESHOLD:.0f} %": f"{reached} of {len(crossing.by_seed)}",
        "Δ mean success (points)": "–" if np.isnan(success.value) else success.text(2) + mark,
    }
    return row, cells
