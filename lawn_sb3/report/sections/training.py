"""Fig. 2: how reward and success rise in training, when success is first high, and what is nearest to the paper's."""

import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lawn_sb3.experiment.knowledge import has_ladder
from lawn_sb3.experiment.recipe import Method
from lawn_sb3.paper.comparable import printed_rows
from lawn_sb3.paper.printed_values import PaperRow
from lawn_sb3.report.cdf import NOT_PLANNERS
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.style import ENV_STEPS, band, colours, in_thousands, mark_cut, use_house_style
from lawn_sb3.report.table import Table, row_of, table_of
from lawn_sb3.results.learning import THRESHOLD, WINDOW, side_by_side, smoothed
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results

DRAWN = {"reward": "mean episode reward", "success_percent": "mission success (%)"}
ZOOMED = {
    "success_percent": "from 90 % on",
    "utility_mbps": "utility",
}
"""Quantities of greedy play that are drawn where the learners differ, and what part of them."""
SUCCESS = (-2.0, 102.0)
LINEAR_REWARD = 5.0
"""Rewards beyond are drawn on a logarithmic scale: those of the first rollouts lie far below."""
REWARD_TICKS = (-50, -20, -10, -5, -2, 0, 2, 4)
HIGH_REWARD_TICKS = (10, 20, 50)
"""Where rewards of long flights come so far."""
HIGH_SUCCESS = (90.0, 100.3)
SETTLED = 0.25
"""Share of a training after which utilities are drawn: before, they are far below."""
PLANNED = "welfare"
"""The one planner among the dashed lines: the others would lie on top of each other there."""
DASH = 4.0
"""Length of a dash, in line widths."""
HEADING_OF = {"missions": "training missions", "greedy": "greedy evaluation"}
SOURCES = {"missions": "training missions, actions sampled", "greedy": "evaluation during training, actions greedy"}

CAPTION = (
    f"(a, b) Missions flown in training, {WINDOW}-point window. A mission that fails takes T_max slots to end and "
    "short ones end often, so these panels count too few failures; they begin once the first mission can have failed. "
    "(c, d) Greedy play on missions apart from the test's, not smoothed; it has no such bias. Rewards below -5 are on "
    "a logarithmic scale. Bottom: greedy play where the learners differ, on axes that are cut (//): success from 90 % "
    "on, if any gets there, and utility after the first quarter of the training. Bands: 95 % bootstrap interval of the "
    "mean over seeds. Dashed: players that do not learn, on the test missions; of the planners only one, which the "
    "utility leaves out."
)
DIAMONDS = " Diamonds: the paper's values after training."


def section(results: Results) -> Section | None:
    """Fig. 2 and its milestones, of curves that are not a ladder's, whose in-time moves always arrive."""
    if has_ladder(results.methods) or not any(f"{source}/success_percent" in results.curves for source in SOURCES):
        return None
    parts: dict[str, Table | Picture | None] = {
        "fig2_convergence": Picture(_figure(results), CAPTION + (DIAMONDS if printed_rows(results.recipe) else "")),
        "first_crossing": _first_crossing(results),
        "nearest_to_paper": _nearest_to_paper(results),
    }
    return Section("Fig. 2: training", parts)


def _figure(results: Results) -> Figure:
    """Reward and success against env steps, of training missions and of greedy play, and that once more close by."""
    use_house_style()
    zoomed = _zoomed(results)
    figure = Figure(figsize=(10, 7 + 3.3 * bool(zoomed)), layout="constrained")
    axes = figure.subplots(len(SOURCES) + bool(zoomed), len(DRAWN), sharex=True)
    palette, letters = colours(results.recipe.methods), iter("abcdef")
    for row, (source, source_text) in enumerate(SOURCES.items()):
        window = WINDOW if source == "missions" else 1
        smoothing = f", {WINDOW}-point window" if window > 1 else ""
        for column, (quantity, quantity_text) in enumerate(DRAWN.items()):
            ax = axes[row, column]
            if row:
                ax.sharey(axes[0, column])
            _draw_curves(ax, results, f"{source}/{quantity}", window, palette)
            _draw_untrained(ax, results, quantity, palette)
            _mark_paper(ax, results, quantity, palette)
            ax.set_title(f"({next(letters)}) {source_text}{smoothing}")
            ax.set_ylabel(quantity_text)
    axes[0, 1].set_ylim(*SUCCESS)
    if results.recipe.game().rate_unit == "lone-uav":  # rewards in Mbps have other ranges
        axes[0, 0].set_yscale("symlog", linthresh=LINEAR_REWARD, linscale=1.5)
        top = axes[0, 0].get_ylim()[1]
        ticks = [*REWARD_TICKS, *(tick for tick in HIGH_REWARD_TICKS if tick <= top)]
        axes[0, 0].set_yticks(ticks, [f"{tick:g}" for tick in ticks])
        axes[0, 0].minorticks_off()
    for ax, (quantity, close_by) in zip(axes[-1], zoomed.items(), strict=False):
        _draw_curves(ax, results, f"greedy/{quantity}", 1, palette)
        _draw_untrained(ax, results, quantity, palette, without=PLANNED if quantity != "success_percent" else None)
        ax.set_ylim(*(HIGH_SUCCESS if quantity == "success_percent" else _settled(results, f"greedy/{quantity}")))
        if ax.get_ylim()[0] > 0.0:
            mark_cut(ax, y=True)
        ax.set_title(f"({next(letters)}) actions greedy, {close_by}")
        ax.set_ylabel(DRAWN.get(quantity) or QUANTITIES[quantity].axis_label)
    lowest = list(axes[-1])
    for column in range(len(zoomed) or len(DRAWN), len(DRAWN)):
        axes[-1, column].remove()
        lowest[column] = axes[-2, column]
    for ax in figure.axes:
        ax.set_xlabel(ENV_STEPS if ax in lowest else "")
        ax.tick_params(labelbottom=ax in lowest)
        in_thousands(ax)
    handles = [
        Line2D([], [], color=palette[key], label=method.label, linestyle="--" if method.player else "-")
        for key, method in _drawn(results).items()
    ]
    if any(key in results.methods for key in printed_rows(results.recipe)):
        handles.append(Line2D([], [], color="0.3", marker="D", linestyle="", label="paper, after training"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _zoomed(results: Results) -> dict[str, str]:
    """Quantities that are drawn close by: success only if some learner's, once settled, is high on average."""
    zoomed = {name: text for name, text in ZOOMED.items() if f"greedy/{name}" in results.curves}
    if "success_percent" in zoomed:
        success = _late_means(results, "greedy/success_percent").groupby("method").mean()
        if not (success >= HIGH_SUCCESS[0]).any():
            del zoomed["success_percent"]
    return zoomed


def _settled(results: Results, column: str) -> tuple[float, float]:
    """The range of a column's means over seeds once trainings have settled, and some room around it."""
    means = _late_means(results, column)
    room = 0.1 * (means.max() - means.min()) + 0.5
    low = means.min() - room
    return float(low if low > 0.0 or means.min() < 0.0 else 0.0), float(means.max() + room)


def _late_means(results: Results, column: str) -> pd.Series:
    """A column's means over seeds by method and env steps, once trainings have settled."""
    curves = results.curves.dropna(subset=[column])
    late = curves[curves["time/env_steps"] >= SETTLED * curves["time/env_steps"].max()]
    means: pd.Series = late.groupby(["method", "time/env_steps"])[column].mean()
    return means


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
    curves = side_by_side(smoothed(results.curves, column, window), "env_steps")
    for key in results.methods:
        own = curves[curves["method"] == key]
        if len(own):
            sns.lineplot(own, x="env_steps", y="value", color=palette[key], ax=ax, errorbar=band, legend=False)


def _draw_untrained(
    ax: Axes, results: Results, quantity: str, palette: dict[str, str], without: str | None = None
) -> None:
    """Players that do not learn, as horizontal lines, one of them perhaps left out."""
    by_seed = results.by_seed()
    players = [key for key, method in _drawn(results).items() if method.player is not None and method.player != without]
    for k, key in enumerate(players):
        # Each fills the gaps of the one before, which may be as high.
        dashes = (DASH * k, (DASH, DASH))
        ax.axhline(by_seed.loc[by_seed["method"] == key, quantity].mean(), color=palette[key], linestyle=dashes)


def _mark_paper(ax: Axes, results: Results, quantity: str, palette: dict[str, str]) -> None:
    """The paper's final value, once a row of its Table II, at the right edge."""
    marked = set()
    for key, row in printed_rows(results.recipe).items():
        if key in results.methods and row not in marked:
            marked.add(row)
            value = getattr(row, quantity)
            edge = ax.get_yaxis_transform()
            ax.plot(1.0, value, "D", color=palette[key], markeredgecolor="0.2", transform=edge, clip_on=False, zorder=5)


def _first_crossing(results: Results) -> Table:
    """When each training first reached 95 % success, by its slowest seed, in training missions and greedy play."""
    rows = []
    for key, method in results.methods.items():
        if method.algo is None or not len(results.curves):
            continue
        own = results.curves[results.curves["method"] == key]
        row = row_of(results, key)
        for source, heading in HEADING_OF.items():
            column = f"{source}/success_percent"
            if column not in own or own[column].isna().all():
                row.cells[heading] = "not measured"
                continue
            seeds = [curve.dropna(subset=[column]) for _, curve in own.groupby("seed")]
            first = [curve.loc[curve[column] >= THRESHOLD, "time/env_steps"].min() for curve in seeds]
            reached = [value for value in first if pd.notna(value)]
            row.numbers |= {f"{source}_seeds": len(first), f"{source}_reached": len(reached)}
            row.cells[heading] = f"{len(reached)} of {len(first)} seeds"
            if len(reached) == len(first):
                at_once = max(reached) <= max(curve["time/env_steps"].min() for curve in seeds)
                row.numbers[f"{source}_env_steps"] = max(reached)
                row.cells[heading] = f"{'at most ' if at_once else ''}{max(reached):,.0f}"
        row.cells["n"] = str(own["seed"].nunique())
        rows.append(row)
    caption = (
        f"Env steps until the first rollout (or greedy evaluation) with {THRESHOLD:.0f} % success, slowest seed"
        f"{'; the paper: about 150 K' if printed_rows(results.recipe) else ''}. At most: that was the first figure "
        "there is. Training missions are not smoothed here and count too few failures early on, as those take longest "
        "to end. n: seeds."
    )
    return table_of(rows, caption)


def _nearest_to_paper(results: Results) -> Table | None:
    """Where on its learning curve a method comes nearest to the success of its row in the paper."""
    rows, columns, in_paper = [], [f"greedy/{name}" for name in PaperRow._fields], printed_rows(results.recipe)
    if not set(columns) <= set(results.curves):
        return None
    for key, method in results.methods.items():
        own = results.curves[results.curves["method"] == key].dropna(subset=columns)
        if method.algo is None or key not in in_paper or not len(own):
            continue
        curve = own.groupby("time/env_steps")[columns].mean()
        printed = in_paper[key]._asdict()
        distance = (curve["greedy/success_percent"] - printed["success_percent"]).abs()
        at = int(distance.to_numpy().argmin())
        row = row_of(results, key, env_steps=curve.index[at])
        row.cells["env steps"] = f"{curve.index[at]:,.0f}"
        for name, paper in printed.items():
            quantity, value = QUANTITIES[name], float(curve.iloc[at][f"greedy/{name}"])
            row.numbers |= {name: value, f"{name}_paper": paper}
            row.cells[quantity.heading] = f"{value:.{quantity.decimals}f} ({paper:.{quantity.decimals}f})"
        row.cells["n"] = str(own["seed"].nunique())
        rows.append(row)
    caption = (
        "Where on its learning curve each learner comes nearest to its success in the paper: greedy evaluation during "
        "training, mean over seeds; in parentheses the paper's final values. n: seeds."
    )
    return table_of(rows, caption)
