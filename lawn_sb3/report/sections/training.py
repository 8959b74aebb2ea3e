"""Fig. 2: how reward and success rise in training."""

from __future__ import annotations

import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lawn_sb3.experiment.knowledge import has_ladder
from lawn_sb3.experiment.recipe import Method
from lawn_sb3.paper.printed_values import TABLE_II
from lawn_sb3.report.cdf import NOT_PLANNERS
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.style import ENV_STEPS, colours, in_thousands, use_house_style
from lawn_sb3.results.learning import WINDOW, smoothed
from lawn_sb3.results.results import Results

HEADING = "Fig. 2: training"
QUANTITIES = {"reward": "mean episode reward", "success_percent": "mission success (%)"}
LIMITS = {"reward": (-8.0, 4.2), "success_percent": (-2.0, 102.0)}
"""Ranges of the axes; rewards of the first rollouts can lie below."""
PLANNED = "welfare"
"""The one planner among the dashed lines: the others would lie on top of each other there."""
DASH = 4.0
"""Length of a dash, in line widths."""
SOURCES = {"missions": "training missions, actions sampled", "greedy": "evaluation during training, actions greedy"}

CAPTION = (
    f"Top: missions flown in training, {WINDOW}-point window. A mission that fails takes T_max slots to end and short "
    "ones end often, so this row counts too few failures; it begins once the first mission can have failed. Bottom: "
    "greedy play on missions apart from the test's, not smoothed; it has no such bias. Bands: 95 % bootstrap interval "
    "of the mean over seeds. Dashed: players that do not learn, of the planners only one. Diamonds: the paper's values "
    "after training. Rewards below the axis are those of the first rollouts."
)


def section(results: Results) -> Section | None:
    """Fig. 2 of a recipe whose learners have to find out how to arrive."""
    return Section(HEADING, {"fig2_convergence": Picture(_figure(results), CAPTION)}) if shows(results) else None


def shows(results: Results) -> bool:
    """Whether there is anything to see: curves, and not of a ladder, whose in-time moves always arrive.

    :param results: what the runs left
    :return: false without such curves
    """
    return any(f"{source}/success_percent" in results.curves for source in SOURCES) and not has_ladder(results.methods)


def _figure(results: Results) -> Figure:
    """Reward (a) and success (b) against env steps, of training missions and of greedy evaluation."""
    use_house_style()
    figure = Figure(figsize=(10, 7), layout="constrained")
    axes = figure.subplots(len(SOURCES), len(QUANTITIES), sharex=True, sharey="col")
    palette = colours(results.recipe.methods)
    for row, (source, source_text) in enumerate(SOURCES.items()):
        window = WINDOW if source == "missions" else 1
        smoothing = f", {WINDOW}-point window" if window > 1 else ""
        for column, (quantity, quantity_text) in enumerate(QUANTITIES.items()):
            ax = axes[row, column]
            _draw_curves(ax, results, f"{source}/{quantity}", window, palette)
            _draw_untrained(ax, results, quantity, palette)
            _mark_paper(ax, results, quantity, palette)
            if results.recipe.game().rate_unit == "lone-uav":  # rewards in Mbps have other ranges
                ax.set_ylim(*LIMITS[quantity])
            ax.set_title(f"({'ab'[column]}) {source_text}{smoothing}")
            ax.set_ylabel(quantity_text)
            ax.set_xlabel(ENV_STEPS if row == len(SOURCES) - 1 else "")
            in_thousands(ax)
    handles = [
        Line2D([], [], color=palette[key], label=method.label, linestyle="--" if method.player else "-")
        for key, method in _drawn(results).items()
    ]
    if any(method.paper_row for method in results.methods.values()):
        handles.append(Line2D([], [], color="0.3", marker="D", linestyle="", label="paper, after training"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _drawn(results: Results) -> dict[str, Method]:
    """Learners, and the few of the others that stay apart."""
    return {
        key: method
        for key, method in results.methods.items()
        if method.player is None or method.player in (*NOT_PLANNERS, PLANNED)
    }


def _draw_curves(ax: Axes, results: Results, column: str, window: int, palette: dict[str, str]) -> None:
    if column not in results.curves:
        return
    curves = smoothed(results.curves, column, window)
    for key in results.methods:
        own = curves[curves["method"] == key]
        if len(own):
            sns.lineplot(
                own, x="env_steps", y="value", color=palette[key], ax=ax, errorbar=("ci", 95), seed=0, legend=False
            )


def _draw_untrained(ax: Axes, results: Results, quantity: str, palette: dict[str, str]) -> None:
    """Players that do not learn, as horizontal lines."""
    by_seed = results.by_seed()
    players = [key for key, method in _drawn(results).items() if method.player is not None]
    for k, key in enumerate(players):
        # Each fills the gaps of the one before, which may be as high.
        dashes = (DASH * k, (DASH, DASH))
        ax.axhline(by_seed.loc[by_seed["method"] == key, quantity].mean(), color=palette[key], linestyle=dashes)


def _mark_paper(ax: Axes, results: Results, quantity: str, palette: dict[str, str]) -> None:
    """The paper's final value, once a row of its Table II, at the right edge."""
    marked = set()
    for key, method in results.methods.items():
        if method.paper_row and method.paper_row not in marked:
            marked.add(method.paper_row)
            value = getattr(TABLE_II[method.paper_row], quantity)
            edge = ax.get_yaxis_transform()
            ax.plot(1.0, value, "D", color=palette[key], markeredgecolor="0.2", transform=edge, clip_on=False, zorder=5)
