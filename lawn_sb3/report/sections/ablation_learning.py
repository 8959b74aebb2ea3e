"""How fast ablations learn beside their defaults, by greedy success on the way."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lawn_sb3.report.sections.learning import THRESHOLD
from lawn_sb3.report.style import colours, legend_below, panels, title_of, use_house_style
from lawn_sb3.report.table import Table, interval_columns
from lawn_sb3.results.pairing import MARK, Pair, pair_up, significant
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import UNKNOWN, Interval, mean_interval, paired_t

GREEDY = "greedy/success_percent"
DEFAULT_COLOUR = "0.45"

CAPTION = (
    f"Learning beside the default. Env steps until the first greedy evaluation with {THRESHOLD:.0f} % success: median "
    "of the seeds [fastest to slowest]; a seed that never gets there counts as slower than all others. At most: that "
    "was the first evaluation. Evaluations lie some thousand env steps apart, and what is less apart cannot be told. "
    "Against the default: quotient of the medians. Mean success: greedy success on average over the training (the area "
    "under the curve); of defaults their own [95 % bootstrap interval over seeds], of ablations minus the default's, "
    "seed by seed, over the part of the training that both were watched in [95 % Student's t interval over these "
    "differences]. †: the interval leaves 0 out; not corrected for "
)
CURVES_CAPTION = (
    "Greedy success during training on missions apart from the test's: each ablation (in colour) and its default "
    "(grey, dashed), mean over seeds; bands: range over seeds, from the worst to the best. Dotted: "
    f"{THRESHOLD:.0f} %. In the order of the table of effects."
)


class Crossing(NamedTuple):
    """When greedy success is first high."""

    env_steps: float
    """Median of the seeds; infinite if half of them never get there, NaN if it was not measured."""
    by_seed: tuple[float, ...]
    """Of each seed, fastest first; infinite if it never gets there."""
    first: float
    """The first evaluation there is."""
    budget: int

    @property
    def if_reached(self) -> float:
        """The median; NaN where half of the seeds never get there, as machines read no infinity."""
        return self.env_steps if np.isfinite(self.env_steps) else np.nan

    def text(self) -> str:
        """Write the median for a table.

        :return: such as ``26,624``, ``at most 2,048`` or ``> 150,000``
        """
        return "–" if np.isnan(self.env_steps) else self._text(self.env_steps)

    def text_with_range(self) -> str:
        """Write the median with the fastest and the slowest seed.

        :return: such as ``26,624 [20,480 to > 150,000]``
        """
        if len(self.by_seed) < 2:
            return self.text()
        return f"{self.text()} [{self._text(self.by_seed[0])} to {self._text(self.by_seed[-1])}]"

    def _text(self, value: float) -> str:
        if np.isinf(value):
            return f"> {self.budget:,}"
        return f"{'at most ' if value <= self.first else ''}{value:,.0f}"


def greedy_curves(results: Results, method: str, seeds: Iterable[int]) -> dict[int, pd.Series]:
    """The greedy success of a method during training.

    :param results: what the runs left
    :param method: its key in the recipe
    :param seeds: the seeds to look at
    :return: seed: success in percent by env steps, of the seeds that were watched
    """
    curves = results.curves
    if not len(curves) or GREEDY not in curves:
        return {}
    own = curves[curves["method"] == method].dropna(subset=[GREEDY]).set_index("time/env_steps")
    found = {seed: own.loc[own["seed"] == seed, GREEDY] for seed in seeds}
    return {seed: curve for seed, curve in found.items() if len(curve)}


def has_curves(results: Results) -> bool:
    """Whether any ablation was watched together with its default.

    :param results: what the runs left
    :return: true if there is anything to compare
    """
    return any(_watched(results, pair) for pairs in pair_up(results).values() for pair in pairs)


def median_crossing(results: Results, method: str, seeds: Iterable[int]) -> Crossing:
    """When the greedy success of a method is first at 95 %.

    :param results: what the runs left
    :param method: its key in the recipe
    :param seeds: the seeds to look at
    :return: env steps of the median seed, and of all
    """
    budget = results.recipe.methods[method].env_steps
    curves = greedy_curves(results, method, seeds).values()
    if not curves:
        return Crossing(np.nan, (), np.nan, budget)
    found = sorted(float(min(own.index[own >= THRESHOLD], default=np.inf)) for own in curves)
    half = len(found) // 2
    # Not np.median, which makes NaN of two infinite values in the middle.
    middle = found[half] if len(found) % 2 or np.isinf(found[half]) else (found[half - 1] + found[half]) / 2
    return Crossing(middle, tuple(found), float(max(own.index[0] for own in curves)), budget)


def mean_success(curve: pd.Series, begin: float, end: float) -> float:
    """Success on average over a part of the training: the area under the curve, divided by its width.

    :param curve: success in percent by env steps
    :param begin: env steps at which the part begins
    :param end: env steps at which it ends, later; both within the curve
    :return: percent
    """
    steps = curve.index.to_numpy(dtype=np.float64)
    at = np.unique([begin, *steps[(steps > begin) & (steps < end)], end])
    return float(np.trapezoid(np.interp(at, steps, curve.to_numpy()), at) / (end - begin))


def learning_effect(results: Results, pair: Pair) -> Interval:
    """How much more success a method has during training than its default.

    :param results: what the runs left
    :param pair: the two
    :return: difference of the means over the part of the training that both were watched in, in points, with Student's
        t interval over seeds; NaN if they have no such part
    """
    found = []
    for own, other in _watched(results, pair):
        begin, end = max(own.index[0], other.index[0]), min(own.index[-1], other.index[-1])
        if begin < end:
            found.append((mean_success(own, begin, end), mean_success(other, begin, end)))
    return paired_t(*zip(*found, strict=True)) if found else UNKNOWN


def _watched(results: Results, pair: Pair) -> list[tuple[pd.Series, pd.Series]]:
    """The curves of method and default, of each seed that has both."""
    own, other = (greedy_curves(results, key, pair.seeds) for key in (pair.key, pair.baseline))
    return [(own[seed], other[seed]) for seed in pair.seeds if seed in own and seed in other]


def learning_effects(results: Results) -> Table:
    """How fast each ablation learns.

    :param results: what the runs left
    :return: a row for each default, and below it one for each of its ablations, in the order of the table of effects
    """
    numbers, shown = [], []
    compared = 0
    for baseline, pairs in pair_up(results).items():
        rows = [_row(results, baseline, baseline, results.seeds(baseline), _level(results, baseline))]
        for pair in pairs:
            effect = learning_effect(results, pair)
            compared += not np.isnan(effect.low)
            rows.append(_row(results, pair.key, baseline, pair.seeds, effect))
        for row, cells in rows:
            numbers.append(row)
            shown.append(cells)
    return Table(pd.DataFrame(numbers), pd.DataFrame(shown), f"{CAPTION}the {compared} comparisons.")


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


def learning_curves(results: Results) -> Figure:
    """Greedy success of each ablation against env steps, its default behind it.

    :param results: what the runs left
    :return: the figure: a panel an ablation; lines are means over seeds, bands their range
    """
    use_house_style()
    groups = pair_up(results)
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
        ax.xaxis.set_major_formatter(lambda value, _: f"{value / 1000:.0f}K")
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
