"""How the learners of the ladder get there: utility, regret and Nash gap of greedy play during training."""

from __future__ import annotations

import pandas as pd
import seaborn as sns
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lawn_sb3.experiment.knowledge import has_ladder
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.sections.ladder import HEADING, LIMITS, UTILITY, label_of, limit_line
from lawn_sb3.report.style import ENV_STEPS, colours, in_thousands, use_house_style
from lawn_sb3.results.results import Results

UTILITY_CURVE = "greedy/utility_mbps"
CURVES = {
    UTILITY_CURVE: UTILITY.axis_label,
    "greedy/regret_mbps": "mean regret (Mbps)",
    "greedy/nash_gap_mbps": "Nash gap (Mbps)",
}
"""What is drawn against env steps, as far as the trainings recorded it."""
CAPTION = (
    "Greedy play during training, on missions apart from the test's, not smoothed; bands: 95 % bootstrap interval of "
    "the mean over seeds. Regret: what a UAV could gain by deviating alone, the others' trajectories fixed; Nash gap: "
    "the largest of an episode, mean over episodes. Lines: players without training on the test missions."
)


def section(results: Results) -> Section | None:
    """Curves of a recipe that has a ladder."""
    if not has_ladder(results.methods) or not _recorded(results):
        return None
    return Section(HEADING, {"ladder_learning": Picture(_figure(results), CAPTION)})


def _recorded(results: Results) -> dict[str, str]:
    """Those of ``CURVES`` that any training has."""
    curves = results.curves
    return {column: text for column, text in CURVES.items() if column in curves and curves[column].notna().any()}


def _figure(results: Results) -> Figure:
    """A panel for each quantity and a curve for each learner; bands are 95 % intervals of the mean over seeds."""
    use_house_style()
    shown = _recorded(results)
    figure = Figure(figsize=(1.5 + 4.5 * len(shown), 5.2), layout="constrained")
    palette = colours(results.recipe.methods)
    learners = {key: method for key, method in results.methods.items() if method.algo is not None}
    for ax, (column, text) in zip(figure.subplots(1, len(shown), squeeze=False)[0], shown.items(), strict=True):
        known = _side_by_side(results.curves.dropna(subset=[column]))
        for key in learners:
            own, style = known[known["method"] == key], {"color": palette[key], "errorbar": ("ci", 95), "seed": 0}
            if len(own):
                sns.lineplot(own, x="env_steps", y=column, ax=ax, legend=False, **style)
        ax.set(xlabel=ENV_STEPS, ylabel=text)
        in_thousands(ax)
    for key, method in results.methods.items():
        if method.player in LIMITS[:3] and UTILITY_CURVE in shown:
            limit_line(figure.axes[0], results, key, palette[key], inside=True)
    handles = [Line2D([], [], color=palette[key], label=label_of(method)) for key, method in learners.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _side_by_side(curves: pd.DataFrame) -> pd.DataFrame:
    """Curves in which the k-th evaluation of all seeds of a method lies at one place, the mean of theirs.

    A batch of whole games ends at other env steps in every seed.
    """
    nth = curves.groupby(["method", "seed"]).cumcount()
    at = curves["time/env_steps"].groupby([curves["method"], nth]).transform("mean")
    return curves.assign(env_steps=at)
