"""The ladder: what the UAVs earn by what they know, learners beside planners, and how the learners get there."""

import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lawn_sb3.envs.observation import broadcast_bits
from lawn_sb3.experiment.knowledge import RUNGS, SEES, Rung, bits_of, has_ladder, rung_of
from lawn_sb3.experiment.recipe import Method
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.style import ENV_STEPS, band, colours, in_thousands, line_of, mark_cut, markers, use_house_style
from lawn_sb3.report.table import Table, row_of, sample_of, table_of
from lawn_sb3.results.learning import side_by_side
from lawn_sb3.results.quantities import QUANTITIES
from lawn_sb3.results.results import Results
from lawn_sb3.results.statistics import paired_difference

UTILITY = QUANTITIES["utility_mbps"]
KNOWN: dict[Rung, str] = {
    "nothing": "nothing of\nthe others",
    "loads": "cell loads\n(in $o_i$)",
    "clock": "loads and\nthe own clock",
    "memory": "... and loads\nof 4 slots",
    "destinations": "... and how many\nhead for each cell",
    "intents": "... and positions\nand destinations",
    "state": "all of x",
}
"""What is known on each rung, as the figure has it."""
BESIDE = "forecast"
"""The player that every method is held against."""
LIMITS = ("shortest-path", "forecast", "worst-equilibrium", "welfare", "bound")
"""Players drawn as lines; those of ``LOW_LIMITS`` beside learning curves too."""
LOW_LIMITS = LIMITS[:3]
UTILITY_CURVE = "greedy/utility_mbps"
CURVES = {
    UTILITY_CURVE: UTILITY.axis_label,
    "greedy/regret_mbps": "mean regret (Mbps)",
    "greedy/nash_gap_mbps": "Nash gap (Mbps)",
}
"""What is drawn against env steps, as far as the trainings recorded it."""
LEARNING = (
    "Greedy play during training, on missions apart from the test's, not smoothed; bands: 95 % bootstrap interval of "
    "the mean over seeds. Regret: what a UAV could gain by deviating alone, the others' trajectories fixed; Nash gap: "
    "the largest of an episode, mean over episodes. Lines: players without training on the test missions."
)
"""What the figure of learning curves shows."""


def section(results: Results) -> Section | None:
    """Figure, table and learning curves of a recipe that has a ladder."""
    if not has_ladder(results.methods):
        return None
    parts: dict[str, Table | Picture | None] = {
        "ladder": Picture(_figure(results), _caption(results)),
        "ladder_table": _table(results),
        "ladder_learning": _learning(results),
    }
    return Section("What a UAV must know", parts)


def _table(results: Results) -> Table:
    """What each method knows and what it earns, from the bottom of the ladder to its top."""
    scenario, rows = results.recipe.game(), []
    beside = next((key for key, method in results.methods.items() if method.player == BESIDE), None)
    climbing = sorted(results.methods.items(), key=lambda item: _height(item[1]))  # stable: otherwise in order
    for key, method in climbing:
        rung, bits, steps = rung_of(method), bits_of(method, scenario), method.env_steps or None
        row = row_of(results, key, knows=rung, told_bits=bits, slack=method.slack, env_steps=steps)
        row.cells |= {
            "Knows": "–" if rung is None else KNOWN[rung].replace("\n", " ").replace("$o_i$", "o_i"),
            "Told (bits)": "–" if bits is None else str(bits),
            "Learns": _teaching(method),
            "Slack": "–" if method.slack is None else str(method.slack),
            "Env steps": "–" if steps is None else f"{steps:,}",
        }
        row.add("utility_mbps", UTILITY.heading, results.mean(key, "utility_mbps"), UTILITY.fine_decimals)
        if beside is not None:
            more = paired_difference(results.scores(key, "utility_mbps"), results.scores(beside, "utility_mbps"))
            row.add("over_forecast_mbps", "Δ U to forecast", more, UTILITY.fine_decimals)
            if key == beside:
                row.cells["Δ U to forecast"] = "–"
        row.cells["n"] = sample_of(results, key)
        rows.append(row)
    caption = (
        "What the UAVs know when they act and what they earn, from the bottom of the ladder to its top. Told: bits "
        "that every UAV has to broadcast in every slot, without any coding; cell loads are counted by the GBSs, clock "
        "and memory are a UAV's own. Slack: slots beyond T_min in which a learner may arrive. U: mean utility. Δ: "
        "difference to the planner that takes the loads it sees to stay, on the same missions. In brackets 95 % "
        "bootstrap intervals over training seeds, missions held fixed. Equilibria and welfare are planned jointly, "
        "with all of x known to everybody. n: seeds × test episodes."
    )
    return table_of(rows, caption)


def _height(method: Method) -> tuple[int, bool]:
    rung = rung_of(method)
    return (len(RUNGS) if rung is None else RUNGS.index(rung)), method.player is not None


def _teaching(method: Method) -> str:
    if method.algo is None:
        return "plans"
    return f"from {method.settings.get('teacher', 'mean-field')}" if method.algo == "imitate" else "from scratch"


def _figure(results: Results) -> Figure:
    """What each method earns above what it knows, and lines for players that are limits."""
    use_house_style()
    figure = Figure(figsize=(10.5, 5.4), layout="constrained")
    ax = figure.subplots()
    methods, scenario = results.recipe.methods, results.recipe.game()
    palette, signs = colours(methods), markers(methods)
    points = {key: method for key, method in results.methods.items() if method.player not in LIMITS}
    rungs = [rung for rung in RUNGS if any(rung_of(method) == rung for method in points.values())]
    for place, rung in enumerate(rungs):
        crowd = [key for key, method in points.items() if rung_of(method) == rung]
        for k, key in enumerate(crowd):
            x = place + 0.17 * (k - (len(crowd) - 1) / 2)
            found = results.mean(key, "utility_mbps")
            ax.plot([x, x], [found.low, found.high], color=palette[key], linewidth=1.5)
            ax.plot(x, found.value, signs[key], color=palette[key], markersize=8, markeredgecolor="0.2")
    for key, method in results.methods.items():
        if method.player in LIMITS:
            _limit_line(ax, results, key, palette[key])
    ax.set_xticks(range(len(rungs)), [f"{KNOWN[rung]}\n{broadcast_bits(SEES[rung], scenario)} bits" for rung in rungs])
    ax.set_xlim(-0.5, len(rungs) - 0.5)
    ax.set_xlabel("what a UAV knows, and what each has to broadcast in every slot for it")
    ax.set_ylabel(UTILITY.axis_label)
    mark_cut(ax, y=True)
    handles = [
        Line2D([], [], color=palette[key], marker=signs[key], linestyle="", label=_label_of(method))
        for key, method in points.items()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    sns.despine(figure)
    ax.grid(visible=False, axis="x")
    return figure


def _label_of(method: Method) -> str:
    """What legends call a method: learners may differ in their slack alone."""
    return f"{method.label} (slack {method.slack})" if method.slack else method.label


def _limit_line(ax: Axes, results: Results, key: str, colour: str, inside: bool = False) -> None:
    """Draw the mean utility of a player as a line, named at its end: above the line, or beside the panel."""
    value = float(results.scores(key, "utility_mbps").mean())
    ax.axhline(value, color=colour, linestyle=line_of(key), linewidth=1.2, zorder=1)
    x, across, up = (0.99, "right", "bottom") if inside else (1.0, "left", "center")
    label, edge = f" {results.methods[key].label}", ax.get_yaxis_transform()
    ax.text(x, value, label, color="0.2", fontsize="small", ha=across, va=up, transform=edge)


def _caption(results: Results) -> str:
    steps = sorted({method.env_steps for method in results.methods.values() if method.algo is not None})
    return (
        "Mean utility by what a UAV knows when it acts, and the bits that each UAV has to broadcast in every slot so "
        "that all know it. Learners and planners side by side; lines: players that know nothing, that see the loads, "
        "or that plan jointly, and what the UAVs would earn if each had the network for itself. Bars, where they "
        f"are longer than the markers: 95 % bootstrap interval over seeds, {results.extent(results.episodes)}. "
        f"Learners differ in budget ({', '.join(f'{count:,}' for count in steps)} env steps) and in slack, as the "
        "table says."
    )


def _learning(results: Results) -> Picture | None:
    """A panel for each quantity that any training recorded, and a curve for each learner."""
    curves = results.curves
    shown = {column: text for column, text in CURVES.items() if column in curves and curves[column].notna().any()}
    if not shown:
        return None
    use_house_style()
    figure = Figure(figsize=(1.5 + 4.5 * len(shown), 5.2), layout="constrained")
    palette = colours(results.recipe.methods)
    learners = {key: method for key, method in results.methods.items() if method.algo is not None}
    for ax, (column, text) in zip(figure.subplots(1, len(shown), squeeze=False)[0], shown.items(), strict=True):
        known = side_by_side(curves.dropna(subset=[column]))
        for key in learners:
            own, style = known[known["method"] == key], {"color": palette[key], "errorbar": band}
            if len(own):
                sns.lineplot(own, x="env_steps", y=column, ax=ax, legend=False, **style)
        ax.set(xlabel=ENV_STEPS, ylabel=text)
        in_thousands(ax)
        if ax.get_ylim()[0] > 0.0:
            mark_cut(ax, y=True)
    for key, method in results.methods.items():
        if method.player in LOW_LIMITS and UTILITY_CURVE in shown:
            _limit_line(figure.axes[0], results, key, palette[key], inside=True)
    handles = [Line2D([], [], color=palette[key], label=_label_of(method)) for key, method in learners.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, frameon=False)
    return Picture(figure, LEARNING)
