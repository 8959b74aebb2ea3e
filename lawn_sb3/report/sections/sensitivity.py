"""How the ranking of methods moves from one changed game to the next: the report of a recipe with variants."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import rankdata

from lawn_sb3.errors import UserError
from lawn_sb3.experiment.recipe import Recipe, cells
from lawn_sb3.report.document import Report
from lawn_sb3.report.style import colours, use_house_style
from lawn_sb3.report.table import Table
from lawn_sb3.results.results import Results, read_results
from lawn_sb3.results.statistics import Interval, mean_interval, paired_difference

QUANTITIES = {"reward": ("J̄", "$\\bar{J}$", 2), "utility_mbps": ("U (Mbps)", "mean utility $U_i$ (Mbps)", 1)}
"""Column of the raw rows: its heading, its axis, its decimals."""


SECTIONS = {"Leads": ("leads",), "Ranking by J̄": ("ranking_reward",), "Ranking by utility": ("ranking_utility_mbps",)}

CAPTION = (
    "Mean over seeds minus the mean of all learning methods in the same changed game, with 95 % bootstrap intervals "
    "over seeds; rows are changed games. Random and shortest path are in the tables."
)


def build_sensitivity(recipe: Recipe, runs: Path, command: str) -> Report:
    """Work out how the ranking moves.

    :param recipe: a recipe with changed games, the first of them the game as it is
    :param runs: the folder of its runs
    :param command: the command that makes this report again
    :return: the report
    :raises UserError: if no run can be used
    """
    read = {name: read_results(own, cells(own, runs / name)) for name, own in recipe.split().items()}
    problems = [f"{name} {problem}" for name, results in read.items() for problem in results.problems]
    whole = {name: results for name, results in read.items() if results.methods}
    if whole and next(iter(read)) not in whole:
        raise UserError(f"no finished run of {next(iter(read))!r}, the game as it is: nothing to compare with")
    if not whole:
        raise UserError(f"no finished run to report on: {problems[0]}; run: lawn-sb3 reproduce first")
    report = Report(recipe, command, SECTIONS, problems)
    for quantity in QUANTITIES:
        report.tables[f"ranking_{quantity}"] = ranking(whole, quantity)
    report.figures["leads"] = leads(whole), CAPTION
    return report


def ranking(variants: Mapping[str, Results], quantity: str) -> Table:
    """Every method's figure and rank in every changed game, and the pairs that change places.

    :param variants: what the runs left, by the name of the changed game; the first is the game as it is
    :param quantity: a key of ``QUANTITIES``
    :return: one row a changed game; numbers have one row a changed game and method
    """
    heading, _, decimals = QUANTITIES[quantity]
    numbers, shown = [], []
    base = next(iter(variants.values()))
    for name, results in variants.items():
        found = {key: mean_interval(results.scores(key, quantity).mean(axis=1)) for key in results.methods}
        ranks = dict(zip(found, rankdata([-own.value for own in found.values()], method="min"), strict=True))
        cells = {"Game": name}
        for key, own in found.items():
            numbers.append({"game": name, "method": key, **own._asdict(), "rank": int(ranks[key])})
            cells[results.methods[key].label] = f"{own.text(decimals)} ({ranks[key]:.0f}.)"
        seeds = {len(results.seeds(key)) for key in results.methods}
        sample = f"{min(seeds)} × {results.recipe.evaluation.episodes}" if seeds else ""
        moved = _changed_places(base, results, quantity) if results is not base else "–"
        shown.append({**cells, "Changed places": moved, "n": sample})
    caption = (
        f"{heading} by changed game: mean over seeds [95 % bootstrap interval] and rank. Changed places: pairs that "
        "are apart in both games, by intervals of the paired difference that leave 0 out, in opposite order. Every "
        "method is trained and tested in the changed game; J̄ is in units of that game, so only its order can be "
        "compared from row to row. n: seeds × test episodes, at least."
    )
    return Table(pd.DataFrame(numbers), pd.DataFrame(shown).fillna("–"), caption)


def _changed_places(base: Results, results: Results, quantity: str) -> str:
    """Pairs of methods whose order is another than in the game as it is, beyond what seeds explain."""
    common = [key for key in results.methods if key in base.methods]
    moved = []
    for one, other in combinations(common, 2):
        before, after = (_order(game, one, other, quantity) for game in (base, results))
        if before * after < 0:
            first, second = (one, other) if after > 0 else (other, one)
            moved.append(f"{results.methods[first].label} above {results.methods[second].label}")
    return "; ".join(moved) or "none"


def _order(results: Results, one: str, other: str, quantity: str) -> int:
    """1 if the first is apart above the second, -1 if below, 0 if they cannot be told apart."""
    found = paired_difference(results.scores(one, quantity), results.scores(other, quantity))
    return int(found.low > 0.0) - int(found.high < 0.0)


def leads(variants: Mapping[str, Results]) -> Figure:
    """Each method's lead in J and U over the mean of the learning methods, by changed game.

    :param variants: what the runs left, by the name of the changed game
    :return: the figure: a point a method with its interval over seeds
    """
    use_house_style()
    figure = Figure(figsize=(10, 1.2 + 0.5 * len(variants)), layout="constrained")
    axes = figure.subplots(1, len(QUANTITIES), sharey=True)
    methods = next(iter(variants.values())).recipe.methods
    learners = [key for key, method in methods.items() if method.algo is not None] or list(methods)
    palette = colours(methods)
    for ax, (quantity, (_, axis, _)) in zip(axes, QUANTITIES.items(), strict=True):
        for row, results in enumerate(variants.values()):
            present = [key for key in learners if key in results.methods]
            if not present:
                continue
            level = np.mean([results.scores(key, quantity).mean() for key in present])
            for place, key in enumerate(learners):
                if key in results.methods:
                    own = mean_interval(results.scores(key, quantity).mean(axis=1) - level)
                    y = row + 0.6 * ((place + 0.5) / len(learners) - 0.5)
                    _point(ax, own, y, palette[key])
        ax.axvline(0.0, color="0.5", linewidth=0.8, zorder=0)
        ax.set_xlabel(f"{axis}, lead over the learners' mean")
        ax.set_yticks(range(len(variants)), list(variants))
        ax.set_ylim(len(variants) - 0.5, -0.5)
        ax.grid(visible=False, axis="y")
        for row in range(1, len(variants), 2):
            ax.axhspan(row - 0.5, row + 0.5, color="0.95", zorder=-1)
    for key in learners:
        axes[0].plot([], [], "o", color=palette[key], label=methods[key].label)
    figure.legend(loc="outside lower center", ncols=len(learners), frameon=False)
    return figure


def _point(ax: Axes, own: Interval, y: float, colour: str) -> None:
    known = not np.isnan(own.low)
    spread = [[own.value - own.low], [own.high - own.value]] if known else None
    ax.errorbar(own.value, y, xerr=spread, fmt="o", markersize=4, color=colour, capsize=2, linewidth=1.2)
