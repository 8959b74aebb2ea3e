"""How fast ablations learn beside their defaults, by greedy success on the way: a table, and the curves."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.style import colours, in_thousands, legend_below, panels, title_of, use_house_style
from lawn_sb3.report.table import Row, Table, row_of, table_of
from lawn_sb3.results.learning import (
    THRESHOLD,
    greedy_curves,
    has_curves,
    learning_effect,
    mean_success,
    median_crossing,
)
from lawn_sb3.results.pairing import Marks, Pair, pair_up
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import UNKNOWN, Interval, mean_interval

CAPTION = (
    f"Learning beside the default. Env steps until the first greedy evaluation with {THRESHOLD:.0f} % success: median "
    "of the seeds [fastest to slowest]; a seed that never gets there counts as slower than all others. At most: that "
    "was the first evaluation. Evaluations lie some thousand env steps apart, and what is less apart cannot be told. "
    "Against the default: quotient of the medians. Mean success: greedy success on average over the training (the area "
    "under the curve); of defaults their own [95 % bootstrap interval over seeds], of ablations minus the default's, "
    "seed by seed, over the part of the training that both were watched in [95 % Student's t interval over these "
    "differences]. †: the interval leaves 0 out. ‡: it also passes Holm's correction over the {tested} comparisons at "
    "5 %, as {sure} do, or all seeds agree; conclusions rest on ‡ alone."
)
"""What the table shows, to be filled with the number of comparisons."""
DEFAULT_COLOUR = "0.45"
CURVES = (
    "Greedy success during training on missions apart from the test's: each ablation (in colour) and its default "
    "(grey, dashed), mean over seeds; bands: range over seeds, from the worst to the best. Dotted: "
    f"{THRESHOLD:.0f} %. In the order of the table of effects."
)
"""What the figure shows."""


def section(results: Results) -> Section | None:
    """How fast each ablation learns that was watched together with its default."""
    if not has_curves(results):
        return None
    groups = pair_up(results)
    figure = Picture(_figure(results, groups), CURVES)
    return Section("How fast they learn", {"learning_effects": _table(results, groups), "learning_curves": figure})


def _table(results: Results, groups: dict[str, list[Pair]]) -> Table:
    """One row for each default, and below it one for each of its ablations, in the order of the table of effects."""
    effects = {pair.key: learning_effect(results, pair) for pairs in groups.values() for pair in pairs}
    marks, rows = Marks(list(effects.values())), []
    for baseline, pairs in groups.items():
        rows.append(_row(results, baseline, baseline, results.seeds(baseline), _level(results, baseline)))
        for pair in pairs:
            effect, p_value = effects[pair.key]
            row = _row(results, pair.key, baseline, pair.seeds, effect, marks.mark(effect, p_value))
            row.numbers |= {"mean_success_percent_p": p_value, "sure": marks.is_sure(effect, p_value)}
            rows.append(row)
    return table_of(rows, CAPTION.format(tested=marks.num_tested, sure=marks.num_sure))


def _level(results: Results, key: str) -> Interval:
    """A default's own success during training."""
    curves = greedy_curves(results, key, results.seeds(key)).values()
    means = [mean_success(own, own.index[0], own.index[-1]) for own in curves if len(own) > 1]
    return mean_interval(means) if means else UNKNOWN


def _row(results: Results, key: str, baseline: str, seeds: list[int], success: Interval, mark: str = "") -> Row:
    is_default, crossing = key == baseline, median_crossing(results, key, seeds)
    ratio = crossing.if_reached / median_crossing(results, baseline, seeds).if_reached
    reached, watched = int(np.isfinite(crossing.by_seed).sum()), len(crossing.by_seed)
    row = row_of(results, key, baseline=baseline, is_default=is_default, seeds=watched, reached=reached)
    row.numbers |= {"crossing_env_steps": crossing.if_reached, "ratio": ratio}
    if is_default:
        row.cells["Method"] += " (default)"
    row.cells |= {
        f"Env steps to {THRESHOLD:.0f} %": crossing.text_with_range(),
        "Against the default": "–" if is_default or np.isnan(ratio) else f"× {ratio:.2f}",
        f"Seeds at {THRESHOLD:.0f} %": f"{reached} of {watched}",
    }
    row.add("mean_success_percent", "Δ mean success (points)", success, 2, after=mark)
    return row


def _figure(results: Results, groups: dict[str, list[Pair]]) -> Figure:
    """A panel for each ablation; lines are means over seeds, bands their range."""
    use_house_style()
    pairs = [pair for own in groups.values() for pair in own]
    palette = colours(groups)
    figure = Figure(layout="constrained")
    axes = panels(figure, len(pairs), 2.25, 1.6, "env steps", "success (%)")
    for ax, pair in zip(axes, pairs, strict=True):
        colour = palette[pair.baseline]
        ax.axhline(THRESHOLD, color="0.5", linestyle=":", linewidth=0.8)
        _draw(ax, greedy_curves(results, pair.baseline, pair.seeds), DEFAULT_COLOUR, "--")
        _draw(ax, greedy_curves(results, pair.key, pair.seeds), colour, "-")
        title_of(ax, results.recipe.methods[pair.key].label, colour)
        ax.set_ylim(-2, 102)
        in_thousands(ax)
    handles = [
        Line2D([], [], color=palette[key], label=f"ablation of {results.recipe.methods[key].label}") for key in groups
    ]
    legend_below(figure, [*handles, Line2D([], [], color=DEFAULT_COLOUR, linestyle="--", label="its default")], 2.3)
    return figure


def _draw(ax: Axes, curves: dict[int, pd.Series], colour: str, style: str) -> None:
    """Mean and range over seeds, where all of them were watched."""
    if curves:
        together = pd.DataFrame(curves).dropna()  # one column a seed
        steps = together.index.to_numpy()
        ax.fill_between(steps, together.min(axis=1), together.max(axis=1), color=colour, alpha=0.25, linewidth=0)
        ax.plot(steps, together.mean(axis=1), color=colour, linestyle=style, linewidth=1.3)
