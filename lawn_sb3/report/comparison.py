"""Some runs beside each other: a table with intervals and differences, and one figure."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from lawn_sb3.report.style import colours, error_bars, markers, use_house_style
from lawn_sb3.report.table import Row, Table, sample_text, table_of
from lawn_sb3.results.at_hand import COMPARED, DIFFERENCES, Contestant, marks_among
from lawn_sb3.results.quantities import QUANTITIES

PANELS = ("reward", "success_percent", "makespan_slots", "utility_mbps")


def comparison_table(compared: Sequence[Contestant]) -> Table:
    """Hold runs against the first of them.

    :param compared: at least two, which flew the same missions
    :return: one row for each: means with intervals, and how much more the others have than the first
    """
    marks, tests = marks_among(compared)
    rows = []
    for one in compared:
        episodes = one.rows["episode"].nunique()
        row = Row(
            {"method": one.title, "key": one.key, "seeds": len(one.seeds), "episodes": episodes},
            {"Method": one.title, "n": sample_text(len(one.seeds), episodes)},
        )
        for name in COMPARED:
            row.add(name, QUANTITIES[name].heading, one.mean(name), QUANTITIES[name].decimals)
        for name in DIFFERENCES:
            test = tests.get((one.title, name))
            if test is not None:
                mark = marks.mark(*test)
                row.add(f"{name}_difference", _heading(name), test.interval, QUANTITIES[name].fine_decimals, mark)
                row.numbers[f"{name}_p"] = test.p_value
            else:
                row.cells[_heading(name)] = "–"
        rows.append(row)
    return table_of(rows, _caption(compared))


def comparison_figure(compared: Sequence[Contestant]) -> Figure:
    """Draw runs beside each other: a panel for each quantity, in it a point with its interval for each."""
    use_house_style()
    keys = [f"{one.key} {k}" if _repeats(compared, one) else one.key for k, one in enumerate(compared)]
    palette, signs = colours(keys), markers(keys)
    figure = Figure(figsize=(2.0 + 2.1 * len(PANELS), 1.1 + 0.38 * len(compared)), layout="constrained")
    axes = figure.subplots(1, len(PANELS), sharey=True)
    places = np.arange(len(compared))[::-1]
    for ax, name in zip(axes, PANELS, strict=True):
        for one, key, place in zip(compared, keys, places, strict=True):
            found = one.mean(name)
            bars = error_bars(found)
            ax.errorbar(found.value, place, xerr=bars, fmt=signs[key], color=palette[key], capsize=3, markersize=6)
        ax.set_xlabel(QUANTITIES[name].axis_label)
        ax.margins(x=0.15)
    axes[0].set_yticks(places, [one.title for one in compared])
    axes[0].set_ylim(-0.6, len(compared) - 0.4)
    return figure


def _heading(name: str) -> str:
    return QUANTITIES[name].difference_heading


def _repeats(compared: Sequence[Contestant], one: Contestant) -> bool:
    return sum(other.key == one.key for other in compared) > 1


def _caption(compared: Sequence[Contestant]) -> str:
    """What the intervals are over."""
    single = min(len(one.seeds) for one in compared) == 1
    means = "Means [95 %: bootstrap over seeds" + ("; with one seed t over missions]" if single else "]")
    over = (
        "paired t over missions, which says nothing of other seeds, where either has one seed, else t over seeds and "
        "missions"
        if single
        else "t over seeds and missions"
    )
    return (
        f"{means}. Δ: less {compared[0].title} on the same missions [95 %: {over}]; † leaves 0 out, ‡ also after "
        "Holm's correction over all Δ here."
    )
