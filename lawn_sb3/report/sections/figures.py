"""Fig. 2 (training curves) and Fig. 3 (distribution of the utility)."""

from __future__ import annotations

import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lawn_sb3.experiment.recipe import Method
from lawn_sb3.paper.printed_values import TABLE_II
from lawn_sb3.report.cdf import NOT_PLANNERS, distributions, panels_text
from lawn_sb3.report.style import colours, use_house_style
from lawn_sb3.results.curves import WINDOW, smoothed
from lawn_sb3.results.results import Results

QUANTITIES = {"reward": "mean episode reward", "success_percent": "mission success (%)"}
LIMITS = {"reward": (-8.0, 4.2), "success_percent": (-2.0, 102.0)}
"""Ranges of the axes; rewards of the first rollouts can lie below."""
PLANNED = "welfare"
"""The one planner among the dashed lines: the others would lie on top of each other there."""
DASH = 4.0
"""Length of a dash, in line widths."""
SOURCES = {"missions": "training missions, actions sampled", "greedy": "evaluation during training, actions greedy"}

CONVERGENCE_CAPTION = (
    f"Top: missions flown in training, {WINDOW}-point window. A mission that fails takes T_max slots to end and short "
    "ones end often, so this row counts too few failures; it begins once the first mission can have failed. Bottom: "
    "greedy play on missions apart from the test's, not smoothed; it has no such bias. Bands: 95 % bootstrap interval "
    "of the mean over seeds. Dashed: players that do not learn, of the planners only one. Diamonds: the paper's values "
    "after training. Rewards below the axis are those of the first rollouts."
)


def convergence(results: Results) -> Figure:
    """Fig. 2: reward (a) and success (b) against env steps, of training missions and of greedy evaluation.

    :param results: what the runs left
    :return: the figure; bands are 95 % intervals of the mean over seeds, diamonds the paper's final values
    """
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
            ax.set_xlabel("env steps (joint slots of one game)" if row == len(SOURCES) - 1 else "")
            ax.xaxis.set_major_formatter(lambda value, _: f"{value / 1000:.0f}K")
    handles = [
        Line2D([], [], color=palette[key], label=method.label, linestyle="--" if method.player else "-")
        for key, method in _drawn(results).items()
    ]
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


def utility_cdf(results: Results) -> Figure:
    """Fig. 3: empirical distribution F(u) = Pr(U_i <= u) of every UAV's utility.

    :param results: what the runs left
    :return: the figure; a line is all seeds together, its band the range over seeds
    """
    xlabel, ylabel = "utility $U_i$ of a UAV (Mbps); 0 for a failed mission", "$F(u) = \\Pr(U_i \\leq u)$"
    return distributions(results, results.episodes, "utility_mbps", xlabel, ylabel)


def cdf_caption(results: Results) -> str:
    """What Fig. 3 shows.

    :param results: what the runs left
    :return: one paragraph
    """
    return (
        "Share of the UAVs whose utility is at most u: all UAVs of all test episodes and seeds; bands: range over "
        f"seeds. {panels_text(results, results.episodes)}"
        "The paper shows this figure without numbers that could be marked here."
    )
