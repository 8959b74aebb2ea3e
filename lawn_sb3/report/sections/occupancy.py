"""Cell loads over time: how many UAVs fly in a cell alone, and how many share theirs."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pandas as pd
import seaborn as sns
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from lawn_sb3.report.bins import co_served_bounds, most_shown
from lawn_sb3.report.section import Picture, Section
from lawn_sb3.report.style import colours, legend_below, panels, title_of, use_house_style
from lawn_sb3.results.results import Results

FEWEST_SLOTS = 8
"""A panel shows at least so many slots, as far as the deadline lets it."""
DONE_SHARE = 0.01
"""A method counts as done once fewer than this share of its UAVs fly."""


def section(results: Results) -> Section | None:
    """Cell loads of all methods whose UAVs meet."""
    joint = results.without_bound()
    if not len(joint.slots):
        return None
    return Section("Cell loads over time", {"cell_loads": Picture(_figure(joint), _caption(joint))})


def occupancy(results: Results, method: str) -> pd.DataFrame:
    """UAVs that fly in a cell with 1, 2, 3... UAVs, themselves included, in each slot.

    One row a slot from 1 on, the columns ``load_1, load_2...``: means over episodes and seeds.
    """
    own = results.slots[results.slots["method"] == method]
    loads = [f"load_{k}" for k in range(1, results.recipe.game().num_uavs + 1)]
    # A seed whose UAVs are all done has no more rows: nobody of it flies.
    return own.groupby("slot")[loads].sum() / own["seed"].nunique()


def shown_slots(results: Results) -> int:
    """Slots drawn: until less than 1 % of the UAVs fly, with the slowest method that gets there before the deadline."""
    game = results.recipe.game()
    ends = []
    for key in results.methods_in(results.slots):
        flying = occupancy(results, key).sum(axis=1)
        ends.append(int((flying >= DONE_SHARE * game.num_uavs).sum()))
    early = [end for end in ends if end < game.max_slots]
    return min(max([FEWEST_SLOTS, *early]) if early else game.max_slots, game.max_slots)


def _figure(results: Results) -> Figure:
    """A panel for each method; stacked steps are UAVs by the load of their cell, mean over episodes and seeds."""
    use_house_style()
    methods, last, num_uavs = results.methods_in(results.slots), shown_slots(results), results.recipe.game().num_uavs
    palette, by_method = colours(results.recipe.methods), {key: occupancy(results, key) for key in methods}
    seen = [load for loads in by_method.values() for load in range(1, num_uavs + 1) if loads[f"load_{load}"].any()]
    groups = load_groups(most_shown(num_uavs, max(seen, default=1)))
    shades = sns.color_palette("Purples", len(groups) + 1)[1:]  # one hue from light to dark: none is a method's
    figure = Figure(layout="constrained")
    axes = panels(figure, len(methods), 2.3, 2.0, "slot", "UAVs flying\n(mean an episode)")
    for ax, (key, method) in zip(axes, methods.items(), strict=True):
        loads = by_method[key]
        _draw(ax, [loads[[f"load_{k}" for k in group]].sum(axis=1) for group in groups], last, shades)
        _note(ax, loads, last)
        ax.set(xlim=(0.5, last + 0.5), ylim=(0, num_uavs))
        ax.xaxis.set_major_locator(MaxNLocator("auto", steps=[1, 2, 2.5, 5, 10], integer=True))
        title_of(ax, method.label, palette[key])
    handles = [Patch(facecolor=shade, label=_text(loads)) for loads, shade in zip(groups, shades, strict=True)]
    legend_below(figure, handles, 2.0 if max(map(len, groups)) == 1 else 2.6)
    return figure


def load_groups(num_uavs: int) -> list[range]:
    """Cell loads that are drawn as one area: the load 1, then as many as the bins of :func:`co_served_bounds` hold."""
    others = co_served_bounds(num_uavs)
    return [range(1, 2), *(range(int(low) + 2, min(int(high) + 1, num_uavs) + 1) for low, high in pairwise(others))]


def _text(loads: range) -> str:
    if len(loads) == 1:
        return "alone in the cell" if loads[0] == 1 else f"{loads[0]} UAVs in the cell"
    return f"{loads[0]} to {loads[-1]} UAVs in the cell"


def _draw(ax: Axes, areas: list[pd.Series], last: int, shades: Sequence[tuple[float, float, float]]) -> None:
    edges, base = np.arange(0.5, last + 1), np.zeros(last)
    for area, shade in zip(areas, shades, strict=True):
        top = base + area.reindex(range(1, last + 1), fill_value=0.0).to_numpy()
        ax.stairs(top, edges, baseline=base, fill=True, facecolor=shade, edgecolor="white", linewidth=0.4)
        base = top


def _note(ax: Axes, loads: pd.DataFrame, last: int) -> None:
    """Say how much of what is drawn is shared, and what goes on beyond it."""
    flying = loads.sum(axis=1)
    share = 100.0 * (1.0 - loads["load_1"].iloc[:last].sum() / flying.iloc[:last].sum())
    notes = [f"{share:.0f} % shared"]
    if len(flying) > last and flying.iloc[last] >= DONE_SHARE * len(loads.columns):
        notes.append(f"{flying.iloc[-1]:.1f} still fly in slot {len(flying)}")
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "boxstyle": "round,pad=0.2"}
    ax.text(0.96, 0.93, "\n".join(notes), transform=ax.transAxes, ha="right", va="top", fontsize="small", bbox=box)


def _caption(results: Results) -> str:
    return (
        "UAVs that fly alone in their cell, or share it, slot by slot: mean over "
        f"{results.extent(results.slots)}. The share in a panel is that of the flying time in these slots which UAVs "
        "spend in a cell with others."
    )
